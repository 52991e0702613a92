/* The calls of event mode for an FMU in a process of its own: one request each, as `isolation.c`. */

#include "isolation.h"

enum { ENTER, LEAVE, UPDATE, SET_CLOCK, GET_CLOCK, GET_INTERVAL, GET_SHIFT };

/* What an update says of itself, as bits. */
enum { AGAIN = 1, TERMINATE = 2, NOMINALS = 4, STATES = 8, HAS_NEXT = 16 };

static int enter(void *own)
{
    return ask_other(own, REQUEST_EVENTS + ENTER);
}

static int leave(void *own)
{
    return ask_other(own, REQUEST_EVENTS + LEAVE);
}

static int update(void *instance, Truth *again, Truth *terminate, Truth *nominals,
                  Truth *states, Truth *has_next, double *next)
{
    Isolation *own = instance;
    int status = ask_other(own, REQUEST_EVENTS + UPDATE);
    if (status == GONE)
        return status;
    const int64_t said = own->exchange->event;
    *again = (said & AGAIN) != 0;
    *terminate = (said & TERMINATE) != 0;
    *nominals = (said & NOMINALS) != 0;
    *states = (said & STATES) != 0;
    *has_next = (said & HAS_NEXT) != 0;
    *next = own->exchange->last_time;
    return status;
}

/* The kernel asks about one clock at a time. */
static int ask_about(Isolation *own, int64_t call, const uint32_t *references)
{
    own->exchange->reference_count = 1;
    references_of(own->exchange)[0] = references[0];
    return ask_other(own, REQUEST_EVENTS + call);
}

static int set_clock(void *own, const uint32_t *references, size_t count, Truth *values)
{
    (void)count;
    (void)values; /* a clock is only ever activated: the FMU lets it rest again itself */
    return ask_about(own, SET_CLOCK, references);
}

static int get_clock(void *instance, const uint32_t *references, size_t count, Truth *values)
{
    Isolation *own = instance;
    (void)count;
    int status = ask_about(own, GET_CLOCK, references);
    if (status != GONE)
        values[0] = own->exchange->event != 0;
    return status;
}

static int get_interval(void *instance, const uint32_t *references, size_t count,
                        double *intervals, int *qualifiers)
{
    Isolation *own = instance;
    (void)count;
    int status = ask_about(own, GET_INTERVAL, references);
    if (status != GONE) {
        intervals[0] = own->exchange->last_time;
        qualifiers[0] = (int)own->exchange->event;
    }
    return status;
}

static int get_shift(void *instance, const uint32_t *references, size_t count, double *shifts)
{
    Isolation *own = instance;
    (void)count;
    int status = ask_about(own, GET_SHIFT, references);
    if (status != GONE)
        shifts[0] = own->exchange->last_time;
    return status;
}

void *isolated_event_call(int64_t number)
{
    static void *const calls[] = {
        [ENTER] = (void *)enter,
        [LEAVE] = (void *)leave,
        [UPDATE] = (void *)update,
        [SET_CLOCK] = (void *)set_clock,
        [GET_CLOCK] = (void *)get_clock,
        [GET_INTERVAL] = (void *)get_interval,
        [GET_SHIFT] = (void *)get_shift,
    };
    return calls[number];
}

/* In the FMU's process. */
int serve_event_call(const Isolation *own, void *instance)
{
    Exchange *e = own->exchange;
    void *function = own->functions[e->request];
    const uint32_t *references = references_of(e);
    Truth again = 0, terminate = 0, nominals = 0, states = 0, has_next = 0, active = 1;
    double value = 0.0;
    int status, qualifier = 0;
    switch (e->request - REQUEST_EVENTS) {
    case UPDATE:
        status = ((UpdateStates)function)(instance, &again, &terminate, &nominals, &states,
                                          &has_next, &value);
        e->event = (again ? AGAIN : 0) | (terminate ? TERMINATE : 0) | (nominals ? NOMINALS : 0)
                 | (states ? STATES : 0) | (has_next ? HAS_NEXT : 0);
        break;
    case SET_CLOCK:
        return ((ClockAccess)function)(instance, references, 1, &active);
    case GET_CLOCK:
        active = 0;
        status = ((ClockAccess)function)(instance, references, 1, &active);
        e->event = active != 0;
        break;
    case GET_INTERVAL:
        status = ((IntervalAccess)function)(instance, references, 1, &value, &qualifier);
        e->event = qualifier;
        break;
    case GET_SHIFT:
        status = ((ShiftAccess)function)(instance, references, 1, &value);
        break;
    default:
        return ((ModeCall)function)(instance);
    }
    e->last_time = value;
    return status;
}
