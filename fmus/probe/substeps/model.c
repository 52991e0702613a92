#include "probe_substeps_variables.h"

struct State {
    double integral;
    int64_t steps;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r) { return NULL; }

void model_outputs(Variables *v, const State *s)
{
    v->integral = s->integral;
    v->steps = s->steps;
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    if (h > v->maximum_step * (1.0 + 1e-9)) {
        report_severity(r, SEVERITY_DISCARD);
        return report_format(r, "The step is %g s; the longest is %g s.", h, v->maximum_step);
    }
    s->integral += h * v->rate;
    ++s->steps;
    return NULL;
}
