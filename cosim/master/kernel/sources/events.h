/* Event mode of FMI 3.0 co-simulation: the clocks of an FMU, and what is set and read at events. */

#ifndef COHAPTIC_EVENTS_H
#define COHAPTIC_EVENTS_H

#include "kernel.h"

/* What an FMU is being called for at an event; the kernel says so while it lasts. */
typedef enum {
    EVENT_CALL_NONE = 0,
    EVENT_CALL_ENTER = 1,
    EVENT_CALL_SET_CLOCK = 2,
    EVENT_CALL_SET = 3,
    EVENT_CALL_GET_CLOCK = 4,
    EVENT_CALL_GET = 5,
    EVENT_CALL_UPDATE = 6,
    EVENT_CALL_GET_INTERVAL = 7,
    EVENT_CALL_LEAVE = 8,
    EVENT_CALL_GET_SHIFT = 9
} EventCall;

/* What an FMU cannot be followed in. */
typedef enum {
    EVENT_FAULT_NONE = 0,
    EVENT_FAULT_NO_END = 1,      /* its discrete states need update after update */
    EVENT_FAULT_OFF_GRID = 2,    /* an interval is no whole number of its steps */
    EVENT_FAULT_NO_INTERVAL = 3, /* none is known that has to be */
    EVENT_FAULT_RETURNS = 4,     /* it returns from one step again and again */
    EVENT_FAULT_TIME = 5,        /* it returned at a time outside of its step */
    EVENT_FAULT_NO_TIME = 6      /* it announced an event for NaN */
} EventFault;

typedef enum {
    CLOCK_KIND_PERIODIC = 0,
    CLOCK_KIND_TUNABLE = 1,  /* periodic, the interval is asked for in event mode */
    CLOCK_KIND_CHANGING = 2, /* the interval is asked for when it has ticked */
    CLOCK_KIND_COUNTDOWN = 3,
    CLOCK_KIND_TRIGGERED = 4, /* an input that ticks when `input` changes */
    CLOCK_KIND_TOLD = 5       /* the FMU says whether it ticks */
} ClockKind;

/* The cells of a clock, from `cells` on. */
enum { CLOCK_DUE, CLOCK_INTERVAL, CLOCK_COUNT, CLOCK_AGE, CLOCK_LAST, CLOCK_SEEN, CLOCK_CELLS };

/* Its first tick and its interval are in steps of the FMU; -1 where the FMU is asked for them. */
typedef struct {
    int64_t kind;
    uint32_t *reference;
    int64_t interval;
    int64_t shift;
    int64_t of; /* a bit for each clock that it belongs to */
    const Cell *input;
    Cell *cells;
} EventClock;

/* A set or get that is done at events. */
typedef struct {
    int64_t operation;
    int64_t clocks; /* a bit for each clock of which one has to tick; 0: when the value has changed */
    int64_t at_start; /* a get: also in initialisation mode */
    Cell *before;     /* a set: the value before the change */
} EventAccess;

typedef struct Events {
    void *enter;
    void *leave;
    void *update;
    void *set_clock;
    void *get_clock;
    void *get_interval;
    void *get_shift;
    EventClock *clocks;
    int64_t clock_count;
    EventAccess *sets;
    int64_t set_count;
    EventAccess *gets;
    int64_t get_count;
    Cell *next;         /* the time (s) of the event that the FMU has announced, or infinity */
    int64_t may_return; /* it may return early, and steps may have any length */
    int64_t turned;     /* a parameter was turned before the step that comes */
} Events;

typedef int (*ModeCall)(void *instance);
typedef int (*UpdateStates)(void *instance, Truth *again, Truth *terminate, Truth *nominals,
                            Truth *states, Truth *has_next, double *next);
typedef int (*ClockAccess)(void *instance, const uint32_t *references, size_t count,
                           Truth *values);
typedef int (*IntervalAccess)(void *instance, const uint32_t *references, size_t count,
                              double *intervals, int *qualifiers);
typedef int (*ShiftAccess)(void *instance, const uint32_t *references, size_t count,
                           double *shifts);

/* A point of an FMU's grid, and how long (s) after it. */
typedef struct {
    int64_t step;
    double beyond;
} Instant;

Outcome judge_call(Kernel *kernel, Instance *instance, int status);
Outcome event_fault(Kernel *kernel, EventFault fault, int64_t which, double value);
Outcome wind_up(Kernel *kernel, Instance *instance, int64_t number);
Outcome activate_clocks(Kernel *kernel, Instance *instance, int64_t clocks);
Outcome ask_clocks(Kernel *kernel, Instance *instance, int64_t *active);
Outcome ask_intervals(Kernel *kernel, Instance *instance, Instant now, int64_t ticked);
int64_t due_clocks(const Events *e, int64_t step);
void count_ticks(Events *e, int64_t clocks, int64_t step);
void age_clocks(Instance *instance, int64_t step);

/* In initialisation mode (phase 0), and in the event mode that follows it (phase 1). */
EXPORT int32_t kernel_begin_events(Kernel *kernel, int64_t owner, int64_t phase);

#endif
