/* A spring and a damper between two bodies: equation (3.4), with an optional computation delay. */
#include "virtual_coupler_variables.h"

enum { LONGEST_DELAY = 8 };

struct State {
    double force[LONGEST_DELAY]; /* of the last steps, the latest first */
};

const size_t model_state_size = sizeof(State);

static double force_now(const Variables *v)
{
    return v->stiffness * (v->position_a - v->position_b) +
           v->damping * (v->velocity_a - v->velocity_b);
}

const char *model_initialise(Variables *v, State *s, Report *r) { return NULL; }

void model_outputs(Variables *v, const State *s)
{
    const int64_t delay = v->computation_delay_ticks;
    v->force = delay > 0 ? s->force[delay - 1] : force_now(v);
    v->reaction = -v->force;
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    for (int i = LONGEST_DELAY - 1; i > 0; --i)
        s->force[i] = s->force[i - 1];
    s->force[0] = force_now(v);
    return NULL;
}
