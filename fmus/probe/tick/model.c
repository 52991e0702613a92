#include "probe_tick_variables.h"

struct State {
    int64_t steps, last_heard;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    s->last_heard = -1;
    return NULL;
}

void model_outputs(Variables *v, const State *s)
{
    v->tick = v->first_tick + s->steps * v->period;
    v->tick_real = (double)v->tick;
    v->seen = v->heard;
    v->seen_real = v->heard_real;
    v->last_heard = s->last_heard;
    v->steps = s->steps;
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    ++s->steps;
    s->last_heard = v->heard;
    return NULL;
}
