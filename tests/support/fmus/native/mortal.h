/* Fails in the call that FAILS_IN names, once FAILS_AFTER steps were begun, in the way of FAILS_BY: the
   name of one in which the process ends, or the number of a status. What is called after a status was
   returned stands in the file CALLED_AFTER. */

char *getenv(const char *);
void exit(int);
void _exit(int);
void abort(void);
int raise(int);
int pause(void);
void *dlopen(const char *, int);
void *dlsym(void *, const char *);
int open(const char *, int, ...);
long write(int, const void *, size_t);
int close(int);

static int steps;
static bool has_failed;

static void throw_an_int(void)
{
    void *runtime = dlopen("libstdc++.so.6", 2);
    void *(*allocate)(size_t) = dlsym(runtime, "__cxa_allocate_exception");
    void (*throw)(void *, void *, void *) = dlsym(runtime, "__cxa_throw");
    throw(allocate(sizeof(int)), dlsym(runtime, "_ZTIi"), 0);
}

static int fail(const char *way)
{
    if (is(way, "exit(0)"))
        exit(0);
    if (is(way, "_exit(0)"))
        _exit(0);
    if (is(way, "exit(3)"))
        exit(3);
    if (is(way, "abort"))
        abort();
    if (is(way, "SIGSEGV"))
        *(volatile int *)8 = 1;
    if (is(way, "SIGFPE"))
        raise(8);
    if (is(way, "exception"))
        throw_an_int();
    while (is(way, "endless"))
        pause();
    int status = 0;
    while (*way)
        status = 10 * status + *way++ - '0';
    has_failed = true;
    return status;
}

static void note(const char *call)
{
    int file = open(getenv("CALLED_AFTER"), 1 | 64 | 1024, 0600); /* write, create, append */
    size_t count = 0;
    while (call[count])
        count++;
    write(file, call, count);
    write(file, "\n", 1);
    close(file);
}

static int hook(Foreign *m, const char *call)
{
    const char *where = getenv("FAILS_IN");
    const bool is_late = steps >= getenv("FAILS_AFTER")[0] - '0';
    if (has_failed)
        note(call);
    if (is(call, "Instantiate"))
        m->interval[10] = 0.01, m->qualifier[10] = 1;
    m->event = true; /* after every step */
    if (is(call, "DoStep")) {
        m->terminate = is(where, "GetBooleanStatus") && is_late; /* of which FMI 2 is asked */
        steps++;
    }
    return !has_failed && is_late && is(call, where) ? fail(getenv("FAILS_BY")) : 0;
}
#define HOOK hook

static Foreign kept[8];
static int keeps;

#define PASS(CALL)                                                                                \
    int status = hook(m, CALL);                                                                   \
    if (status)                                                                                   \
        return status

#define STATES(V, GET, SET, FREE, SIZE, SERIALISE, DESERIALISE)                                   \
    EXPORT int fmi##V##GET(Foreign *m, void **state)                                              \
    {                                                                                             \
        PASS(#GET);                                                                               \
        kept[keeps % 8] = *m;                                                                     \
        *state = &kept[keeps++ % 8];                                                              \
        return 0;                                                                                 \
    }                                                                                             \
    EXPORT int fmi##V##SET(Foreign *m, Foreign *state)                                            \
    {                                                                                             \
        PASS(#SET);                                                                               \
        Foreign now = *m;                                                                         \
        *m = *state;                                                                              \
        m->log2 = now.log2, m->log3 = now.log3, m->environment = now.environment;                 \
        m->resources = now.resources;                                                             \
        return 0;                                                                                 \
    }                                                                                             \
    EXPORT int fmi##V##FREE(Foreign *m, void **state)                                             \
    {                                                                                             \
        PASS(#FREE);                                                                              \
        *state = 0;                                                                               \
        return 0;                                                                                 \
    }                                                                                             \
    EXPORT int fmi##V##SIZE(Foreign *m, void *state, size_t *size)                                \
    {                                                                                             \
        PASS(#SIZE);                                                                              \
        *size = sizeof(Foreign);                                                                  \
        return 0;                                                                                 \
    }                                                                                             \
    EXPORT int fmi##V##SERIALISE(Foreign *m, const Foreign *state, Foreign *bytes, size_t size)   \
    {                                                                                             \
        PASS(#SERIALISE);                                                                         \
        *bytes = *state;                                                                          \
        return 0;                                                                                 \
    }                                                                                             \
    EXPORT int fmi##V##DESERIALISE(Foreign *m, const Foreign *bytes, size_t size, void **state)   \
    {                                                                                             \
        PASS(#DESERIALISE);                                                                       \
        kept[keeps % 8] = *bytes;                                                                 \
        *state = &kept[keeps++ % 8];                                                              \
        return 0;                                                                                 \
    }

STATES(2, GetFMUstate, SetFMUstate, FreeFMUstate, SerializedFMUstateSize, SerializeFMUstate,
       DeSerializeFMUstate)
STATES(3, GetFMUState, SetFMUState, FreeFMUState, SerializedFMUStateSize, SerializeFMUState,
       DeserializeFMUState)

EXPORT int fmi3SetIntervalDecimal(Foreign *m, const uint32_t *r, size_t n, const double *intervals)
{
    PASS("SetIntervalDecimal");
    return 0;
}
