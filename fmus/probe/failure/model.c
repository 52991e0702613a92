#include "probe_failure_variables.h"

struct State {
    int64_t steps;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    return v->kind == FAILURE_KIND_INITIALISE ? "This probe refuses to start, as it was told to."
                                              : NULL;
}

void model_outputs(Variables *v, const State *s)
{
    v->value = (double)s->steps;
    if (s->steps >= v->at && v->kind == FAILURE_KIND_NAN)
        v->value = NAN;
    if (s->steps >= v->at && v->kind == FAILURE_KIND_INFINITE)
        v->value = INFINITY;
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    if (s->steps == v->at) {
        if (v->kind == FAILURE_KIND_CRASH)
            __builtin_trap();
        if (v->kind == FAILURE_KIND_DISCARD)
            report_severity(r, SEVERITY_DISCARD);
        if (v->kind == FAILURE_KIND_FATAL)
            report_severity(r, SEVERITY_FATAL);
        if (v->kind >= FAILURE_KIND_DISCARD && v->kind <= FAILURE_KIND_FATAL)
            return report_format(r, "This probe fails in the step from %g s, as it was told to.", t);
    }
    ++s->steps;
    return NULL;
}
