/* The clocks of an FMU in event mode: when they tick, and who says so.

   A time is a number of steps of the FMU since the run began, so that clocks tick on the grid of its
   steps. */

#include "direct.h"
#include "events.h"

enum { NOT_KNOWN = 0, UNCHANGED = 1, CHANGED = 2 };

Outcome judge_call(Kernel *kernel, Instance *instance, int status)
{
    Outcome outcome = judge_status(kernel, status, &instance->warnings);
    if (outcome == OUTCOME_DONE)
        kernel->event_call = EVENT_CALL_NONE;
    return outcome;
}

Outcome event_fault(Kernel *kernel, EventFault fault, int64_t which, double value)
{
    kernel->event_fault = fault;
    kernel->event_clock = which;
    kernel->event_value = value;
    return OUTCOME_EVENT;
}

/* Whole steps in a time (s), or -1. What was written in decimals is not exact. */
static int64_t whole_steps(const Instance *instance, double time)
{
    double ratio = time / instance->step;
    if (!(ratio >= 0.0 && ratio < 4e15))
        return -1;
    int64_t nearest = (int64_t)(ratio + 0.5);
    double off = ratio - (double)nearest;
    return (off < 0 ? -off : off) <= 1e-9 * (1.0 + ratio) ? nearest : -1;
}

/* The interval of a clock, where the FMU has one to tell; `told` says how it was told. */
static Outcome ask_interval(Kernel *kernel, Instance *instance, int64_t number, Instant now,
                            int *told)
{
    EventClock *clock = &instance->events->clocks[number];
    const bool is_periodic = clock->kind <= CLOCK_KIND_TUNABLE;
    double interval = 0.0;
    *told = NOT_KNOWN;
    kernel->event_call = EVENT_CALL_GET_INTERVAL;
    IntervalAccess ask = (IntervalAccess)instance->events->get_interval;
    Outcome outcome = judge_call(kernel, instance,
                                 ask(instance->instance, clock->reference, 1, &interval, told));
    if (outcome != OUTCOME_DONE || *told == NOT_KNOWN)
        return outcome;
    if (*told != UNCHANGED && *told != CHANGED)
        return event_fault(kernel, EVENT_FAULT_NO_INTERVAL, number, (double)*told);
    bool is_known = clock->kind == CLOCK_KIND_COUNTDOWN
                 || (is_periodic && clock->cells[CLOCK_INTERVAL].integer >= 0);
    if (*told == UNCHANGED && is_known)
        return OUTCOME_DONE;
    int64_t until = interval == 0.0 ? 0 : whole_steps(instance, now.beyond + interval);
    int64_t length = is_periodic ? whole_steps(instance, interval) : 0;
    if (until < 0 || (is_periodic && length <= 0))
        return event_fault(kernel, EVENT_FAULT_OFF_GRID, number, interval);
    clock->cells[CLOCK_INTERVAL].integer = length;
    clock->cells[CLOCK_DUE].integer = now.step + until;
    return OUTCOME_DONE;
}

/* What a clock's interval is asked for after it has ticked, or in every event mode. */
Outcome ask_intervals(Kernel *kernel, Instance *instance, Instant now, int64_t ticked)
{
    Events *e = instance->events;
    for (int64_t i = 0; i < e->clock_count; i++) {
        EventClock *clock = &e->clocks[i];
        bool has_ticked = (ticked >> i & 1) != 0;
        bool is_asked = clock->kind == CLOCK_KIND_COUNTDOWN || clock->kind == CLOCK_KIND_TUNABLE
                     || (clock->kind == CLOCK_KIND_CHANGING && has_ticked);
        if (!is_asked)
            continue;
        int told;
        Outcome outcome = ask_interval(kernel, instance, i, now, &told);
        if (outcome != OUTCOME_DONE)
            return outcome;
        if (clock->kind == CLOCK_KIND_CHANGING && told == NOT_KNOWN)
            return event_fault(kernel, EVENT_FAULT_NO_INTERVAL, i, 0.0);
    }
    return OUTCOME_DONE;
}

/* Lets clocks tick. */
Outcome activate_clocks(Kernel *kernel, Instance *instance, int64_t clocks)
{
    Events *e = instance->events;
    for (int64_t i = 0; i < e->clock_count; i++) {
        if ((clocks >> i & 1) == 0)
            continue;
        EventClock *clock = &e->clocks[i];
        Truth active = 1;
        kernel->event_call = EVENT_CALL_SET_CLOCK;
        ClockAccess set = (ClockAccess)e->set_clock;
        Outcome outcome =
            judge_call(kernel, instance, set(instance->instance, clock->reference, 1, &active));
        if (outcome != OUTCOME_DONE)
            return outcome;
        Cell *cells = clock->cells;
        cells[CLOCK_DUE].integer = clock->kind <= CLOCK_KIND_TUNABLE
                                     ? cells[CLOCK_DUE].integer + cells[CLOCK_INTERVAL].integer
                                     : -1;
    }
    return OUTCOME_DONE;
}

/* Adds the clocks of which the FMU says that they tick; one may belong to another one. */
Outcome ask_clocks(Kernel *kernel, Instance *instance, int64_t *active)
{
    Events *e = instance->events;
    int64_t asked = 0, before;
    do {
        before = *active;
        for (int64_t i = 0; i < e->clock_count; i++) {
            EventClock *clock = &e->clocks[i];
            if (clock->kind != CLOCK_KIND_TOLD || (asked >> i & 1)
                || (clock->of && !(clock->of & *active)))
                continue;
            Truth ticks = 0;
            kernel->event_call = EVENT_CALL_GET_CLOCK;
            ClockAccess get = (ClockAccess)e->get_clock;
            Outcome outcome =
                judge_call(kernel, instance, get(instance->instance, clock->reference, 1, &ticks));
            if (outcome != OUTCOME_DONE)
                return outcome;
            asked |= (int64_t)1 << i;
            *active |= (int64_t)(ticks != 0) << i;
        }
    } while (*active != before);
    return OUTCOME_DONE;
}

/* The clocks whose time has come. */
int64_t due_clocks(const Events *e, int64_t step)
{
    int64_t clocks = 0;
    for (int64_t i = 0; i < e->clock_count; i++) {
        int64_t when = e->clocks[i].cells[CLOCK_DUE].integer;
        if (e->clocks[i].kind < CLOCK_KIND_TRIGGERED && when >= 0 && when <= step)
            clocks |= (int64_t)1 << i;
    }
    return clocks;
}

void count_ticks(Events *e, int64_t clocks, int64_t step)
{
    for (int64_t i = 0; i < e->clock_count; i++)
        if (clocks >> i & 1) {
            e->clocks[i].cells[CLOCK_COUNT].integer++;
            e->clocks[i].cells[CLOCK_LAST].integer = step;
        }
}

static Outcome ask_shift(Kernel *kernel, Instance *instance, int64_t number)
{
    EventClock *clock = &instance->events->clocks[number];
    double shift = 0.0;
    kernel->event_call = EVENT_CALL_GET_SHIFT;
    ShiftAccess ask = (ShiftAccess)instance->events->get_shift;
    Outcome outcome =
        judge_call(kernel, instance, ask(instance->instance, clock->reference, 1, &shift));
    if (outcome != OUTCOME_DONE)
        return outcome;
    int64_t steps = whole_steps(instance, shift);
    if (steps < 0)
        return event_fault(kernel, EVENT_FAULT_OFF_GRID, number, shift);
    clock->cells[CLOCK_DUE].integer = steps;
    return OUTCOME_DONE;
}

/* A clock before the run, in initialisation mode. */
Outcome wind_up(Kernel *kernel, Instance *instance, int64_t number)
{
    EventClock *clock = &instance->events->clocks[number];
    clock->cells[CLOCK_COUNT].integer = 0;
    clock->cells[CLOCK_AGE].integer = clock->cells[CLOCK_LAST].integer = -1;
    clock->cells[CLOCK_INTERVAL].integer = clock->interval;
    clock->cells[CLOCK_DUE].integer = clock->shift;
    if (clock->kind >= CLOCK_KIND_TRIGGERED || clock->interval >= 0)
        return OUTCOME_DONE;
    int told;
    Outcome outcome = ask_interval(kernel, instance, number, (Instant){0, 0.0}, &told);
    if (outcome != OUTCOME_DONE)
        return outcome;
    if (told == NOT_KNOWN && clock->kind != CLOCK_KIND_COUNTDOWN)
        return event_fault(kernel, EVENT_FAULT_NO_INTERVAL, number, 0.0);
    return clock->kind <= CLOCK_KIND_TUNABLE ? ask_shift(kernel, instance, number) : OUTCOME_DONE;
}

/* How long ago each has ticked, for the outputs of a step. */
void age_clocks(Instance *instance, int64_t step)
{
    for (int64_t i = 0; i < instance->events->clock_count; i++) {
        Cell *cells = instance->events->clocks[i].cells;
        int64_t last = cells[CLOCK_LAST].integer;
        cells[CLOCK_AGE].integer =
            last < 0 ? -1 : (step - last) * instance->period / instance->substeps;
    }
}
