/* Centralized architecture, server: see README.md beside this file for the equations. */
#include "central_server_variables.h"
#include "environment.h"

struct State {
    Station station;
    World world;
    StationState own;
    WorldState environment;
    SentPacket sent[PEERS];
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    if (v->peers < 0 || v->peers > PEERS) return "peers must be between 0 and 3.";
    const char *wrong = station_set_up(v, &s->station, &s->own, r);
    s->station.deadband.forces_only = true;
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
            prediction_time(v, p, s->own.tick, v->client[p].source_tick, v->client[p].source_age);
        input.peer[p].weight = peer_weight(v, p);
        input.peer[p].coupled = false;
        READ_PEER_FINGERS(&input.peer[p], &v->client[p], p, ahead);
    }
    world_forces(&s->world, &s->environment, &input, forces);
}

static SentPacket send(const State *s, const WorldForces *forces, int p)
{
    Packet now = {.force = {forces->peer[p][0].force, forces->peer[p][1].force}};
    pack_box(&s->environment.box, &now);
    return packet_send(&s->station.deadband, &s->sent[p], &now, s->own.tick);
}

void model_outputs(Variables *v, const State *s)
{
    FingerMeasurement measured[FINGERS];
    WorldForces forces;
    evaluate(v, s, measured, &forces);
    environment_outputs(v, &s->station, &s->own, &s->world, &s->environment, measured, &forces);
    v->packets_due = v->packets_sent = 0;
    for (int p = 0; p < PEERS; p++) {
        const SentPacket sent = send(s, &forces, p);
        WRITE_VECTOR(v->to_client[p].finger_1_force, sent.packet.force[0]);
        WRITE_VECTOR(v->to_client[p].finger_2_force, sent.packet.force[1]);
        WRITE_BOX(v->to_client[p], sent.packet);
        WRITE_SOURCE(v->to_client[p], v, measured, s->own.tick, &sent, contact_bit(&forces));
        WRITE_PEER_CONTACTS(v->client_contact[p], &forces, p);
        if (p >= v->peers) continue;
        v->packets_due += sent.due;
        v->packets_sent += sent.sent;
    }
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    (void)t;
    const char *wrong = station_check_step(&s->station, h, r);
    if (wrong) return wrong;
    FingerMeasurement measured[FINGERS];
    WorldForces forces;
    evaluate(v, s, measured, &forces);
    for (int p = 0; p < PEERS; p++) s->sent[p] = send(s, &forces, p);
    environment_commit(v, &s->station, &s->own, &s->world, &s->environment, measured, &forces);
    return NULL;
}
