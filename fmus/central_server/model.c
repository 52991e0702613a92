/* Centralized architecture, server: see README.md beside this file for the equations. */
#include "central_server_variables.h"
#include "environment.h"
#include "wave.h"

/* The server's end of a wave channel, for one client's finger. */
typedef struct {
    WavePort in;     /* alpha, from the client */
    Vector position; /* where the hand is taken to be, m */
    Vector velocity; /* m/s */
    Vector integral; /* of beta, N.s */
} WaveEnd;

struct State {
    Station station;
    World world;
    StationState own;
    WorldState environment;
    SentPacket sent[PEERS];
    WaveEnd wave[PEERS][PEER_FINGERS];
    Intent intent[PEERS];
};

const size_t model_state_size = sizeof(State);

/* Everything at one tick. */
typedef struct {
    FingerMeasurement measured[FINGERS];
    WorldInput input;
    WorldForces forces;
    WaveEnd wave[PEERS][PEER_FINGERS];
} Tick;

void model_retune(const Variables *v, State *s) { environment_tune(v, &s->world); }

const char *model_initialise(Variables *v, State *s, Report *r)
{
    if (v->peers < 0 || v->peers > PEERS) return "peers must be between 0 and 3.";
    if (v->force_channel == FORCECHANNEL_WAVE && !(v->wave_impedance > 0.0))
        return "wave_impedance must be positive.";
    const char *wrong = station_set_up(v, &s->station, &s->own, r);
    return wrong ? wrong : environment_set_up(v, &s->world, &s->environment, r);
}

static void receive_waves(const Variables *v, const State *s, Tick *tick)
{
    for (int p = 0; p < PEERS; p++)
        for (int f = 0; f < PEER_FINGERS; f++) {
            WaveEnd *end = &tick->wave[p][f];
            *end = s->wave[p][f];
            const double *integral = f ? v->client[p].finger_2_wave : v->client[p].finger_1_wave;
            const bool heard = end->in.heard;
            end->in = wave_receive(&end->in, integral, v->client[p].source_tick,
                                   peer_weight(v, p) > 0.0, v->sample_period);
            if (!heard) end->position = tick->input.peer[p].finger[f].position;
        }
}

/* The hand's velocity follows from alpha = b v + F(v), where F is what the coupler, springs, dampers,
 * cone and all, presses on the object: a monotone equation, solved by steps that the steepest damper
 * bounds. Starts from the last tick's velocity, so that a few steps are enough. */
static void solve_waves(const Variables *v, const State *s, Tick *tick)
{
    enum { STEPS = 8 };
    const Surface *k = &s->world.peer_surface;
    const double steepest = v->wave_impedance + fmax(k->normal_damping, k->tangential_damping);
    for (int n = 0; n <= STEPS; n++) {
        for (int p = 0; p < PEERS; p++)
            for (int f = 0; f < PEER_FINGERS; f++) {
                WaveEnd *end = &tick->wave[p][f];
                if (n > 0) {
                    const Vector pressed = times(-1.0, tick->forces.peer[p][f].force);
                    const Vector rest = minus(minus(end->in.wave, pressed),
                                              times(v->wave_impedance, end->velocity));
                    end->velocity = plus(end->velocity, times(1.0 / steepest, rest));
                }
                tick->input.peer[p].finger[f].position = end->position;
                tick->input.peer[p].finger[f].velocity = end->velocity;
            }
        world_forces(&s->world, &s->environment, &tick->input, &tick->forces);
    }
}

/* What client p says; it has no box. */
#define READ_CLIENT(motion, p) \
    do { \
        READ_FINGER_MOTIONS(motion, &v->client[p]); \
        (motion)[MOTION_BOX] = (motion)[MOTION_BOX_ANGLE] = (Motion){{0.0, 0.0}, {0.0, 0.0}}; \
    } while (0)

static void evaluate(const Variables *v, const State *s, Tick *tick)
{
    station_measure(v, &s->station, &s->own, tick->measured);
    own_fingers(tick->measured, &tick->input);
    for (int p = 0; p < PEERS; p++) {
        Motion motion[MOTIONS];
        READ_CLIENT(motion, p);
        move_on(v, p, &s->intent[p], s->own.tick, v->client[p].source_tick,
                v->client[p].source_age, motion);
        PeerInput *peer = &tick->input.peer[p];
        peer->weight = peer_weight(v, p);
        peer->coupled = false;
        peer->box = (BoxState){0}; /* a closed port keeps its place in the state */
        peer_fingers(v, p, v->client[p].source_tick, v->client[p].status, motion, peer);
    }
    if (v->force_channel == FORCECHANNEL_WAVE) {
        receive_waves(v, s, tick);
        solve_waves(v, s, tick);
        return;
    }
    world_forces(&s->world, &s->environment, &tick->input, &tick->forces);
}

static SentPacket send(const State *s, const WorldForces *forces, int p)
{
    Packet now = {.force = {forces->peer[p][0].force, forces->peer[p][1].force}};
    pack_box(&s->environment.box, &now);
    return packet_send(&s->station.deadband, &s->sent[p], &now, 0.0, s->own.tick);
}

void model_outputs(Variables *v, const State *s)
{
    Tick tick;
    evaluate(v, s, &tick);
    environment_outputs(v, &s->station, &s->own, &s->world, &s->environment, tick.measured,
                        &tick.forces);
    v->packets_due = v->packets_sent = 0;
    for (int p = 0; p < PEERS; p++) {
        const SentPacket sent = send(s, &tick.forces, p);
        WRITE_VECTOR(v->to_client[p].finger_1_force, sent.packet.force[0]);
        WRITE_VECTOR(v->to_client[p].finger_2_force, sent.packet.force[1]);
        WRITE_BOX(v->to_client[p], sent.packet);
        WRITE_SOURCE(v->to_client[p], v, tick.measured, s->own.tick, &sent,
                     contact_bit(&tick.forces));
        WRITE_VECTOR(v->to_client[p].finger_1_wave, s->wave[p][0].integral);
        WRITE_VECTOR(v->to_client[p].finger_2_wave, s->wave[p][1].integral);
        WRITE_PEER_CONTACTS(v->client_contact[p], &tick.forces, p);
        if (p >= v->peers) continue;
        v->packets_due += sent.due;
        v->packets_sent += sent.sent;
    }
}

static void commit_waves(const Variables *v, State *s, const Tick *tick)
{
    const double period = v->sample_period;
    for (int p = 0; p < PEERS; p++)
        for (int f = 0; f < PEER_FINGERS; f++) {
            WaveEnd end = tick->wave[p][f];
            const Vector pressed = times(-1.0, tick->forces.peer[p][f].force);
            /* The force is final and the velocity is what remains of the wave: the balance is exact. */
            end.velocity = times(1.0 / v->wave_impedance, minus(end.in.wave, pressed));
            if (end.in.heard) {
                const Vector beta = minus(end.in.wave, times(2.0, pressed));
                end.position = plus(end.position, times(period, end.velocity));
                end.integral = plus(end.integral, times(period, beta));
            }
            end.in = wave_consume(&end.in, period);
            s->wave[p][f] = end;
        }
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    (void)t;
    const char *wrong = station_check_step(&s->station, h, r);
    if (wrong) return wrong;
    Tick tick;
    evaluate(v, s, &tick);
    for (int p = 0; p < PEERS; p++) {
        Motion motion[MOTIONS];
        s->sent[p] = send(s, &tick.forces, p);
        READ_CLIENT(motion, p);
        hear_peer(v, p, &s->intent[p], v->client[p].source_tick, v->client[p].source_age, motion);
    }
    if (v->force_channel == FORCECHANNEL_WAVE) commit_waves(v, s, &tick);
    environment_commit(v, &s->station, &s->own, &s->world, &s->environment, tick.measured,
                       &tick.forces);
    return NULL;
}
