/* The compiled loop of the master: it runs a plan over raw FMI functions.

   Freestanding C: no allocation and no libc. Every pointer is owned by the caller (Python), which
   lays out the structures below field by field (cosim/master/kernel/native.py). A cell is 8 bytes: a
   double, or an int64 for every other numeric type. */

#ifndef COHAPTIC_KERNEL_H
#define COHAPTIC_KERNEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { KERNEL_ABI = 13 };

/* FMI status codes that both versions share (FMI 2.0.4 section 2.1.3, FMI 3.0 section 2.2.3). */
enum { STATUS_OK = 0, STATUS_WARNING = 1 };

/* What kernel_run and kernel_evaluate return. */
typedef enum {
    OUTCOME_DONE = 0,
    OUTCOME_CALL = 1,         /* a Python component is due: serve `operation`, then call again */
    OUTCOME_STATUS = 2,       /* an FMI function returned `status` */
    OUTCOME_NOT_A_NUMBER = 3, /* an FMU put NaN into `cell` */
    OUTCOME_RANGE = 4,        /* `cell` does not fit the type of the input, or an output a cell */
    OUTCOME_EARLY_RETURN = 5, /* an FMI 3 FMU stopped inside its step */
    OUTCOME_TERMINATED = 6,   /* an FMI 3 FMU asked for the end of the simulation */
    OUTCOME_OVERFLOW = 7,     /* more packets in flight than the plan foresaw */
    OUTCOME_EVENT = 8         /* an FMU in event mode did what `event_fault` says */
} Outcome;

typedef enum {
    KIND_COPY = 0,
    KIND_CONVERT = 1,
    KIND_SET_FLOAT64 = 2,
    KIND_GET_FLOAT64 = 3,
    KIND_SET = 4,
    KIND_GET = 5,
    KIND_STEP = 6,
    KIND_CALL = 7,
    KIND_DELIVER = 8,
    KIND_SAMPLE = 9,
    KIND_SEND = 10,
    KIND_RECORD = 11,
    KIND_TUNE = 12,
    KIND_PLAY = 13,
    KIND_STEP_IN_PARTS = 14 /* several steps a period, or event mode */
} Kind;

/* The type behind KIND_SET and KIND_GET. */
typedef enum {
    TYPE_FLOAT64 = 0,
    TYPE_FLOAT32 = 1,
    TYPE_INT8 = 2,
    TYPE_UINT8 = 3,
    TYPE_INT16 = 4,
    TYPE_UINT16 = 5,
    TYPE_INT32 = 6,
    TYPE_UINT32 = 7,
    TYPE_INT64 = 8,
    TYPE_UINT64 = 9,
    TYPE_BOOLEAN = 10,       /* FMI 3: one byte */
    TYPE_BOOLEAN_INT = 11    /* FMI 2: an int that is 0 or 1 */
} Type;

typedef union {
    double real;
    int64_t integer;
} Cell;

/* One linear or type conversion on the way from an output to an input (KIND_CONVERT). */
typedef struct {
    int64_t source;
    int64_t target;
    int64_t from_integer; /* the source cell holds an int64 */
    double gain;
    double offset;
} Conversion;

/* What may be turned (KIND_TUNE): the cells of what is wanted, and how far it may go. Those of the
   operation hold what is in force. */
typedef struct {
    const Cell *wanted;
    double minimum;
    double maximum;
    int64_t is_real; /* the cells hold doubles */
    int64_t by_call; /* Python carries the change out */
    const int64_t *items; /* of an enumeration: the values that it has */
    int64_t item_count;   /* 0 where it is none */
} Knob;

/* Whether an enumeration has a value: its numbers may have gaps. */
static inline bool is_among(int64_t value, const int64_t *values, int64_t count)
{
    for (int64_t i = 0; i < count; i++)
        if (values[i] == value)
            return true;
    return false;
}

/* Rows that are shown over time (KIND_PLAY): `width` cells each, the times in base ticks, rising. */
typedef struct {
    const double *times;
    const double *rows;
    int64_t count; /* 1 at least */
    int64_t width;
    int64_t is_linear; /* between two rows: on the line through them, else the one before */
    int64_t row;       /* where the last search ended: a hint, no state */
} Played;

/* An event: a cell gets a value when a tick begins. */
typedef struct {
    int64_t tick;
    int64_t cell;
    Cell value;
} Change;

/* An FMU instance and its constant step. */
typedef struct {
    void *instance;
    void *do_step;
    int64_t version;
    int64_t period;   /* ticks */
    int64_t substeps; /* doStep calls in one period */
    double step;      /* s, of one doStep */
    int64_t foreign;  /* not ours: it may change how the processor computes */
    int64_t warnings;
    struct Events *events; /* NULL where event mode is not used */
} Instance;

typedef struct {
    int32_t kind;
    int32_t owner; /* instance, bundle, record or component that is called, by kind */
    int32_t type;
    int32_t version;    /* FMI major version of the function, or of the FMU that is stepped */
    Instance *instance; /* of a set, a get, or a step */
    void *function;
    const uint32_t *references;
    int64_t reference_count;
    Cell *cells;        /* first cell of a set or get */
    int64_t cell_count; /* values of a set or get; pairs of a copy; columns of a record */
    void *scratch;      /* room for cell_count values of `type` */
    /* pairs of int32 (from, to), Conversions, int32 columns, Items (set), a Knob (tune), or what is
       Played */
    const void *table;
    int64_t copy_count; /* pairs that are copied first (set of reals); those of a run lie side by side */
} Operation;

/* Operations that lie side by side and are done in one go: of one kind and one version of FMI where
   they set or get reals or step, else a single one. */
typedef struct {
    const Operation *first;
    const Operation *end;
} Run;

/* One stream of packets: the variables of one channel, direction and rate, or one sampled
   connection inside a station. */
typedef struct {
    int64_t period;
    int64_t width;          /* cells in a packet */
    const int32_t *sources; /* width source cells */
    Cell *held;             /* width cells that the receiver reads */
    Cell *age;              /* ticks since the held packet was sampled */
    Cell *held_sequence;    /* -1 before the first arrival */
    int64_t sampled;        /* tick at which the held packet was sampled */
    int64_t sequence;       /* of the next packet to send */
    int64_t immediate;      /* this tick's packet has no delay and arrives at once */
    int64_t delay;          /* ticks, where there is no table of fates */
    const int64_t *fates;   /* delay of each packet in ticks, -1 lost; NULL: all the same */
    const int64_t *copies;  /* delay of its second copy in ticks, -1 none */
    int64_t fate_first;     /* sequence of fates[0] */
    int64_t fate_count;
    int64_t capacity;
    int64_t in_flight;
    int64_t next_arrival;
    int64_t *arrival;
    int64_t *flight_sequence;
    int64_t *flight_sampled; /* -1 for a second copy, which has no payload */
    Cell *payload;           /* capacity * width */
    int64_t sent, delivered, lost, late, duplicate;
} Bundle;

/* Where the rows of one rate group go during this chunk. */
typedef struct {
    Cell *rows;
    int64_t row;
    int64_t row_count;
} Record;

typedef struct {
    Cell *cells;
    const Operation *operations;
    const Run *runs;              /* of all programs, one after another */
    const int64_t *program_start; /* program count + 1 */
    const int32_t *pattern;       /* program of each tick of the hyperperiod */
    int64_t hyperperiod;
    int64_t first_program; /* of tick 0 */
    Instance *instances;
    Bundle *bundles;
    Record *records;
    int64_t tick_numerator; /* a tick is tick_numerator / tick_denominator seconds */
    int64_t tick_denominator;
    int64_t start_tick; /* how many ticks after time 0 tick 0 is */
    const Change *changes; /* in the order of their ticks */
    int64_t change_count;
    int64_t next_change;

    int64_t float_mode;  /* how the processor has to compute */
    int64_t has_foreign; /* whether any instance may change that */
    int64_t careful;     /* ticks for which it is looked at after every call, then once a tick */

    int64_t tick;     /* the tick that is running, or the next one */
    int64_t phase;    /* tick modulo hyperperiod */
    int64_t running;  /* program that is running, -1 between ticks */
    int64_t position; /* next run of that program */

    int64_t kind; /* of the operation that is running, and whose it is: read after a death */
    int64_t owner;
    int64_t operation; /* where it stopped, and why */
    int64_t status;
    int64_t cell;
    int64_t event_call; /* what the FMU is called for at an event */
    int64_t event_fault;
    int64_t event_clock;
    double event_value;
} Kernel;

/* What an FMU says through its logger, a line a message: in `text` what is well, in `grave`, behind
   the digit of its status, what is not. The newest `capacity` bytes of each are kept. */
typedef struct {
    char *text;
    char *grave;
    int64_t capacity; /* of each */
    int64_t used;
    int64_t grave_used;
    int64_t messages;
    void *next; /* the next log that is open */
} Log;

/* What is known of the values of one stream of a link: all arrays have `size` members. */
typedef struct {
    int64_t size;
    const double *minimum;
    const double *maximum;
    const double *step;   /* largest change in one base tick */
    const int64_t *whole; /* not 0 where only integers may be */
    double *reference;    /* the newest accepted values */
} Admission;

/* What the kernel's process and that of an isolated FMU share; references and values follow it. The
   first eight fields are written by the master, and the next six with the answer: 64 bytes each, so
   that a request and its answer cross from one processor to the other once. */
typedef struct {
    int64_t asked; /* requests so far */
    int64_t request;
    int64_t most_references; /* room for so many */
    int64_t most_bytes;      /* of values */
    int64_t reference_count;
    int64_t value_count;
    double time;
    double step;
    int64_t answered;
    int64_t status;
    int64_t event;
    int64_t terminate;
    int64_t early_return;
    double last_time;
    int64_t worker_sleeps;
    int64_t master_sleeps;
} Exchange;

/* read(2) and write(2) of the process: the kernel has no C library of its own. */
typedef int64_t (*Transfer)(int file, void *buffer, size_t count);

/* One side of it. */
typedef struct {
    Exchange *exchange;
    void *read;
    void *write;
    int64_t ear; /* pipes to sleep on, and to wake the other side with */
    int64_t mouth;
    int64_t looks; /* before it sleeps */
    int64_t version;
    void *const *functions; /* the FMU's, by request; in its process alone */
    int64_t is_gone;
} Isolation;

/* Values of one type that an FMU gets before its initialisation. */
typedef struct {
    void *function;
    const uint32_t *references;
    int64_t reference_count;
    void *values;
    int64_t value_count;
} Setting;

/* How an FMU of ours becomes ready for another run. */
typedef struct {
    void *instance;
    int64_t version;
    void *reset;
    void *set_up; /* FMI 2 alone */
    void *enter;
    void *leave;
    const Setting *settings;
    int64_t setting_count;
    Log *log;
    double start; /* s */
    double stop;
    int64_t status; /* of the last call */
} Restart;

typedef int (*Access2)(void *instance, const uint32_t *references, size_t count, void *values);
typedef int (*Access3)(void *instance, const uint32_t *references, size_t count, void *values,
                       size_t value_count);
typedef int (*Step2)(void *instance, double time, double step, int no_set_state_before);
/* What an FMU says with a bool: any byte but 0 is true, and not every FMU writes 1. */
typedef unsigned char Truth;

typedef int (*Step3)(void *instance, double time, double step, bool no_set_state_before,
                     Truth *event, Truth *terminate, Truth *early_return, double *last_time);

Outcome get_values(Kernel *kernel, const Operation *operation, Instance *instance);
Outcome set_values(Kernel *kernel, const Operation *operation, Instance *instance);
Outcome step_in_parts(Kernel *kernel, Instance *instance);
Outcome step_with_events(Kernel *kernel, Instance *instance);

void apply_changes(Kernel *kernel);
Outcome tune(Kernel *kernel, const Operation *operation);

void deliver(Bundle *bundle, int64_t tick);
bool send_packet(Bundle *bundle, const Cell *cells, int64_t tick);

EXPORT int64_t kernel_abi(void);
EXPORT int32_t kernel_run(Kernel *kernel, int64_t end);
EXPORT int32_t kernel_evaluate(Kernel *kernel, int64_t program);
EXPORT int64_t kernel_restart(Restart *restarts, int64_t count);
EXPORT int64_t kernel_leave_initialisation(Restart *restarts, int64_t count);
EXPORT int64_t link_admit(const Admission *admission, const double *values, int64_t ticks,
                          double *out, int64_t newest);
EXPORT int64_t kernel_first_nan(const double *cells, const int64_t *which, int64_t count);
EXPORT int64_t kernel_float_mode(void);
EXPORT int64_t kernel_restore_float_mode(int64_t mode);
EXPORT void *kernel_on_leaving(void (*say)(void));
EXPORT void kernel_leaving(void *unused);
EXPORT uint64_t kernel_checksum(const uint64_t *words, int64_t count);
EXPORT void *kernel_isolated(int64_t version, int64_t type, int64_t is_set);
EXPORT int32_t kernel_isolated_ask(Isolation *own);
EXPORT int32_t kernel_isolated_serve(Isolation *own, void *instance);
EXPORT void kernel_log_open(Log *log);
EXPORT void kernel_log_close(Log *log);
EXPORT Log *kernel_log_stray(void);
EXPORT void kernel_log_fmi2(void *environment, const char *instance, int status,
                            const char *category, const char *message, ...);
EXPORT void kernel_log_fmi3(void *environment, int status, const char *category,
                            const char *message);

#endif
