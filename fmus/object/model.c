/* A mass on one axis under forces held over a step: equation (3.2), discretised exactly. */
#include "object_variables.h"

struct State {
    double position, velocity;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    if (!(v->mass > 0.0))
        return report_format(r, "mass is %g kg; give a mass above zero.", v->mass);
    s->position = v->initial_position;
    s->velocity = v->initial_velocity;
    return NULL;
}

void model_outputs(Variables *v, const State *s)
{
    v->position = s->position;
    v->velocity = s->velocity;
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    double force = -v->compensation * s->velocity;
    force -= v->wall_stiffness * (s->position - v->wall_position) + v->wall_damping * s->velocity;
    for (size_t i = 0; i < sizeof v->force / sizeof *v->force; ++i)
        force += v->force[i];
    const double acceleration = force / v->mass;
    s->position += h * s->velocity + 0.5 * h * h * acceleration;
    s->velocity += h * acceleration;
    return NULL;
}
