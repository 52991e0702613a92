/* Running the plan: one program of operations a tick, in chunks of ticks. */

#include "direct.h"

static inline void copy(Cell *cells, const int32_t *pairs, int64_t count)
{
    for (const int32_t *end = pairs + 2 * count; pairs != end; pairs += 2)
        cells[pairs[1]] = cells[pairs[0]];
}

/* A whole number that no double is, stays one in the cell of what it was for. */
static Outcome convert(Kernel *kernel, const Conversion *conversions, int64_t count)
{
    Cell *cells = kernel->cells;
    for (int64_t i = 0; i < count; i++) {
        const Conversion *c = &conversions[i];
        double value = cells[c->source].real;
        if (c->from_integer) {
            const int64_t whole = cells[c->source].integer;
            value = (double)whole;
            if (value >= 0x1p63 || (int64_t)value != whole) {
                cells[c->target].integer = whole;
                kernel->cell = c->target;
                return OUTCOME_RANGE;
            }
        }
        cells[c->target].real = value * c->gain + c->offset;
    }
    return OUTCOME_DONE;
}

static inline Outcome record(Record *target, const Cell *cells, const Operation *op)
{
    if (target->row >= target->row_count)
        return OUTCOME_OVERFLOW;
    const int64_t count = op->cell_count;
    const int32_t *columns = op->table;
    Cell *row = target->rows + target->row * count;
    for (int64_t i = 0; i < count; i++)
        row[i] = cells[columns[i]];
    target->row++;
    return OUTCOME_DONE;
}

/* Rows of a table at the outputs of a component: the first before the first row's time, the last after
   the last one's. */
static void search(Played *played, double tick)
{
    const double *times = played->times;
    const int64_t last = played->count - 1;
    int64_t row = played->row;
    while (row > 0 && times[row] > tick)
        row--;
    while (row < last && times[row + 1] <= tick)
        row++;
    played->row = row;
}

static void play(Cell *cells, Played *played, double tick)
{
    search(played, tick);
    const int64_t row = played->row, width = played->width;
    const double *before = played->rows + row * width, *after = before + width;
    const double since = tick - played->times[row];
    if (!played->is_linear || row == played->count - 1 || since <= 0.0) {
        for (int64_t i = 0; i < width; i++)
            cells[i].real = before[i];
        return;
    }
    const double share = since / (played->times[row + 1] - played->times[row]);
    for (int64_t i = 0; i < width; i++)
        cells[i].real = before[i] + (after[i] - before[i]) * share;
}

/* A foreign FMU may change how the processor computes, mostly in its first calls. Looking costs more
   than a small FMU's step, so that after some ticks it is done once a tick; who was found to change
   it is looked at after every call from then on. Our own FMUs are never looked at. */
static void look_at_mode(Kernel *kernel)
{
    if (kernel_restore_float_mode(kernel->float_mode))
        kernel->careful = INT64_MAX;
}

static inline Outcome step(Kernel *kernel, const Operation *op, double time)
{
    Instance *instance = op->instance;
    return op->kind == KIND_STEP ? step_once(kernel, instance, op->version, time)
         : instance->events      ? step_with_events(kernel, instance)
                                 : step_in_parts(kernel, instance);
}

/* What does not come in runs, or has to be looked after. */
static __attribute__((noinline)) Outcome carry_out(Kernel *kernel, const Operation *op, double time)
{
    Cell *const cells = kernel->cells;
    switch (op->kind) {
    case KIND_COPY:
        copy(cells, op->table, op->cell_count);
        return OUTCOME_DONE;
    case KIND_CONVERT:
        return convert(kernel, op->table, op->cell_count);
    case KIND_SET_FLOAT64:
        return set_reals(kernel, op, op->instance);
    case KIND_GET_FLOAT64:
        return get_reals(kernel, op, op->instance);
    case KIND_STEP:
    case KIND_STEP_IN_PARTS:
        return step(kernel, op, time);
    case KIND_SET:
        return set_values(kernel, op, op->instance);
    case KIND_GET:
        return get_values(kernel, op, op->instance);
    case KIND_CALL:
        return OUTCOME_CALL;
    case KIND_DELIVER:
        deliver(&kernel->bundles[op->owner], kernel->tick);
        return OUTCOME_DONE;
    case KIND_SAMPLE:
        if (kernel->bundles[op->owner].immediate)
            copy(cells, op->table, op->cell_count);
        return OUTCOME_DONE;
    case KIND_SEND:
        return send_packet(&kernel->bundles[op->owner], cells, kernel->tick) ? OUTCOME_DONE
                                                                             : OUTCOME_OVERFLOW;
    case KIND_TUNE:
        return tune(kernel, op);
    case KIND_PLAY:
        play(op->cells, (Played *)op->table, (double)kernel->tick);
        return OUTCOME_DONE;
    default:
        return OUTCOME_DONE;
    }
}

static inline Outcome do_one(Kernel *kernel, const Operation *op, double time)
{
    kernel->owner = op->owner;
    return op->kind == KIND_RECORD ? record(&kernel->records[op->owner], kernel->cells, op)
                                   : carry_out(kernel, op, time);
}

/* Operations one by one, each with a look at how the processor computes. */
static __attribute__((noinline)) Outcome carefully(Kernel *kernel, const Operation **reached,
                                                   const Operation *end, double time)
{
    for (const Operation *op = *reached; op != end; op++) {
        Outcome outcome = do_one(kernel, op, time);
        if (op->instance && op->instance->foreign && kernel->careful)
            look_at_mode(kernel);
        if (outcome != OUTCOME_DONE) {
            *reached = op;
            return outcome;
        }
    }
    return OUTCOME_DONE;
}

/* Runs the rest of the current program. */
WRITTEN_OUT Outcome execute(Kernel *kernel)
{
    const int64_t *const program = &kernel->program_start[kernel->running];
    const Run *const runs = kernel->runs + program[0], *const end = kernel->runs + program[1];
    const double time = time_of_tick(kernel);

    for (const Run *run = runs + kernel->position; run != end; run++) {
        const Operation *op = run->first;
        Outcome outcome;
        kernel->kind = op->kind;
        if (op->kind == KIND_SET_FLOAT64)
            copy_before(kernel->cells, op, run->end - 1);
        if (SELDOM(kernel->careful != 0))
            outcome = carefully(kernel, &op, run->end, time);
        else if (op->kind == KIND_SET_FLOAT64)
            outcome = op->version == 2 ? access_run(kernel, &op, run->end, 2, false)
                                       : access_run(kernel, &op, run->end, 3, false);
        else if (op->kind == KIND_GET_FLOAT64)
            outcome = op->version == 2 ? access_run(kernel, &op, run->end, 2, true)
                                       : access_run(kernel, &op, run->end, 3, true);
        else if (op->kind == KIND_STEP)
            outcome = op->version == 2 ? step_run(kernel, &op, run->end, 2, time)
                                       : step_run(kernel, &op, run->end, 3, time);
        else
            outcome = do_one(kernel, op, time);
        if (SELDOM(outcome != OUTCOME_DONE)) {
            kernel->position = run - runs + 1; /* what is left after a call-out */
            kernel->operation = op - kernel->operations;
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
            if (kernel->next_change < kernel->change_count)
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
