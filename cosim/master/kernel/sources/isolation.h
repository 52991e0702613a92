/* What both files of the exchange with an isolated FMU's process share. */

#ifndef COHAPTIC_ISOLATION_H
#define COHAPTIC_ISOLATION_H

#include "events.h"

enum {
    REQUEST_STEP = 0,
    REQUEST_ACCESS = 1,  /* 1 + 2 * type, and 1 more to set */
    REQUEST_EVENTS = 25, /* the calls of event mode, in the order of `isolated_event_call` */
    REQUEST_PYTHON = -1,
    GONE = 100, /* in place of a status */
    TOO_LARGE = 101
};

int ask_other(Isolation *own, int64_t request);
void *isolated_event_call(int64_t number);
int serve_event_call(const Isolation *own, void *instance);

static inline uint32_t *references_of(Exchange *e)
{
    return (uint32_t *)(e + 1);
}

static inline char *values_of(Exchange *e)
{
    return (char *)(e + 1) + (e->most_references + 1) / 2 * 8;
}

#endif
