/* What a model implements, and what it may use. Freestanding C (gnu11): beside this header only
   <stdint.h>, <stddef.h>, <stdbool.h>, <float.h> and cohaptic_math.h; no libc, no allocation.

   A model's C file includes its generated <model>_variables.h (which includes this header and
   defines Variables, one 8-byte slot per element), defines `struct State` and `model_state_size`,
   and implements the three functions below. Everything that lasts from one step to the next lives
   in State: plain data, no pointers. The glue copies Variables and State to save and restore an
   FMU, so nothing may hide in a static variable. */
#ifndef COHAPTIC_MODEL_H
#define COHAPTIC_MODEL_H

#include <float.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "cohaptic_math.h"

typedef struct Variables Variables;
typedef struct State State;
typedef struct Report Report;

extern const size_t model_state_size; /* sizeof(State) */

/* How many bytes of *s are in use, from its beginning: a table at its end counts with the rows that
   it holds, and more than model_state_size says that *s is damaged. Models whose State has no such
   table (Model.state_ends_in_table) get one that returns model_state_size. What is behind is never
   read, and no part of a saved state. */
size_t model_state_used(const State *s);

/* Leaving initialisation mode: validate the parameters and set up *s, which is all zeros. Returns
   NULL, or a sentence that says what is wrong and what to do. May write calculatedParameters.
   In initialisation mode it is also called on a scratch state whenever outputs are asked for. */
const char *model_initialise(Variables *v, State *s, Report *r);

/* Between two steps tunable parameters were set: take over into *s what model_initialise has worked
   out of them. Their limits are those of the description. Models that read them where they use them
   (all but those with Model.retunes) get one that does nothing. */
void model_retune(const Variables *v, State *s);

/* Outputs and locals into *v, a pure function of (*s, the inputs and parameters in *v): it may be
   called any number of times, or not at all, between two steps. */
void model_outputs(Variables *v, const State *s);

/* Commit [t, t + h) with the inputs as they are at its start. NULL, or an error sentence; then *s
   must be as it was. */
const char *model_step(Variables *v, State *s, double t, double h, Report *r);

/* Room for MODEL_WORK_BYTES (Model.work_bytes of the table) behind the state, for what
   model_outputs has worked out and a later call can use again. It is no part of the state: it is
   all zeros after anything but model_outputs and model_step has touched state or parameters. */
extern const size_t model_work_bytes;
static inline void *model_work(const State *s)
{
    return (char *)s + ((model_state_size + 15) & ~(size_t)15);
}

/* In model_step: whether model_outputs was called with this state and these inputs. */
bool report_outputs_are_current(const Report *r);

/* Write a sentence into the report's buffer (512 bytes, cut off at its end) and return it, ready
   to be returned as an error or logged. Conversions: %s (const char *), %d (int), %g (double,
   9 significant digits), %%. */
const char *report_format(Report *r, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Log a sentence for information; the importer sees it when it has logging switched on. */
void report_log(Report *r, const char *sentence);

/* How grave the sentence is that model_step is about to return; an error unless said otherwise. */
typedef enum { SEVERITY_DISCARD = 2, SEVERITY_ERROR = 3, SEVERITY_FATAL = 4 } Severity;
void report_severity(Report *r, Severity severity);

/* The time at which the simulation starts, s; for use in model_initialise. */
double report_start_time(const Report *r);

/* Read a text file of numbers: `columns` numbers a line, separated by commas, semicolons or white
   space; empty lines, lines that start with '#' and one heading line are skipped. Numbers are
   rounded correctly. Fills rows[0 .. *count)[columns] up to `capacity` rows. NULL, or a sentence
   that says what is wrong with the file. */
const char *report_read_table(Report *r, const char *path, size_t columns, size_t capacity,
                              double *rows, size_t *count);

#endif
