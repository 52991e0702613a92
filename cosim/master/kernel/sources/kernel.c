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

static inline void guard(Kernel *kernel, const Instance *instance)
{
    if (__builtin_expect(kernel->careful != 0, 0) && instance->foreign)
        look_at_mode(kernel);
}

/* Operations of one kind mostly follow one another: so many FMUs are read, set and stepped in turn,
   and to go on within a kind costs less than to find out which one it is. Where it ends before the
   run does, `op` is left at the operation that failed. */
#define RUN(NAME, DOES)                                                                           \
    static __attribute__((noinline)) Outcome NAME(Kernel *kernel, const Operation **failed,       \
                                                  int64_t count, double time)                     \
    {                                                                                             \
        const Operation *op = *failed;                                                            \
        Instance *const instances = kernel->instances;                                            \
        (void)time;                                                                               \
        for (const Operation *end = op + count; op != end; op++) {                                \
            Instance *instance = &instances[op->owner];                                           \
            kernel->owner = op->owner;                                                            \
            Outcome outcome = DOES;                                                               \
            guard(kernel, instance);                                                              \
            if (__builtin_expect(outcome != OUTCOME_DONE, 0)) {                                   \
                *failed = op;                                                                     \
                return outcome;                                                                   \
            }                                                                                     \
        }                                                                                         \
        return OUTCOME_DONE;                                                                      \
    }

static inline Outcome copy_and_set(Kernel *kernel, const Operation *op, Instance *instance)
{
    copy(kernel->cells, op->table, op->copy_count);
    return set_reals(kernel, op, instance);
}

static inline Outcome step(Kernel *kernel, Instance *instance, double time)
{
    return __builtin_expect(instance->is_plain, 1) ? step_once(kernel, instance, time)
         : instance->events                        ? step_with_events(kernel, instance)
                                                   : step_in_parts(kernel, instance);
}

RUN(set_run, copy_and_set(kernel, op, instance))
RUN(get_run, get_reals(kernel, op, instance))
RUN(step_run, step(kernel, instance, time))

/* Runs the rest of the current program. */
static Outcome execute(Kernel *kernel)
{
    const int64_t start = kernel->program_start[kernel->running];
    const int32_t *const program = kernel->program + start;
    const int32_t *const run_length = kernel->run_length + start;
    const int64_t count = kernel->program_start[kernel->running + 1] - start;
    int64_t position = kernel->position; /* written back where the loop is left */
    Cell *const cells = kernel->cells;
    const double time = time_of_tick(kernel);

    while (position < count) {
        const int32_t number = program[position];
        const Operation *const first = &kernel->operations[number], *op = first;
        const int64_t length = run_length[position];
        Instance *instance;
        Outcome outcome = OUTCOME_DONE;
        kernel->kind = op->kind;
        kernel->owner = op->owner;
        switch (op->kind) {
        case KIND_COPY:
            copy(cells, op->table, op->cell_count);
            break;
        case KIND_CONVERT:
            outcome = convert(kernel, op->table, op->cell_count);
            break;
        case KIND_SET_FLOAT64:
            outcome = set_run(kernel, &op, length, time);
            break;
        case KIND_GET_FLOAT64:
            outcome = get_run(kernel, &op, length, time);
            break;
        case KIND_STEP:
            outcome = step_run(kernel, &op, length, time);
            break;
        case KIND_SET:
            instance = &kernel->instances[op->owner];
            outcome = set_values(kernel, op, instance);
            guard(kernel, instance);
            break;
        case KIND_GET:
            instance = &kernel->instances[op->owner];
            outcome = get_values(kernel, op, instance);
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
        case KIND_PLAY:
            play(op->cells, (Played *)op->table, (double)kernel->tick);
            break;
        default:
            break;
        }
        if (__builtin_expect(outcome != OUTCOME_DONE, 0)) {
            kernel->position = position + (op - first) + 1;
            kernel->operation = number + (op - first);
            return outcome;
        }
        position += length;
    }
    kernel->position = position;
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
