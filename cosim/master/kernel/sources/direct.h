/* What the loop does most: reals that go between cells and an FMU as they are, and steps. In a header,
   so that the loop calls nothing but the FMU: it is as fast as the same calls written out. */

#ifndef COHAPTIC_DIRECT_H
#define COHAPTIC_DIRECT_H

#include "kernel.h"

#define WRITTEN_OUT static inline __attribute__((always_inline))
#define MOSTLY(CONDITION) __builtin_expect(CONDITION, 1)
#define SELDOM(CONDITION) __builtin_expect(CONDITION, 0)

/* `version` is that of the operation: a constant where the caller knows it. */
static inline int call_access(const Operation *op, int version, void *instance, void *values)
{
    size_t references = (size_t)op->reference_count;
    if (version == 2)
        return ((Access2)op->function)(instance, op->references, references, values);
    return ((Access3)op->function)(instance, op->references, references, values,
                                   (size_t)op->cell_count);
}

static inline Outcome judge_status(Kernel *kernel, int status, int64_t *warnings)
{
    if (__builtin_expect(status == STATUS_OK, 1))
        return OUTCOME_DONE;
    if (status == STATUS_WARNING) {
        ++*warnings;
        return OUTCOME_DONE;
    }
    kernel->status = status;
    return OUTCOME_STATUS;
}

static inline Outcome refuse_nan(Kernel *kernel, const Operation *op)
{
    for (const Cell *cell = op->cells, *end = cell + op->cell_count; cell != end; cell++)
        if (__builtin_expect(cell->real != cell->real, 0)) {
            kernel->cell = cell - kernel->cells;
            return OUTCOME_NOT_A_NUMBER;
        }
    return OUTCOME_DONE;
}

static inline Outcome get_reals(Kernel *kernel, const Operation *op, Instance *instance)
{
    int status = call_access(op, op->version, instance->instance, op->cells);
    Outcome outcome = judge_status(kernel, status, &instance->warnings);
    return outcome == OUTCOME_DONE ? refuse_nan(kernel, op) : outcome;
}

static inline Outcome set_reals(Kernel *kernel, const Operation *op, Instance *instance)
{
    int status = call_access(op, op->version, instance->instance, op->cells);
    return judge_status(kernel, status, &instance->warnings);
}

static inline Outcome step_once(Kernel *kernel, Instance *instance, int version, double time)
{
    int status;
    if (version == 2) {
        status = ((Step2)instance->do_step)(instance->instance, time, instance->step, 1);
    } else {
        Truth event = 0, terminate = 0, early_return = 0;
        double last_time = time;
        status = ((Step3)instance->do_step)(instance->instance, time, instance->step, true, &event,
                                            &terminate, &early_return, &last_time);
        if (status <= STATUS_WARNING && early_return)
            return OUTCOME_EARLY_RETURN;
        if (status <= STATUS_WARNING && terminate)
            return OUTCOME_TERMINATED;
    }
    return judge_status(kernel, status, &instance->warnings);
}

/* The time (s) of a tick: a ratio of integers that are exact in a double, so it is rounded once. */
static inline double time_of_tick(const Kernel *kernel)
{
    int64_t tick = kernel->start_tick + kernel->tick;
    return (double)(tick * kernel->tick_numerator) / (double)kernel->tick_denominator;
}

/* The time (s) at which a part of an instance's period begins, rounded once, as that of a tick. */
static inline double time_of_part(const Kernel *kernel, const Instance *instance, int64_t part)
{
    int64_t ticks = (kernel->start_tick + kernel->tick) * instance->substeps
                  + part * instance->period;
    return (double)(ticks * kernel->tick_numerator)
         / (double)(instance->substeps * kernel->tick_denominator);
}

/* After a call that did not go as most do. */
static inline __attribute__((noinline, cold)) Outcome look_closer(Kernel *kernel,
                                                                  const Operation *op, int status)
{
    Outcome outcome = judge_status(kernel, status, &op->instance->warnings);
    return outcome == OUTCOME_DONE && op->kind == KIND_GET_FLOAT64 ? refuse_nan(kernel, op) : outcome;
}

/* The first and the last cell are mostly all that there are. */
static inline bool has_nan(const Operation *op)
{
    const Cell *cell = op->cells, *last = cell + op->cell_count - 1;
    bool found = __builtin_isunordered(cell->real, last->real);
    if (op->cell_count > 2)
        while (!found && ++cell < last)
            found = __builtin_isunordered(cell->real, cell->real);
    return found;
}

/* The copies before a run of sets: their pairs lie side by side, so that they are made in one go. */
static inline void copy_before(Cell *cells, const Operation *first, const Operation *last)
{
    const int32_t *const end = (const int32_t *)last->table + 2 * last->copy_count;
    for (const int32_t *pair = first->table; pair != end; pair += 2)
        cells[pair[1]] = cells[pair[0]];
}

/* Most operations come in runs: many FMUs are read, set and stepped in turn. Each loop is written out
   for one version of FMI, and calls nothing but the FMU unless something happened. Where it ends
   before the run does, `reached` is the operation that failed. */

/* Sets or gets of reals. */
WRITTEN_OUT Outcome access_run(Kernel *kernel, const Operation **reached, const Operation *end,
                               int version, bool is_get)
{
    for (const Operation *op = *reached; op != end; op++) {
        kernel->owner = op->owner;
        int status = call_access(op, version, op->instance->instance, op->cells);
        if (MOSTLY(status == STATUS_OK && !(is_get && has_nan(op))))
            continue;
        Outcome outcome = look_closer(kernel, op, status);
        if (outcome != OUTCOME_DONE) {
            *reached = op;
            return outcome;
        }
    }
    return OUTCOME_DONE;
}

WRITTEN_OUT Outcome step_run(Kernel *kernel, const Operation **reached, const Operation *end,
                             int version, double time)
{
    for (const Operation *op = *reached; op != end; op++) {
        kernel->owner = op->owner;
        Outcome outcome = step_once(kernel, op->instance, version, time);
        if (MOSTLY(outcome == OUTCOME_DONE))
            continue;
        *reached = op;
        return outcome;
    }
    return OUTCOME_DONE;
}

#endif
