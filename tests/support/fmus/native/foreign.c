/* An FMU of somebody else, FMI 2.0 and 3.0 in one: a store of values, and a hook at every call.

   The snippet under test is included first; it may define HOOK, a function that is called at the
   beginning of every FMI function and whose status, unless it is 0, is returned at once. */

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define EXPORT __attribute__((visibility("default")))
#define UNUSED __attribute__((unused))
#define VALUES 64
#define TEXT 256

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *step_finished;
    void *environment;
} Callbacks;

typedef struct {
    double real[VALUES]; /* of any type with a fraction, by value reference */
    int64_t whole[VALUES];
    char text[VALUES][TEXT]; /* of Strings and Binaries */
    size_t size[VALUES]; /* of Binaries */
    double time;
    void (*log2)(void *, const char *, int, const char *, const char *, ...);
    void (*log3)(void *, int, const char *, const char *);
    void *environment;
    const char *resources; /* as FMI 3 was given them */
    bool terminate; /* the step is to ask for the end */
    bool event, early; /* what the step is to say besides, and the time that it has reached */
    double last;
    bool event_mode, early_allowed; /* as it was instantiated */
    bool ticks[VALUES]; /* clocks that are active */
    double interval[VALUES]; /* s, of clocks, by value reference */
    int qualifier[VALUES];
    double shift[VALUES];
    bool logging; /* as it was instantiated with, or told later */
    char categories[TEXT]; /* as it was told, with a blank behind each */
    bool again, has_next; /* what an update says */
    double next;
} Foreign;

UNUSED static void say(Foreign *m, int status, const char *message)
{
    if (m->log2)
        m->log2(m->environment, "foreign", status, "logAll", "%s", message);
    if (m->log3)
        m->log3(m->environment, status, "logAll", message);
}

UNUSED static bool is(const char *a, const char *b)
{
    while (*a && *a == *b)
        a++, b++;
    return *a == *b;
}

#include "snippet.h"

#ifndef HOOK
static int no_hook(Foreign *m, const char *call)
{
    return 0;
}
#define HOOK no_hook
#endif

#define ENTER(CALL)                                                                               \
    int status = HOOK(instance, CALL);                                                            \
    if (status)                                                                                   \
        return status

static Foreign instances[64];
static int taken;

UNUSED static Foreign *instances_begin(void) { return instances; }

static Foreign *make(void)
{
    return taken < 64 ? &instances[taken++] : 0;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }
EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *token, const char *resources,
                             const Callbacks *callbacks, int visible, int logging)
{
    Foreign *m = make();
    m->log2 = callbacks->logger;
    m->logging = logging != 0;
    m->environment = callbacks->environment;
    return HOOK(m, "Instantiate") ? 0 : m;
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token,
                                         const char *resources, bool visible, bool logging,
                                         bool events, bool early, const uint32_t *required,
                                         size_t count, void *environment, void *log, void *update)
{
    Foreign *m = make();
    m->log3 = (void (*)(void *, int, const char *, const char *))log;
    m->logging = logging;
    m->environment = environment;
    m->resources = resources;
    m->event_mode = events;
    m->early_allowed = early;
    return HOOK(m, "Instantiate") ? 0 : m;
}

#ifndef WITHOUT_REST
#define CALL(NAME, ...)                                                                           \
    EXPORT int fmi2##NAME(Foreign *instance, ##__VA_ARGS__) { ENTER(#NAME); return 0; }           \
    EXPORT int fmi3##NAME(Foreign *instance, ##__VA_ARGS__) { ENTER(#NAME); return 0; }

CALL(Terminate)
CALL(Reset)
CALL(ExitInitializationMode)
CALL(EnterConfigurationMode)
CALL(ExitConfigurationMode)
#endif

static int choose(Foreign *m, bool on, size_t count, const char **names)
{
    size_t used = 0;
    m->logging = on;
    for (size_t i = 0; i < count; i++) {
        for (const char *c = names[i]; *c && used < TEXT - 2; c++)
            m->categories[used++] = *c;
        if (used < TEXT - 1)
            m->categories[used++] = ' ';
    }
    return 0;
}

EXPORT int fmi2SetDebugLogging(Foreign *instance, int on, size_t count, const char **names)
{
    ENTER("SetDebugLogging");
    return choose(instance, on != 0, count, names);
}

EXPORT int fmi3SetDebugLogging(Foreign *instance, bool on, size_t count, const char **names)
{
    ENTER("SetDebugLogging");
    return choose(instance, on, count, names);
}

EXPORT int fmi2SetupExperiment(Foreign *instance, int d, double t, double from, int s, double to)
{
    instance->time = instance->last = from;
    ENTER("SetupExperiment");
    return 0;
}

EXPORT int fmi2EnterInitializationMode(Foreign *instance)
{
    ENTER("EnterInitializationMode");
    return 0;
}

EXPORT int fmi3EnterInitializationMode(Foreign *instance, bool d, double t, double from, bool s,
                                       double to)
{
    instance->time = instance->last = from;
    ENTER("EnterInitializationMode");
    return 0;
}

EXPORT void fmi2FreeInstance(Foreign *instance) { (void)HOOK(instance, "FreeInstance"); }
EXPORT void fmi3FreeInstance(Foreign *instance) { (void)HOOK(instance, "FreeInstance"); }

#define ACCESS2(NAME, TYPE, FIELD)                                                                \
    EXPORT int fmi2Get##NAME(Foreign *instance, const uint32_t *r, size_t n, TYPE *values)        \
    {                                                                                             \
        ENTER("Get" #NAME);                                                                       \
        for (size_t i = 0; i < n; i++)                                                            \
            values[i] = (TYPE)instance->FIELD[r[i]];                                              \
        return 0;                                                                                 \
    }                                                                                             \
    EXPORT int fmi2Set##NAME(Foreign *instance, const uint32_t *r, size_t n, const TYPE *values)  \
    {                                                                                             \
        ENTER("Set" #NAME);                                                                       \
        for (size_t i = 0; i < n; i++)                                                            \
            instance->FIELD[r[i]] = values[i];                                                    \
        return 0;                                                                                 \
    }

/* An array lies at its reference and those that follow. */
#define ACCESS3(NAME, TYPE, FIELD)                                                                \
    EXPORT int fmi3Get##NAME(Foreign *instance, const uint32_t *r, size_t n, TYPE *values,        \
                             size_t m)                                                            \
    {                                                                                             \
        ENTER("Get" #NAME);                                                                       \
        for (size_t i = 0; i < m; i++)                                                            \
            values[i] = (TYPE)instance->FIELD[r[i / (m / n)] + i % (m / n)];                      \
        return 0;                                                                                 \
    }                                                                                             \
    EXPORT int fmi3Set##NAME(Foreign *instance, const uint32_t *r, size_t n, const TYPE *values,  \
                             size_t m)                                                            \
    {                                                                                             \
        ENTER("Set" #NAME);                                                                       \
        for (size_t i = 0; i < m; i++)                                                            \
            instance->FIELD[r[i / (m / n)] + i % (m / n)] = values[i];                            \
        return 0;                                                                                 \
    }

/* Texts are copied, as the standard says: what was passed is gone after the call. */
UNUSED static void keep(char *place, const char *text, size_t size)
{
    size_t i = 0;
    for (; i < size && i < TEXT - 1; i++)
        place[i] = text[i];
    place[i] = 0;
}

UNUSED static size_t length(const char *text)
{
    size_t i = 0;
    while (text[i])
        i++;
    return i;
}

#ifdef WITHOUT_OWN_TEXTS
#define SHOWN(M, R) shown(M, R)
#else
#define SHOWN(M, R) (M)->text[R]
#endif

#define TEXT_ACCESS(VERSION, ...)                                                                 \
    EXPORT int fmi##VERSION##GetString(Foreign *instance, const uint32_t *r, size_t n,            \
                                       const char **values, ##__VA_ARGS__)                        \
    {                                                                                             \
        ENTER("GetString");                                                                       \
        for (size_t i = 0; i < n; i++)                                                            \
            values[i] = SHOWN(instance, r[i]);                                                    \
        return 0;                                                                                 \
    }                                                                                             \
    EXPORT int fmi##VERSION##SetString(Foreign *instance, const uint32_t *r, size_t n,            \
                                       const char *const *values, ##__VA_ARGS__)                  \
    {                                                                                             \
        ENTER("SetString");                                                                       \
        for (size_t i = 0; i < n; i++)                                                            \
            keep(instance->text[r[i]], values[i], length(values[i]));                             \
        return 0;                                                                                 \
    }

ACCESS2(Real, double, real)
ACCESS2(Integer, int, whole)
ACCESS2(Boolean, int, whole)
#ifndef WITHOUT_TEXTS
TEXT_ACCESS(2)
TEXT_ACCESS(3, size_t m)

EXPORT int fmi3GetBinary(Foreign *instance, const uint32_t *r, size_t n, size_t *sizes,
                         const char **values, size_t m)
{
    ENTER("GetBinary");
    for (size_t i = 0; i < n; i++) {
        sizes[i] = instance->size[r[i]];
        values[i] = sizes[i] ? instance->text[r[i]] : 0;
    }
    return 0;
}

EXPORT int fmi3SetBinary(Foreign *instance, const uint32_t *r, size_t n, const size_t *sizes,
                         const char *const *values, size_t m)
{
    ENTER("SetBinary");
    for (size_t i = 0; i < n; i++) {
        keep(instance->text[r[i]], values[i], sizes[i]);
        instance->size[r[i]] = sizes[i] < TEXT ? sizes[i] : TEXT - 1;
    }
    return 0;
}
#endif
ACCESS3(Float64, double, real)
ACCESS3(Float32, float, real)
ACCESS3(Int8, int8_t, whole)
ACCESS3(UInt8, uint8_t, whole)
ACCESS3(Int16, int16_t, whole)
ACCESS3(UInt16, uint16_t, whole)
ACCESS3(Int32, int32_t, whole)
ACCESS3(UInt32, uint32_t, whole)
ACCESS3(Int64, int64_t, whole)
ACCESS3(UInt64, uint64_t, whole)
ACCESS3(Boolean, bool, whole)

EXPORT int fmi2GetBooleanStatus(Foreign *instance, int kind, int *value)
{
    ENTER("GetBooleanStatus");
    *value = instance->terminate;
    return 0;
}

EXPORT int fmi2DoStep(Foreign *instance, double time, double step, int no_set_state)
{
    instance->time = time;
    ENTER("DoStep");
    return instance->terminate ? 2 : 0;
}

#ifndef WITHOUT_EVENTS
#define CALL3(NAME, ...)                                                                          \
    EXPORT int fmi3##NAME(Foreign *instance, ##__VA_ARGS__) { ENTER(#NAME); return 0; }

CALL3(EnterEventMode)
CALL3(EnterStepMode)

EXPORT int fmi3SetClock(Foreign *instance, const uint32_t *r, size_t n, const bool *values)
{
    ENTER("SetClock");
    for (size_t i = 0; i < n; i++)
        instance->ticks[r[i]] = values[i];
    return 0;
}

EXPORT int fmi3GetClock(Foreign *instance, const uint32_t *r, size_t n, bool *values)
{
    ENTER("GetClock");
    for (size_t i = 0; i < n; i++)
        values[i] = instance->ticks[r[i]];
    return 0;
}

EXPORT int fmi3GetIntervalDecimal(Foreign *instance, const uint32_t *r, size_t n,
                                  double *intervals, int *qualifiers)
{
    ENTER("GetIntervalDecimal");
    for (size_t i = 0; i < n; i++) {
        intervals[i] = instance->interval[r[i]];
        qualifiers[i] = instance->qualifier[r[i]];
    }
    return 0;
}

EXPORT int fmi3GetShiftDecimal(Foreign *instance, const uint32_t *r, size_t n, double *shifts)
{
    ENTER("GetShiftDecimal");
    for (size_t i = 0; i < n; i++)
        shifts[i] = instance->shift[r[i]];
    return 0;
}

/* Clocks rest again after every update, as the standard says. */
EXPORT int fmi3UpdateDiscreteStates(Foreign *instance, bool *again, bool *terminate,
                                    bool *nominals, bool *states, bool *has_next, double *next)
{
    int status = HOOK(instance, "UpdateDiscreteStates");
    *again = instance->again;
    *terminate = instance->terminate;
    *nominals = *states = false;
    *has_next = instance->has_next;
    *next = instance->next;
    for (int i = 0; i < VALUES; i++)
        instance->ticks[i] = false;
    return status;
}
#endif

#ifndef STEP_OF_ITS_OWN
EXPORT int fmi3DoStep(Foreign *instance, double time, double step, bool no_set_state, bool *event,
                      bool *terminate, bool *early, double *last)
{
    instance->time = time;
    instance->event = instance->early = false;
    instance->last = time + step;
    ENTER("DoStep");
    *event = instance->event;
    *early = instance->early;
    *terminate = instance->terminate;
    *last = instance->last;
    return 0;
}
#endif
