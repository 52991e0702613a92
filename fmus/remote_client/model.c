/* Centralized architecture, client: see README.md beside this file for the equations. */
#include "remote_client_variables.h"
#include "workstation.h"

struct State {
    Station station;
    StationState own;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    return station_set_up(v, &s->station, &s->own, r);
}

/* The received force as far as the server counts, and damping as far as it does not. */
static Vector finger_force(const Variables *v, int f, const FingerMeasurement *measured)
{
    const double *received = f ? v->down.finger_2_force : v->down.finger_1_force;
    const bool usable = v->peer_valid[0] && isfinite(received[0]) && isfinite(received[1]);
    const double weight = usable ? fmin(fmax(v->peer_weight[0], 0.0), 1.0) : 0.0;
    const double damping = (1.0 - weight) * v->local_damping;
    Vector force = times(-damping, measured->velocity);
    if (weight > 0.0) force = plus(force, times(weight, (Vector){received[0], received[1]}));
    return force;
}

#define WRITE_FINGER(number) \
    do { \
        for (int i = 0; i < 2; i++) { \
            v->up.finger_##number##_position[i] = v->finger[number - 1].position[i]; \
            v->up.finger_##number##_velocity[i] = v->finger[number - 1].velocity[i]; \
        } \
    } while (0)

void model_outputs(Variables *v, const State *s)
{
    FingerMeasurement measured[FINGERS];
    station_measure(v, &s->station, &s->own, measured);
    for (int f = 0; f < FINGERS; f++)
        station_render(v, &s->station, &s->own, f, &measured[f], finger_force(v, f, &measured[f]));
    WRITE_FINGER(1);
    WRITE_FINGER(2);
    WRITE_SOURCE(v->up, v, measured, s->own.tick, 0);
    v->box_pose.x = v->down.box_x;
    v->box_pose.y = v->down.box_y;
    v->box_pose.theta = v->down.box_theta;
    v->box_velocity.x = v->down.box_vx;
    v->box_velocity.y = v->down.box_vy;
    v->box_velocity.theta = v->down.box_omega;
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    (void)t;
    const char *wrong = station_check_step(&s->station, h, r);
    if (wrong) return wrong;
    FingerMeasurement measured[FINGERS];
    station_measure(v, &s->station, &s->own, measured);
    Vector force[FINGERS];
    for (int f = 0; f < FINGERS; f++) force[f] = finger_force(v, f, &measured[f]);
    station_commit(v, &s->station, &s->own, measured, force);
    return NULL;
}
