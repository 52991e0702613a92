/* Distributed architecture: see README.md beside this file for the equations and their sources. */
#include "distributed_workstation_variables.h"
#include "environment.h"

struct State {
    Station station;
    World world;
    StationState own;
    WorldState environment;
    SentPacket sent;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    if (v->peers < 0 || v->peers > PEERS) return "peers must be between 0 and 3.";
    s->world.coupling = (Coupling){v->coupling_stiffness,            v->coupling_damping,
                                   v->coupling_rotational_stiffness, v->coupling_rotational_damping,
                                   v->coupling_force_limit,          v->coupling_torque_limit};
    const char *wrong = station_set_up(v, &s->station, &s->own, r);
    s->station.deadband.predicted = v->predictor == PREDICTOR_LINEAR;
    return wrong ? wrong : environment_set_up(v, &s->world, &s->environment, r);
}

static void evaluate(const Variables *v, const State *s, FingerMeasurement measured[FINGERS],
                     WorldForces *forces)
{
    WorldInput input;
    station_measure(v, &s->station, &s->own, measured);
    own_fingers(measured, &input);
    for (int p = 0; p < PEERS; p++) {
        const double ahead =
            prediction_time(v, p, s->own.tick, v->peer[p].source_tick, v->peer[p].source_age);
        PeerInput *peer = &input.peer[p];
        peer->weight = peer_weight(v, p);
        peer->coupled = p < v->peers && v->peer[p].source_tick >= 0;
        peer->box.velocity = (Planar){v->peer[p].box_vx, v->peer[p].box_vy, v->peer[p].box_omega};
        peer->box.pose = (Planar){v->peer[p].box_x + ahead * v->peer[p].box_vx,
                                  v->peer[p].box_y + ahead * v->peer[p].box_vy,
                                  v->peer[p].box_theta + ahead * v->peer[p].box_omega};
        READ_PEER_FINGERS(peer, &v->peer[p], p, ahead);
    }
    world_forces(&s->world, &s->environment, &input, forces);
}

static SentPacket send(const State *s, const FingerMeasurement measured[FINGERS])
{
    Packet now = {0};
    pack_fingers(measured, &now);
    pack_box(&s->environment.box, &now);
    return packet_send(&s->station.deadband, &s->sent, &now, s->own.tick);
}

void model_outputs(Variables *v, const State *s)
{
    FingerMeasurement measured[FINGERS];
    WorldForces forces;
    evaluate(v, s, measured, &forces);
    environment_outputs(v, &s->station, &s->own, &s->world, &s->environment, measured, &forces);
    const SentPacket sent = send(s, measured);
    WRITE_FINGERS(v->shared, sent.packet);
    WRITE_BOX(v->shared, sent.packet);
    WRITE_SOURCE(v->shared, v, measured, s->own.tick, &sent, contact_bit(&forces));
    v->packets_due = sent.due;
    v->packets_sent = sent.sent;
    for (int p = 0; p < PEERS; p++) WRITE_PEER_CONTACTS(v->peer_contact[p], &forces, p);
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    (void)t;
    const char *wrong = station_check_step(&s->station, h, r);
    if (wrong) return wrong;
    FingerMeasurement measured[FINGERS];
    WorldForces forces;
    evaluate(v, s, measured, &forces);
    s->sent = send(s, measured);
    environment_commit(v, &s->station, &s->own, &s->world, &s->environment, measured, &forces);
    return NULL;
}
