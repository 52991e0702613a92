/* Distributed architecture: see README.md beside this file for the equations and their sources. */
#include "distributed_workstation_variables.h"
#include "environment.h"

struct State {
    Station station;
    World world;
    StationState own;
    WorldState environment;
    SentPacket sent;
    Intent intent[PEERS];
};

const size_t model_state_size = sizeof(State);

/* What the inputs of a tick come to; model_step takes it over from model_outputs. */
typedef struct {
    FingerMeasurement measured[FINGERS];
    WorldForces forces;
    SentPacket sent;
} Evaluation;

_Static_assert(sizeof(Evaluation) <= MODEL_WORK_BYTES, "raise Model.work_bytes");

void model_retune(const Variables *v, State *s)
{
    environment_tune(v, &s->world);
    s->world.coupling = (Coupling){v->coupling_stiffness,            v->coupling_damping,
                                   v->coupling_rotational_stiffness, v->coupling_rotational_damping,
                                   v->coupling_force_limit,          v->coupling_torque_limit};
    /* Every copy has the same couplers: the receiver's are ours. */
    Deadband *deadband = &s->station.deadband;
    for (int f = MOTION_FINGER_1; f <= MOTION_FINGER_2; f++) {
        deadband->stiffness[f] = v->remote_normal_stiffness;
        deadband->damping[f] = v->remote_normal_damping;
    }
    deadband->stiffness[MOTION_BOX] = v->coupling_stiffness;
    deadband->damping[MOTION_BOX] = v->coupling_damping;
    deadband->stiffness[MOTION_BOX_ANGLE] = v->coupling_rotational_stiffness;
    deadband->damping[MOTION_BOX_ANGLE] = v->coupling_rotational_damping;
}

const char *model_initialise(Variables *v, State *s, Report *r)
{
    if (v->peers < 0 || v->peers > PEERS) return "peers must be between 0 and 3.";
    const char *wrong = station_set_up(v, &s->station, &s->own, r);
    model_retune(v, s);
    s->station.deadband.predicted = v->predictor == PREDICTOR_LINEAR;
    return wrong ? wrong : environment_set_up(v, &s->world, &s->environment, r);
}

static SentPacket send(const State *s, const FingerMeasurement measured[FINGERS])
{
    Packet now = {0};
    pack_fingers(measured, &now);
    pack_box(&s->environment.box, &now);
    return packet_send(&s->station.deadband, &s->sent, &now, station_felt(&s->own), s->own.tick);
}

/* Not inlined: one large stack frame is enough. */
__attribute__((noinline)) static const Evaluation *evaluate(const Variables *v, const State *s)
{
    Evaluation *found = model_work(s);
    WorldInput input;
    station_measure(v, &s->station, &s->own, found->measured);
    own_fingers(found->measured, &input);
    for (int p = 0; p < PEERS; p++) {
        Motion motion[MOTIONS];
        READ_FINGER_MOTIONS(motion, &v->peer[p]);
        READ_BOX_MOTIONS(motion, &v->peer[p]);
        move_on(v, p, &s->intent[p], s->own.tick, v->peer[p].source_tick, v->peer[p].source_age,
                motion);
        PeerInput *peer = &input.peer[p];
        const Motion *box = &motion[MOTION_BOX], *angle = &motion[MOTION_BOX_ANGLE];
        peer->weight = peer_weight(v, p);
        peer->coupled = p < v->peers && v->peer[p].source_tick >= 0;
        peer->box.velocity = (Planar){box->velocity.x, box->velocity.y, angle->velocity.x};
        peer->box.pose = (Planar){box->position.x, box->position.y, angle->position.x};
        peer_fingers(v, p, v->peer[p].source_tick, v->peer[p].status, motion, peer);
    }
    world_forces(&s->world, &s->environment, &input, &found->forces);
    found->sent = send(s, found->measured);
    return found;
}

void model_outputs(Variables *v, const State *s)
{
    const Evaluation *now = evaluate(v, s);
    environment_outputs(v, &s->station, &s->own, &s->world, &s->environment, now->measured,
                        &now->forces);
    WRITE_FINGERS(v->shared, now->sent.packet);
    WRITE_BOX(v->shared, now->sent.packet);
    WRITE_SOURCE(v->shared, v, now->measured, s->own.tick, &now->sent, contact_bit(&now->forces));
    v->packets_due = now->sent.due;
    v->packets_sent = now->sent.sent;
    for (int p = 0; p < PEERS; p++) WRITE_PEER_CONTACTS(v->peer_contact[p], &now->forces, p);
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    (void)t;
    const char *wrong = station_check_step(&s->station, h, r);
    if (wrong) return wrong;
    const Evaluation *now = report_outputs_are_current(r) ? model_work(s) : evaluate(v, s);
    s->sent = now->sent;
    for (int p = 0; p < PEERS; p++) {
        Motion motion[MOTIONS];
        READ_FINGER_MOTIONS(motion, &v->peer[p]);
        READ_BOX_MOTIONS(motion, &v->peer[p]);
        hear_peer(v, p, &s->intent[p], v->peer[p].source_tick, v->peer[p].source_age, motion);
    }
    environment_commit(v, &s->station, &s->own, &s->world, &s->environment, now->measured,
                       &now->forces);
    return NULL;
}
