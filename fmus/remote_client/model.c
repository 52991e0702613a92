/* Centralized architecture, client: see README.md beside this file for the equations. */
#include "remote_client_variables.h"
#include "wave.h"
#include "workstation.h"

/* The client's end of a wave channel, for one finger. */
typedef struct {
    WavePort back;   /* beta, from the server */
    Vector integral; /* of beta, N.s */
    Vector origin;   /* first position of the finger, m */
    int64_t started;
} WaveEnd;

struct State {
    Station station;
    StationState own;
    SentPacket sent;
    WaveEnd wave[FINGERS];
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    if (v->force_channel == FORCECHANNEL_WAVE && !(v->wave_impedance > 0.0))
        return "wave_impedance must be positive.";
    const char *wrong = station_set_up(v, &s->station, &s->own, r);
    for (int f = MOTION_FINGER_1; f <= MOTION_FINGER_2; f++) {
        s->station.deadband.stiffness[f] = v->deadband_stiffness;
        s->station.deadband.damping[f] = v->deadband_damping;
    }
    return wrong;
}

/* How much of what the server says counts, 0 to 1. */
static double server_weight(const Variables *v)
{
    return v->peer_valid[0] ? fmin(fmax(v->peer_weight[0], 0.0), 1.0) : 0.0;
}

static WaveEnd wave_end(const Variables *v, const State *s, int f, const FingerMeasurement *measured)
{
    WaveEnd end = s->wave[f];
    if (!end.started) end.origin = measured->position;
    end.started = 1;
    end.back = wave_receive(&end.back, f ? v->down.finger_2_wave : v->down.finger_1_wave,
                            v->down.source_tick, server_weight(v) > 0.0, v->sample_period);
    return end;
}

/* What the server would have the finger feel. */
static Vector server_force(const Variables *v, const State *s, int f,
                           const FingerMeasurement *measured)
{
    if (v->force_channel == FORCECHANNEL_WAVE) {
        const WaveEnd end = wave_end(v, s, f, measured);
        return minus(end.back.wave, times(v->wave_impedance, measured->velocity));
    }
    const double *received = f ? v->down.finger_2_force : v->down.finger_1_force;
    return (Vector){received[0], received[1]};
}

/* The server's force as far as the server counts, and damping as far as it does not. */
static Vector finger_force(const Variables *v, const State *s, int f,
                           const FingerMeasurement *measured)
{
    const Vector received = server_force(v, s, f, measured);
    const bool usable = isfinite(received.x) && isfinite(received.y);
    const double weight = usable ? server_weight(v) : 0.0;
    const double damping = (1.0 - weight) * v->local_damping;
    const Vector force = times(-damping, measured->velocity);
    return weight > 0.0 ? plus(force, times(weight, received)) : force;
}

static SentPacket send(const State *s, const FingerMeasurement measured[FINGERS])
{
    Packet now = {0};
    pack_fingers(measured, &now);
    return packet_send(&s->station.deadband, &s->sent, &now, station_felt(&s->own), s->own.tick);
}

/* The integral of alpha = 2 b v - beta up to this tick: nothing of what arrives now is in it, so
 * that client and server are no algebraic loop even without delay. */
static Vector outgoing_wave(const Variables *v, const WaveEnd *end,
                            const FingerMeasurement *measured)
{
    if (!end->started) return (Vector){0.0, 0.0};
    const Vector moved = minus(measured->position, end->origin);
    return minus(times(2.0 * v->wave_impedance, moved), end->integral);
}

void model_outputs(Variables *v, const State *s)
{
    FingerMeasurement measured[FINGERS];
    station_measure(v, &s->station, &s->own, measured);
    for (int f = 0; f < FINGERS; f++)
        station_render(v, &s->station, &s->own, f, &measured[f],
                       finger_force(v, s, f, &measured[f]));
    const SentPacket sent = send(s, measured);
    WRITE_FINGERS(v->up, sent.packet);
    WRITE_SOURCE(v->up, v, measured, s->own.tick, &sent, 0);
    WRITE_VECTOR(v->up.finger_1_wave, outgoing_wave(v, &s->wave[0], &measured[0]));
    WRITE_VECTOR(v->up.finger_2_wave, outgoing_wave(v, &s->wave[1], &measured[1]));
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
    for (int f = 0; f < FINGERS; f++) force[f] = finger_force(v, s, f, &measured[f]);
    for (int f = 0; f < FINGERS; f++) {
        WaveEnd end = wave_end(v, s, f, &measured[f]);
        end.integral = plus(end.integral, times(v->sample_period, end.back.wave));
        end.back = wave_consume(&end.back, v->sample_period);
        s->wave[f] = end;
    }
    s->sent = send(s, measured);
    station_commit(v, &s->station, &s->own, measured, force);
    return NULL;
}
