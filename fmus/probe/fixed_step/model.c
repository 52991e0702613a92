#include "probe_fixed_step_variables.h"

struct State {
    double end;
    int64_t steps;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    s->end = report_start_time(r);
    return NULL;
}

void model_outputs(Variables *v, const State *s)
{
    v->end = s->end;
    v->steps = s->steps;
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    s->end = t + h;
    ++s->steps;
    return NULL;
}
