/* Centralized architecture, client: see README.md beside this file for the equations. */
#include "remote_client_variables.h"
#include "workstation.h"

struct State {
    Station station;
    StationState own;
    SentPacket sent;
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

static SentPacket send(const State *s, const FingerMeasurement measured[FINGERS])
{
    Packet now = {0};
    pack_fingers(measured, &now);
    return packet_send(&s->station.deadband, &s->sent, &now, s->own.tick);
}

void model_outputs(Variables *v, const State *s)
{
    FingerMeasurement measured[FINGERS];
    station_measure(v, &s->station, &s->own, measured);
    for (int f = 0; f < FINGERS; f++)
        station_render(v, &s->station, &s->own, f, &measured[f], finger_force(v, f, &measured[f]));
    const SentPacket sent = send(s, measured);
    WRITE_FINGERS(v->up, sent.packet);
    WRITE_SOURCE(v->up, v, measured, s->own.tick, &sent, 0);
    v->packets_due = sent.due;
    v->packets_sent = sent.sent;
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
    s->sent = send(s, measured);
    station_commit(v, &s->station, &s->own, measured, force);
    return NULL;
}
