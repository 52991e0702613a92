/* An FMU in a process of its own: the kernel calls the functions below in place of the FMU's, and
   the other process calls those of the FMU, over memory that both share.

   Whoever waits looks at the memory for a while and then sleeps on a pipe. When the other process is
   gone its end of the pipe is closed, which wakes the sleeper: a death costs a status. */

#include "isolation.h"

enum { TRIES = 1000 }; /* to write a byte, which a signal may interrupt; then nobody is there */

static void relax(void)
{
#if defined(__x86_64__)
    __asm__ volatile("pause");
#elif defined(__aarch64__)
    __asm__ volatile("yield");
#endif
}

static int64_t transfer(void *function, int64_t file, char *byte)
{
    return ((Transfer)function)((int)file, byte, 1);
}

/* Waits until `turn` has become `wanted`; whether it has, rather than the other side being gone. */
static bool await(const Isolation *side, int64_t *turn, int64_t *sleeping, int64_t wanted)
{
    for (int64_t i = 0; i < side->looks; i++) {
        if (__atomic_load_n(turn, __ATOMIC_ACQUIRE) == wanted)
            return true;
        relax();
    }
    for (;;) {
        char byte;
        __atomic_store_n(sleeping, 1, __ATOMIC_SEQ_CST);
        if (__atomic_load_n(turn, __ATOMIC_SEQ_CST) == wanted) {
            /* Whoever saw us asleep has sent a byte, which must not wake us the next time. */
            if (__atomic_exchange_n(sleeping, 0, __ATOMIC_SEQ_CST) == 0)
                while (transfer(side->read, side->ear, &byte) < 0)
                    ;
            return true;
        }
        int64_t count = transfer(side->read, side->ear, &byte);
        if (count == 0)
            return false;
        if (__atomic_load_n(turn, __ATOMIC_ACQUIRE) == wanted)
            return true;
    }
}

/* Gives the turn to the other side; it is woken if it sleeps, which is looked at before it is taken
   back: a look leaves the memory to both. */
static void hand_over(const Isolation *side, int64_t *turn, int64_t *sleeping)
{
    char byte = 0;
    __atomic_add_fetch(turn, 1, __ATOMIC_SEQ_CST);
    if (__atomic_load_n(sleeping, __ATOMIC_SEQ_CST) == 1
        && __atomic_exchange_n(sleeping, 0, __ATOMIC_SEQ_CST) == 1)
        for (int64_t i = 0; i < TRIES && transfer(side->write, side->mouth, &byte) < 0; i++)
            ;
}

int ask_other(Isolation *own, int64_t request)
{
    Exchange *e = own->exchange;
    if (own->is_gone)
        return GONE;
    e->request = request;
    hand_over(own, &e->asked, &e->worker_sleeps);
    if (!await(own, &e->answered, &e->master_sleeps, e->asked)) {
        own->is_gone = 1;
        return GONE;
    }
    return (int)e->status;
}

static int64_t size_of(int64_t type)
{
    static const char sizes[] = {8, 4, 1, 1, 2, 2, 4, 4, 8, 8, 1, 4};
    return sizes[type];
}

static void copy_bytes(void *to, const void *from, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        ((char *)to)[i] = ((const char *)from)[i];
}

static int access_values(Isolation *own, int64_t type, bool is_set, const uint32_t *references,
                         size_t count, void *values, size_t value_count)
{
    Exchange *e = own->exchange;
    int64_t bytes = (int64_t)value_count * size_of(type);
    if ((int64_t)count > e->most_references || bytes > e->most_bytes)
        return TOO_LARGE;
    e->reference_count = (int64_t)count;
    e->value_count = (int64_t)value_count;
    copy_bytes(references_of(e), references, (int64_t)count * 4);
    if (is_set)
        copy_bytes(values_of(e), values, bytes);
    int status = ask_other(own, REQUEST_ACCESS + 2 * type + is_set);
    if (!is_set && status != GONE)
        copy_bytes(values, values_of(e), bytes);
    return status;
}

#define ACCESS2(NAME, CODE)                                                                       \
    static int get2_##NAME(void *own, const uint32_t *references, size_t count, void *values)     \
    {                                                                                             \
        return access_values(own, CODE, false, references, count, values, count);                 \
    }                                                                                             \
    static int set2_##NAME(void *own, const uint32_t *references, size_t count, void *values)     \
    {                                                                                             \
        return access_values(own, CODE, true, references, count, values, count);                  \
    }

#define ACCESS3(NAME, CODE)                                                                       \
    static int get3_##NAME(void *own, const uint32_t *references, size_t count, void *values,     \
                           size_t value_count)                                                    \
    {                                                                                             \
        return access_values(own, CODE, false, references, count, values, value_count);           \
    }                                                                                             \
    static int set3_##NAME(void *own, const uint32_t *references, size_t count, void *values,     \
                           size_t value_count)                                                    \
    {                                                                                             \
        return access_values(own, CODE, true, references, count, values, value_count);            \
    }

ACCESS2(float64, TYPE_FLOAT64)
ACCESS2(int32, TYPE_INT32)
ACCESS2(boolean, TYPE_BOOLEAN_INT)
ACCESS3(float64, TYPE_FLOAT64)
ACCESS3(float32, TYPE_FLOAT32)
ACCESS3(int8, TYPE_INT8)
ACCESS3(uint8, TYPE_UINT8)
ACCESS3(int16, TYPE_INT16)
ACCESS3(uint16, TYPE_UINT16)
ACCESS3(int32, TYPE_INT32)
ACCESS3(uint32, TYPE_UINT32)
ACCESS3(int64, TYPE_INT64)
ACCESS3(uint64, TYPE_UINT64)
ACCESS3(boolean, TYPE_BOOLEAN)

static int step2(void *instance, double time, double step, int no_set_state_before)
{
    Isolation *own = instance;
    own->exchange->time = time;
    own->exchange->step = step;
    (void)no_set_state_before;
    return ask_other(own, REQUEST_STEP);
}

static int step3(void *instance, double time, double step, bool no_set_state_before, Truth *event,
                 Truth *terminate, Truth *early_return, double *last_time)
{
    Isolation *own = instance;
    Exchange *e = own->exchange;
    e->time = time;
    e->step = step;
    (void)no_set_state_before;
    int status = ask_other(own, REQUEST_STEP);
    if (status != GONE) {
        *event = e->event != 0;
        *terminate = e->terminate != 0;
        *early_return = e->early_return != 0;
        *last_time = e->last_time;
    }
    return status;
}

/* What the kernel calls in place of the FMU's function: `type` as in KIND_SET, -1 for a step, or the
   calls of event mode from -2 down. */
EXPORT void *kernel_isolated(int64_t version, int64_t type, int64_t is_set)
{
    static void *const accessors2[][2] = {
        [TYPE_FLOAT64] = {(void *)get2_float64, (void *)set2_float64},
        [TYPE_INT32] = {(void *)get2_int32, (void *)set2_int32},
        [TYPE_BOOLEAN_INT] = {(void *)get2_boolean, (void *)set2_boolean},
    };
    static void *const accessors3[][2] = {
        [TYPE_FLOAT64] = {(void *)get3_float64, (void *)set3_float64},
        [TYPE_FLOAT32] = {(void *)get3_float32, (void *)set3_float32},
        [TYPE_INT8] = {(void *)get3_int8, (void *)set3_int8},
        [TYPE_UINT8] = {(void *)get3_uint8, (void *)set3_uint8},
        [TYPE_INT16] = {(void *)get3_int16, (void *)set3_int16},
        [TYPE_UINT16] = {(void *)get3_uint16, (void *)set3_uint16},
        [TYPE_INT32] = {(void *)get3_int32, (void *)set3_int32},
        [TYPE_UINT32] = {(void *)get3_uint32, (void *)set3_uint32},
        [TYPE_INT64] = {(void *)get3_int64, (void *)set3_int64},
        [TYPE_UINT64] = {(void *)get3_uint64, (void *)set3_uint64},
        [TYPE_BOOLEAN] = {(void *)get3_boolean, (void *)set3_boolean},
    };
    if (type < -1)
        return isolated_event_call(-2 - type);
    if (type < 0)
        return version == 2 ? (void *)step2 : (void *)step3;
    return version == 2 ? accessors2[type][is_set] : accessors3[type][is_set];
}

/* A call that only Python can make is due in the other process. */
EXPORT int32_t kernel_isolated_ask(Isolation *own)
{
    return ask_other(own, REQUEST_PYTHON);
}

static int serve(const Isolation *own, void *instance)
{
    Exchange *e = own->exchange;
    if (e->request == REQUEST_STEP) {
        void *function = own->functions[0];
        if (own->version == 2)
            return ((Step2)function)(instance, e->time, e->step, 1);
        Truth event = 0, terminate = 0, early_return = 0;
        double last_time = e->time;
        int status = ((Step3)function)(instance, e->time, e->step, true, &event, &terminate,
                                       &early_return, &last_time);
        e->event = event != 0;
        e->terminate = terminate != 0;
        e->early_return = early_return != 0;
        e->last_time = last_time;
        return status;
    }
    if (e->request >= REQUEST_EVENTS)
        return serve_event_call(own, instance);
    void *function = own->functions[e->request];
    size_t count = (size_t)e->reference_count;
    if (own->version == 2)
        return ((Access2)function)(instance, references_of(e), count, values_of(e));
    return ((Access3)function)(instance, references_of(e), count, values_of(e),
                               (size_t)e->value_count);
}

/* In the FMU's process: serves the kernel until a call for Python is due (1), which both sides talk
   about elsewhere, or the master is gone (0). */
EXPORT int32_t kernel_isolated_serve(Isolation *own, void *instance)
{
    Exchange *e = own->exchange;
    for (;;) {
        if (!await(own, &e->asked, &e->worker_sleeps, e->answered + 1))
            return 0;
        bool is_pythons = e->request == REQUEST_PYTHON; /* the next one may come at once */
        e->status = is_pythons ? STATUS_OK : serve(own, instance);
        hand_over(own, &e->answered, &e->master_sleeps);
        if (is_pythons)
            return 1;
    }
}
