/* An FMU in event mode that keeps no rule: times that are no numbers, qualifiers and truths that are
   none, clocks that tick as they like, steps that end anywhere, and now and then a status. What it does
   follows from the number ERRATIC. */

char *getenv(const char *);

static uint64_t state;

static uint64_t next_number(void)
{
    if (state == 0) {
        const char *seed = getenv("ERRATIC");
        for (state = 7; *seed; seed++)
            state = state * 131 + (unsigned char)*seed;
    }
    state = state * 6364136223846793005u + 1442695040888963407u;
    return state >> 33;
}

static double any_time(void)
{
    static const double odd[] = {0.0, -0.0, 0.01, 0.02, 0.05, 0.0100000001, 0.013, 1e-300, -0.01,
                                 1e308, -1e308, 9e15, __builtin_inf(), -__builtin_inf(),
                                 __builtin_nan("")};
    return odd[next_number() % (next_number() % 4 ? 5 : sizeof odd / sizeof *odd)];
}

/* One of two in most calls, else any byte. */
static unsigned char any_truth(void)
{
    return next_number() % 8 ? next_number() % 16 == 0 : (unsigned char)next_number();
}

static int any_status(void)
{
    static const int odd[] = {1, 2, 3, 4, 5, 6, -1, 100, 2147483647};
    return next_number() % 64 ? 0 : odd[next_number() % (sizeof odd / sizeof *odd)];
}

#define WITHOUT_EVENTS
#define STEP_OF_ITS_OWN

EXPORT int fmi3EnterEventMode(void *m) { return any_status(); }
EXPORT int fmi3EnterStepMode(void *m) { return any_status(); }

EXPORT int fmi3SetClock(void *m, const uint32_t *r, size_t n, const unsigned char *values)
{
    return any_status();
}

EXPORT int fmi3GetClock(void *m, const uint32_t *r, size_t n, unsigned char *values)
{
    for (size_t i = 0; i < n; i++)
        values[i] = any_truth();
    return any_status();
}

EXPORT int fmi3GetIntervalDecimal(void *m, const uint32_t *r, size_t n, double *intervals,
                                  int *qualifiers)
{
    for (size_t i = 0; i < n; i++) {
        intervals[i] = any_time();
        qualifiers[i] = next_number() % 16 ? 1 + (int)(next_number() % 2) : (int)next_number() - 5;
    }
    return any_status();
}

EXPORT int fmi3SetIntervalDecimal(void *m, const uint32_t *r, size_t n, const double *intervals)
{
    return any_status();
}

EXPORT int fmi3GetShiftDecimal(void *m, const uint32_t *r, size_t n, double *shifts)
{
    for (size_t i = 0; i < n; i++)
        shifts[i] = any_time();
    return any_status();
}

EXPORT int fmi3UpdateDiscreteStates(void *m, unsigned char *again, unsigned char *terminate,
                                    unsigned char *nominals, unsigned char *states,
                                    unsigned char *has_next, double *next)
{
    *again = any_truth();
    *terminate = next_number() % 64 == 0;
    *nominals = any_truth();
    *states = any_truth();
    *has_next = any_truth();
    *next = any_time();
    return any_status();
}

EXPORT int fmi3DoStep(void *m, double time, double step, unsigned char no_set_state,
                      unsigned char *event, unsigned char *terminate, unsigned char *early,
                      double *last)
{
    *event = any_truth();
    *terminate = next_number() % 64 == 0;
    *early = any_truth();
    *last = next_number() % 4 ? time + step * (double)(next_number() % 5) / 4 : any_time();
    return any_status();
}
