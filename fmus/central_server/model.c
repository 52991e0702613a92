/* Centralized architecture, server: see README.md beside this file for the equations. */
#include "central_server_variables.h"
#include "environment.h"

struct State {
    Station station;
    World world;
    StationState own;
    WorldState environment;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    if (v->peers < 0 || v->peers > PEERS) return "peers must be between 0 and 3.";
    const char *wrong = station_set_up(v, &s->station, &s->own, r);
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

void model_outputs(Variables *v, const State *s)
{
    FingerMeasurement measured[FINGERS];
    WorldForces forces;
    evaluate(v, s, measured, &forces);
    environment_outputs(v, &s->station, &s->own, &s->world, &s->environment, measured, &forces);
    for (int p = 0; p < PEERS; p++) {
        v->to_client[p].finger_1_force[0] = forces.peer[p][0].force.x;
        v->to_client[p].finger_1_force[1] = forces.peer[p][0].force.y;
        v->to_client[p].finger_2_force[0] = forces.peer[p][1].force.x;
        v->to_client[p].finger_2_force[1] = forces.peer[p][1].force.y;
        WRITE_BOX(v->to_client[p], &s->environment.box);
        WRITE_SOURCE(v->to_client[p], v, measured, s->own.tick, contact_bit(&forces));
        WRITE_PEER_CONTACTS(v->client_contact[p], &forces, p);
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
    environment_commit(v, &s->station, &s->own, &s->world, &s->environment, measured, &forces);
    return NULL;
}
