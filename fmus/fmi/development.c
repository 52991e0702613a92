/* A model as a plain shared library, without FMI: for trying and testing models from Python
   (fmus.development). One instance a library, since a test loads as many as it likes. */
#include "platform.h"
#include "report.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

EXPORT size_t development_state_size(void);
EXPORT size_t development_state_room(void);
EXPORT const char *development_initialise(Variables *v, State *s, double start_time);
EXPORT void development_outputs(Variables *v, const State *s);
EXPORT const char *development_step(Variables *v, State *s, double t, double h);

static struct Report report;

size_t development_state_size(void) { return model_state_size; }

size_t development_state_room(void)
{
    return ((model_state_size + 15) & ~(size_t)15) + model_work_bytes;
}

const char *development_initialise(Variables *v, State *s, double start_time)
{
    memset(s, 0, development_state_room());
    report.start_time = start_time;
    return model_initialise(v, s, &report);
}

void development_outputs(Variables *v, const State *s) { model_outputs(v, s); }

const char *development_step(Variables *v, State *s, double t, double h)
{
    return model_step(v, s, t, h, &report);
}
