/* What is turned while the plan runs: parameters between two steps of a component, and channels. */

#include "events.h"

/* The events of the tick that begins. */
void apply_changes(Kernel *kernel)
{
    while (kernel->next_change < kernel->change_count
           && kernel->changes[kernel->next_change].tick <= kernel->tick) {
        const Change *change = &kernel->changes[kernel->next_change++];
        kernel->cells[change->cell] = change->value;
    }
}

/* What is wanted comes into force, and is told to whom it concerns, where it is not in force yet. */
Outcome tune(Kernel *kernel, const Operation *op)
{
    const Knob *knob = op->table;
    bool changed = false;
    for (int64_t i = 0; i < op->cell_count; i++)
        changed = changed || knob->wanted[i].integer != op->cells[i].integer;
    if (!changed)
        return OUTCOME_DONE;
    for (int64_t i = 0; i < op->cell_count; i++) {
        const Cell cell = knob->wanted[i];
        const double value = knob->is_real ? cell.real : (double)cell.integer;
        const bool is_named = knob->item_count == 0
                              || is_among(cell.integer, knob->items, knob->item_count);
        /* A NaN is no value, either. */
        if (!is_named || !(value >= knob->minimum && value <= knob->maximum)) {
            kernel->cell = &knob->wanted[i] - kernel->cells;
            return OUTCOME_RANGE;
        }
        op->cells[i] = cell;
    }
    if (knob->by_call)
        return OUTCOME_CALL;
    if (op->function == NULL)
        return OUTCOME_DONE; /* a Python component reads the cells */
    Instance *instance = op->instance;
    const Outcome outcome = set_values(kernel, op, instance);
    if (instance->events)
        instance->events->turned = 1;
    if (instance->foreign)
        kernel_restore_float_mode(kernel->float_mode);
    return outcome;
}
