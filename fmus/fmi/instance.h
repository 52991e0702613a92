/* What the FMI 2.0 and the FMI 3.0 functions share: an instance, its phases and its values. */
#ifndef COHAPTIC_INSTANCE_H
#define COHAPTIC_INSTANCE_H

#include "platform.h"
#include "report.h"

/* The generated description: one entry per slot; what is inside a string has TYPE_NONE. */
typedef enum { TYPE_NONE, TYPE_REAL, TYPE_INTEGER, TYPE_BOOLEAN, TYPE_ENUMERATION, TYPE_STRING } Type;
typedef enum { ACCESS_PARAMETER, ACCESS_TUNABLE, ACCESS_INPUT, ACCESS_COMPUTED } Access;

typedef union {
    double real;
    int64_t integer;
} Cell;

typedef struct {
    const char *name;
    uint8_t type, access;
    uint32_t length; /* elements of the array that starts here; 0 for its further elements */
    double minimum, maximum;
    Cell start;
} Element;

typedef struct {
    uint32_t slot;
    const char *text;
} StringStart;

enum { STRING_SLOTS = 64, STRING_BYTES = 8 * STRING_SLOTS };

extern const char model_name[], model_token[], model_array_token[];
extern const uint64_t model_digest[2]; /* of the table and all sources */
extern const bool model_variable_step;
extern const uint32_t model_slots;
extern const Element model_elements[];
extern const size_t model_string_starts_count;
extern const StringStart model_string_starts[];

/* Numbered as fmi2Status and fmi3Status. */
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

typedef enum {
    PHASE_INSTANTIATED = 1,
    PHASE_INITIALISATION = 2,
    PHASE_STEP = 4,
    PHASE_TERMINATED = 8,
    PHASE_FAILED = 16, /* after an error: reset it, restore a state, or free it */
    PHASE_DEAD = 32    /* after a fatal error: nothing but freeing it */
} Phase;

/* What a saved state holds beside the variables and the model's State. */
typedef struct {
    double time, start_time;
    double step; /* the length of every step so far where the model wants one length; else 0 */
    uint32_t phase, unused; /* no padding, which would have no value */
} Clock;

typedef struct Instance Instance;
typedef void Emit(Instance *i, Status status, const char *category, const char *message);

struct Instance {
    Report report;
    Clock clock;
    double stop_time; /* this run's own: a state that is restored does not bring another */
    bool stop_time_defined;
    bool is_fmi3, has_arrays;
    bool logs_information, is_outdated; /* is_outdated: outputs do not belong to state and inputs */
    Emit *emit;
    void (*logger)(void); /* fmi2CallbackLogger or fmi3LogMessageCallback */
    void *environment;
    Cell *cells;
    State *state;
    size_t size;
    char name[128];
};

/* The state with the work room behind it, how large both are, and both set to zero. */
void instance_clear_work(Instance *i);
size_t instance_state_room(void);
void instance_clear_state(Instance *i);

Instance *instance_new(const char *name, Emit *emit, void (*logger)(void), void *environment,
                       bool logs_information);
void instance_free(Instance *i);

/* Logs a sentence (as report_format) under its category and returns `status`. */
Status instance_complain(Instance *i, Status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* OK where the instance is in one of `phases`; else an error that names the function. */
Status instance_expect(Instance *i, const char *function, uint32_t phases);

bool same_text(const char *a, const char *b);

Status instance_set_logging(Instance *i, const char *function, bool on, size_t count,
                            const char *const categories[]);
Status instance_setup(Instance *i, const char *function, double start_time, bool stop_time_defined,
                      double stop_time);
Status instance_enter_initialisation(Instance *i, const char *function);
Status instance_exit_initialisation(Instance *i, const char *function);
Status instance_evaluate(Instance *i);
void instance_retune(Instance *i); /* after a tunable parameter was set between two steps */
Status instance_step(Instance *i, const char *function, double t, double h);
Status instance_terminate(Instance *i, const char *function);
Status instance_reset(Instance *i, const char *function);

/* values.c: `count` values for the `n` variables. Nothing is changed by a set that is refused. */
Status get_reals(Instance *, const char *, const uint32_t vr[], size_t n, double *, size_t count);
Status set_reals(Instance *, const char *, const uint32_t vr[], size_t n, const double *, size_t);
Status get_integers(Instance *, const char *, Type, const uint32_t vr[], size_t n, void *values,
                    size_t width, size_t count);
Status set_integers(Instance *, const char *, Type, const uint32_t vr[], size_t n,
                    const void *values, size_t width, size_t count);
Status get_strings(Instance *, const char *, const uint32_t vr[], size_t n, const char **, size_t);
Status set_strings(Instance *, const char *, const uint32_t vr[], size_t n, const char *const *,
                   size_t count);

/* snapshot.c: the whole instance as one block of bytes. */
Status snapshot_get(Instance *i, const char *function, void **snapshot);
Status snapshot_set(Instance *i, const char *function, const void *snapshot);
Status snapshot_free(Instance *i, const char *function, void **snapshot);
Status snapshot_size(Instance *i, const char *function, const void *snapshot, size_t *size);
Status snapshot_serialise(Instance *i, const char *function, const void *snapshot, void *bytes,
                          size_t size);
Status snapshot_deserialise(Instance *i, const char *function, const void *bytes, size_t size,
                            void **snapshot);

#endif
