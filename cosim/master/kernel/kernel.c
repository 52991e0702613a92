/* Running the plan: one program of operations a tick, in chunks of ticks. */

#include "kernel.h"

static void copy(Cell *cells, const int32_t *pairs, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        cells[pairs[2 * i + 1]] = cells[pairs[2 * i]];
}

static void convert(Cell *cells, const Conversion *conversions, int64_t count)
{
    for (int64_t i = 0; i < count; i++) {
        const Conversion *c = &conversions[i];
        double value = c->from_integer ? (double)cells[c->source].integer : cells[c->source].real;
        cells[c->target].real = value * c->gain + c->offset;
    }
}

static bool record(Record *target, const Cell *cells, const int32_t *columns, int64_t count)
{
    if (target->row >= target->row_count)
        return false;
    Cell *row = target->rows + target->row * count;
    for (int64_t i = 0; i < count; i++)
        row[i] = cells[columns[i]];
    target->row++;
    return true;
}

/* A foreign FMU may change how the processor computes, mostly in its first calls. Looking costs more
   than a small FMU's step, so that after some ticks it is done once a tick; who was found to change
   it is looked at after every call from then on. */
static void look_at_mode(Kernel *kernel)
{
    if (kernel_restore_float_mode(kernel->float_mode))
        kernel->careful = INT64_MAX;
}

static void guard(Kernel *kernel, const Instance *instance)
{
    if (kernel->careful && instance->foreign)
        look_at_mode(kernel);
}

/* Runs the rest of the current program. */
static Outcome execute(Kernel *kernel)
{
    const int32_t *program = kernel->program + kernel->program_start[kernel->running];
    int64_t count = kernel->program_start[kernel->running + 1]
                  - kernel->program_start[kernel->running];
    Cell *cells = kernel->cells;

    while (kernel->position < count) {
        int32_t number = program[kernel->position++];
        const Operation *op = &kernel->operations[number];
        Instance *instance;
        Outcome outcome = OUTCOME_DONE;
        kernel->kind = op->kind;
        kernel->owner = op->owner;
        switch (op->kind) {
        case KIND_COPY:
            copy(cells, op->table, op->cell_count);
            break;
        case KIND_CONVERT:
            convert(cells, op->table, op->cell_count);
            break;
        case KIND_SET_FLOAT64:
        case KIND_SET:
            instance = &kernel->instances[op->owner];
            outcome = set_values(kernel, op, instance->instance, &instance->warnings);
            guard(kernel, instance);
            break;
        case KIND_GET_FLOAT64:
        case KIND_GET:
            instance = &kernel->instances[op->owner];
            outcome = get_values(kernel, op, instance->instance, &instance->warnings);
            guard(kernel, instance);
            break;
        case KIND_STEP:
            instance = &kernel->instances[op->owner];
            outcome = do_step(kernel, instance);
            guard(kernel, instance);
            break;
        case KIND_CALL:
            outcome = OUTCOME_CALL;
            break;
        case KIND_DELIVER:
            deliver(&kernel->bundles[op->owner], kernel->tick);
            break;
        case KIND_SAMPLE:
            if (kernel->bundles[op->owner].immediate)
                copy(cells, op->table, op->cell_count);
            break;
        case KIND_SEND:
            if (!send_packet(&kernel->bundles[op->owner], cells, kernel->tick))
                outcome = OUTCOME_OVERFLOW;
            break;
        case KIND_RECORD:
            if (!record(&kernel->records[op->owner], cells, op->table, op->cell_count))
                outcome = OUTCOME_OVERFLOW;
            break;
        case KIND_TUNE:
            outcome = tune(kernel, op);
            break;
        default:
            break;
        }
        if (outcome != OUTCOME_DONE) {
            kernel->operation = number;
            return outcome;
        }
    }
    return OUTCOME_DONE;
}

EXPORT int64_t kernel_abi(void)
{
    return KERNEL_ABI;
}

/* Runs ticks until `end`; resumes where a call-out left off. */
EXPORT int32_t kernel_run(Kernel *kernel, int64_t end)
{
    kernel->float_mode = kernel_float_mode();
    while (kernel->tick < end) {
        if (kernel->running < 0) {
            kernel->running = kernel->tick == 0 ? kernel->first_program
                                                : kernel->pattern[kernel->phase];
            kernel->position = 0;
            apply_changes(kernel);
        }
        Outcome outcome = execute(kernel);
        if (outcome != OUTCOME_DONE)
            return outcome;
        if (kernel->has_foreign)
            look_at_mode(kernel);
        if (kernel->careful && kernel->careful < INT64_MAX)
            kernel->careful--;
        kernel->running = -1;
        kernel->tick++;
        if (++kernel->phase == kernel->hyperperiod)
            kernel->phase = 0;
    }
    return OUTCOME_DONE;
}

/* Runs one program outside the ticks (initialisation mode). */
EXPORT int32_t kernel_evaluate(Kernel *kernel, int64_t program)
{
    kernel->float_mode = kernel_float_mode();
    if (kernel->running != program) {
        kernel->running = program;
        kernel->position = 0;
    }
    Outcome outcome = execute(kernel);
    if (outcome == OUTCOME_DONE)
        kernel->running = -1;
    return outcome;
}
