/* Most operations come in runs: many FMUs are read, set and stepped in turn. Each loop is written out
   for one version of FMI, and calls nothing but the FMU unless something happened. Where it ends
   before the run does, `reached` is the operation that failed. */

#ifndef COHAPTIC_RUNS_H
#define COHAPTIC_RUNS_H

#include "direct.h"

#define WRITTEN_OUT static inline __attribute__((always_inline))
#define MOSTLY(CONDITION) __builtin_expect(CONDITION, 1)
#define SELDOM(CONDITION) __builtin_expect(CONDITION, 0)

/* After a call that did not go as most do. */
static __attribute__((noinline, cold)) Outcome look_closer(Kernel *kernel, const Operation *op,
                                                           int status)
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
