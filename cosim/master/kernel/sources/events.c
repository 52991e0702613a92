/* What happens at an event of an FMU in event mode, and the steps between events.

   What is read at an event lies in cells of its own until the FMU's outputs are read. */

#include "direct.h"
#include "events.h"

enum { MOST_UPDATES = 1000 }; /* at one time, and returns from one step */

static Outcome change_mode(Kernel *kernel, Instance *instance, void *function, EventCall call)
{
    kernel->event_call = call;
    return judge_call(kernel, instance, ((ModeCall)function)(instance->instance));
}

static Outcome access(Kernel *kernel, Instance *instance, const EventAccess *access, bool is_set)
{
    const Operation *op = &kernel->operations[access->operation];
    kernel->event_call = is_set ? EVENT_CALL_SET : EVENT_CALL_GET;
    Outcome outcome = is_set                           ? set_values(kernel, op, instance)
                    : op->kind == KIND_GET_FLOAT64 ? get_reals(kernel, op, instance)
                                                       : get_values(kernel, op, instance);
    if (outcome == OUTCOME_DONE)
        kernel->event_call = EVENT_CALL_NONE;
    return outcome;
}

static bool has_changed(const Operation *op, const EventAccess *access)
{
    for (int64_t i = 0; i < op->cell_count; i++)
        if (op->cells[i].integer != access->before[i].integer)
            return true;
    return false;
}

static Outcome set_changed(Kernel *kernel, Instance *instance)
{
    Events *e = instance->events;
    for (int64_t i = 0; i < e->set_count; i++) {
        const Operation *op = &kernel->operations[e->sets[i].operation];
        if (e->sets[i].clocks != 0 || !has_changed(op, &e->sets[i]))
            continue;
        Outcome outcome = access(kernel, instance, &e->sets[i], true);
        if (outcome != OUTCOME_DONE)
            return outcome;
        for (int64_t j = 0; j < op->cell_count; j++)
            e->sets[i].before[j] = op->cells[j];
    }
    return OUTCOME_DONE;
}

/* Inputs, or outputs, of clocks that tick. */
static Outcome access_clocked(Kernel *kernel, Instance *instance, int64_t active, bool is_set)
{
    Events *e = instance->events;
    const EventAccess *each = is_set ? e->sets : e->gets;
    const EventAccess *end = each + (is_set ? e->set_count : e->get_count);
    Outcome outcome = OUTCOME_DONE;
    for (; outcome == OUTCOME_DONE && each < end; each++)
        if (each->clocks & active)
            outcome = access(kernel, instance, each, is_set);
    return outcome;
}

/* Everything at one time, in event mode: instants follow until none is needed any more. */
static Outcome iterate(Kernel *kernel, Instance *instance, Instant now, int64_t active)
{
    Events *e = instance->events;
    Outcome outcome = set_changed(kernel, instance);
    for (int64_t count = 0; outcome == OUTCOME_DONE; count++) {
        Truth again = 0, terminate = 0, nominals = 0, states = 0, has_next = 0;
        double next = 0.0;
        const int64_t given = active;
        if (count == MOST_UPDATES)
            return event_fault(kernel, EVENT_FAULT_NO_END, -1, (double)count);
        if ((outcome = activate_clocks(kernel, instance, active)) != OUTCOME_DONE
            || (outcome = access_clocked(kernel, instance, active, true)) != OUTCOME_DONE
            || (outcome = ask_clocks(kernel, instance, &active)) != OUTCOME_DONE
            || (outcome = access_clocked(kernel, instance, active & ~given, true)) != OUTCOME_DONE)
            return outcome;
        count_ticks(instance->events, active, now.step + (now.beyond > 0.0));
        if ((outcome = access_clocked(kernel, instance, active, false)) != OUTCOME_DONE)
            return outcome;
        kernel->event_call = EVENT_CALL_UPDATE;
        outcome = judge_call(kernel, instance,
                        ((UpdateStates)e->update)(instance->instance, &again, &terminate, &nominals,
                                                  &states, &has_next, &next));
        if (outcome != OUTCOME_DONE)
            return outcome;
        if (has_next && __builtin_isnan(next))
            return event_fault(kernel, EVENT_FAULT_NO_TIME, -1, next);
        e->next->real = has_next ? next : __builtin_inf(); /* one that has passed: at once */
        if (terminate)
            return OUTCOME_TERMINATED;
        outcome = ask_intervals(kernel, instance, now, active);
        active = due_clocks(e, now.step);
        if (!again && active == 0)
            break;
    }
    return outcome;
}

static Outcome event(Kernel *kernel, Instance *instance, Instant now, int64_t active)
{
    Events *e = instance->events;
    Outcome outcome = change_mode(kernel, instance, e->enter, EVENT_CALL_ENTER);
    if (outcome == OUTCOME_DONE)
        outcome = iterate(kernel, instance, now, active);
    if (outcome == OUTCOME_DONE)
        outcome = change_mode(kernel, instance, e->leave, EVENT_CALL_LEAVE);
    return outcome;
}

/* Clocks that others trigger, inputs that have changed, and parameters that were turned. */
static Outcome before_step(Kernel *kernel, Instance *instance, int64_t step)
{
    Events *e = instance->events;
    int64_t active = 0;
    bool is_due = e->turned != 0;
    e->turned = 0;
    for (int64_t i = 0; i < e->clock_count; i++) {
        EventClock *clock = &e->clocks[i];
        if (clock->input && clock->input->integer != clock->cells[CLOCK_SEEN].integer) {
            clock->cells[CLOCK_SEEN] = *clock->input;
            active |= (int64_t)1 << i;
        }
    }
    for (int64_t i = 0; i < e->set_count; i++)
        is_due = is_due || (e->sets[i].clocks == 0
                            && has_changed(&kernel->operations[e->sets[i].operation], &e->sets[i]));
    return is_due || active ? event(kernel, instance, (Instant){step, 0.0}, active) : OUTCOME_DONE;
}

/* One step of the grid, in as many parts as the FMU's events within it need. */
static Outcome follow(Kernel *kernel, Instance *instance, int64_t step, double begin, double end)
{
    Events *e = instance->events;
    const double margin = 1e-9 * instance->step;
    double at = begin;
    for (int64_t count = 0;; count++) {
        Truth needs_event = 0, terminate = 0, early = 0;
        double next = e->next->real;
        bool is_split = e->may_return && next > at + margin && next < end - margin;
        double target = is_split ? next : end, last = target;
        double length = at == begin && !is_split ? instance->step : target - at;
        if (count == MOST_UPDATES)
            return event_fault(kernel, EVENT_FAULT_RETURNS, -1, (double)count);
        Outcome outcome = judge_status(
            kernel,
            ((Step3)instance->do_step)(instance->instance, at, length, true, &needs_event,
                                       &terminate, &early, &last),
            &instance->warnings);
        if (outcome != OUTCOME_DONE)
            return outcome;
        if (terminate)
            return OUTCOME_TERMINATED;
        if (early && !e->may_return)
            return OUTCOME_EARLY_RETURN;
        if (early && !(last >= at - margin && last <= target + margin))
            return event_fault(kernel, EVENT_FAULT_TIME, -1, last);
        at = early ? last : target;
        needs_event = needs_event || e->next->real <= at + margin;
        if (at >= end - margin) {
            int64_t active = due_clocks(e, step + 1);
            return needs_event || active
                     ? event(kernel, instance, (Instant){step + 1, 0.0}, active)
                     : OUTCOME_DONE;
        }
        if (needs_event) {
            outcome = event(kernel, instance, (Instant){step, at - begin}, 0);
            if (outcome != OUTCOME_DONE)
                return outcome;
        }
    }
}

Outcome step_with_events(Kernel *kernel, Instance *instance)
{
    const int64_t first = kernel->tick / instance->period * instance->substeps;
    Outcome outcome = before_step(kernel, instance, first);
    for (int64_t i = 0; outcome == OUTCOME_DONE && i < instance->substeps; i++)
        outcome = follow(kernel, instance, first + i, time_of_part(kernel, instance, i),
                         time_of_part(kernel, instance, i + 1));
    age_clocks(instance, first + instance->substeps);
    return outcome;
}

static Outcome begin(Kernel *kernel, Instance *instance)
{
    Events *e = instance->events;
    Outcome outcome = OUTCOME_DONE;
    e->next->real = __builtin_inf();
    e->turned = 0;
    for (int64_t i = 0; outcome == OUTCOME_DONE && i < e->clock_count; i++)
        outcome = wind_up(kernel, instance, i);
    for (int64_t i = 0; outcome == OUTCOME_DONE && i < e->get_count; i++)
        if (e->gets[i].at_start)
            outcome = access(kernel, instance, &e->gets[i], false);
    return outcome;
}

static Outcome leave_first(Kernel *kernel, Instance *instance)
{
    Events *e = instance->events;
    for (int64_t i = 0; i < e->set_count; i++) { /* they were set in initialisation mode */
        const Operation *op = &kernel->operations[e->sets[i].operation];
        for (int64_t j = 0; e->sets[i].clocks == 0 && j < op->cell_count; j++)
            e->sets[i].before[j] = op->cells[j];
    }
    for (int64_t i = 0; i < e->clock_count; i++)
        if (e->clocks[i].input)
            e->clocks[i].cells[CLOCK_SEEN] = *e->clocks[i].input;
    Outcome outcome = iterate(kernel, instance, (Instant){0, 0.0}, due_clocks(e, 0));
    if (outcome == OUTCOME_DONE)
        outcome = change_mode(kernel, instance, e->leave, EVENT_CALL_LEAVE);
    age_clocks(instance, 0);
    return outcome;
}

EXPORT int32_t kernel_begin_events(Kernel *kernel, int64_t owner, int64_t phase)
{
    Instance *instance = &kernel->instances[owner];
    kernel->running = 0; /* as initialisation mode */
    kernel->kind = KIND_STEP_IN_PARTS;
    kernel->owner = (int32_t)owner;
    kernel->event_call = EVENT_CALL_NONE;
    Outcome outcome = phase == 0 ? begin(kernel, instance) : leave_first(kernel, instance);
    if (outcome == OUTCOME_DONE)
        kernel->running = -1;
    return outcome;
}
