/* Between the variables of a workstation that simulates the box and the world of world.h. Included
 * after the generated header and workstation.h. */
#ifndef COHAPTIC_ENVIRONMENT_H
#define COHAPTIC_ENVIRONMENT_H

#include "prediction.h"
#include "workstation.h"
#include "world.h"

#define READ_SURFACE(prefix) \
    ((Surface){v->prefix##_normal_stiffness, v->prefix##_normal_damping, \
               v->prefix##_tangential_stiffness, v->prefix##_tangential_damping, \
               v->static_friction, v->kinetic_friction, v->slide_threshold})

/* A square of side a turns on the ground as if all friction acted at this fraction of a: the mean
 * distance from its centre. */
#define MEAN_DISTANCE 0.383

/* The couplers and the compensation, which may change while it runs. */
static void environment_tune(const Variables *v, World *world)
{
    world->own_surface = READ_SURFACE(local);
    world->peer_surface = READ_SURFACE(remote);
    world->compensation =
        (Planar){v->compensation.x, v->compensation.y, v->compensation.theta};
}

static const char *environment_set_up(const Variables *v, World *world, WorldState *state, Report *r)
{
    if (!(v->mass > 0.0 && v->inertia > 0.0 && v->side > 0.0))
        return "mass, inertia and side of the box must be positive.";
    if (!(v->kinetic_friction >= 0.0 && v->static_friction >= v->kinetic_friction))
        return "static_friction must be at least kinetic_friction, and neither may be negative.";
    const char *wrong = prediction_set_up(v);
    if (wrong) return wrong;
    world->period = v->sample_period;
    world->box = (Box){
        .half_side = 0.5 * v->side,
        .mass = v->mass,
        .inertia = v->inertia,
        .linear_friction = v->ground_friction * v->gravity,
        .rotational_friction = v->ground_rotational_friction * v->mass * v->gravity * MEAN_DISTANCE
                               * v->side / v->inertia,
        .integration = v->integration,
    };
    environment_tune(v, world);
    for (int f = 0; f < FINGERS; f++)
        world->own_limit[f] = v->box_is_pushed_with == PUSH_RENDERED ? v->finger[f].max_force : 0.0;
    for (int f = 0; f < FINGERS; f++)
        world->cancellation[f] = (Cancellation){
            v->hand_mass, v->moment_cancellation ? v->finger[f].max_force : 0.0, v->sample_period};
    for (int w = 0; w < WALLS; w++) {
        const double size = hypot(v->wall[w].normal_x, v->wall[w].normal_y);
        if (v->wall[w].enabled && !(size > 0.0))
            return report_format(r, "wall_%d needs a normal that is not zero.", w + 1);
        world->wall[w] = (Wall){
            .enabled = v->wall[w].enabled,
            .point = {v->wall[w].point_x, v->wall[w].point_y},
            .normal = {v->wall[w].normal_x / size, v->wall[w].normal_y / size},
            .surface = {v->wall[w].normal_stiffness, v->wall[w].normal_damping,
                        v->wall[w].tangential_stiffness, v->wall[w].tangential_damping,
                        v->wall[w].friction, v->wall[w].friction, v->slide_threshold},
        };
    }
    world->soft = v->environment == ENVIRONMENT_MASS_SPRING;
    world->lattice = (Lattice){.spacing = 0.5 * v->side,
                               .stiffness = v->soft_stiffness,
                               .damping = v->soft_damping,
                               .ground_friction = v->ground_friction * v->gravity};
    if (!lattice_weigh(&world->lattice, v->mass, v->inertia) && world->soft)
        return report_format(r, "inertia is %g kg.m2, and a soft square of this mass and side has less "
                                "than three eighths of mass times side squared, %g kg.m2.",
                             v->inertia, 0.375 * v->mass * v->side * v->side);
    if (world->soft && !lattice_is_stable(&world->lattice, 0.0, 0.0, v->sample_period))
        return "soft_stiffness or soft_damping is too large for mass, inertia and sample_period: the "
               "object's own vibration would be unstable. Lower them, or step faster.";
    for (int w = 0; w < WALLS; w++) {
        const Surface *on = &world->wall[w].surface;
        if (!world->soft || !world->wall[w].enabled) continue;
        if (!lattice_is_stable(&world->lattice, on->normal_stiffness, on->normal_damping,
                               v->sample_period)
            || !lattice_is_stable(&world->lattice, on->tangential_stiffness,
                                  on->tangential_damping, v->sample_period))
            return report_format(r, "wall_%d is too stiff or damps too much for the %g kg of a soft "
                                    "square's corner. Lower its stiffness or damping, or step faster.",
                                 w + 1, world->lattice.outer);
    }
    world_place(world, state,
                (Planar){v->initial_box_pose.x, v->initial_box_pose.y, v->initial_box_pose.theta});
    return NULL;
}

static void own_fingers(const FingerMeasurement measured[FINGERS], WorldInput *input)
{
    for (int f = 0; f < FINGERS; f++)
        input->own[f] =
            (FingerInput){measured[f].present, measured[f].position, measured[f].velocity};
}

static double peer_weight(const Variables *v, int p)
{
    if (p >= v->peers || !v->peer_valid[p]) return 0.0;
    return fmin(fmax(v->peer_weight[p], 0.0), 1.0);
}

static FingerInput peer_finger(bool present, const Motion *motion)
{
    return (FingerInput){present, motion->position, motion->velocity};
}

/* The fingers of peer p, moved on, as far as its packet says that they are there. */
static void peer_fingers(const Variables *v, int p, int64_t source_tick, int64_t status,
                         const Motion motion[MOTIONS], PeerInput *peer)
{
    const int64_t there = p < v->peers && source_tick >= 0 ? status : 0;
    peer->finger[0] = peer_finger((there & STATUS_FINGER) != 0, &motion[MOTION_FINGER_1]);
    peer->finger[1] = peer_finger((there & 2 * STATUS_FINGER) != 0, &motion[MOTION_FINGER_2]);
}

#define WRITE_PLANAR(target, planar) \
    do { \
        (target).x = (planar).x; \
        (target).y = (planar).y; \
        (target).theta = (planar).theta; \
    } while (0)

/* The box's part of a packet. */
static void pack_box(const BoxState *box, Packet *packet)
{
    packet->motion[MOTION_BOX] =
        (Motion){{box->pose.x, box->pose.y}, {box->velocity.x, box->velocity.y}};
    packet->motion[MOTION_BOX_ANGLE] = (Motion){{box->pose.theta, 0.0}, {box->velocity.theta, 0.0}};
}

#define WRITE_BOX(target, packet) \
    do { \
        (target).box_x = (packet).motion[MOTION_BOX].position.x; \
        (target).box_y = (packet).motion[MOTION_BOX].position.y; \
        (target).box_theta = (packet).motion[MOTION_BOX_ANGLE].position.x; \
        (target).box_vx = (packet).motion[MOTION_BOX].velocity.x; \
        (target).box_vy = (packet).motion[MOTION_BOX].velocity.y; \
        (target).box_omega = (packet).motion[MOTION_BOX_ANGLE].velocity.x; \
    } while (0)

#define WRITE_PEER_CONTACTS(target, forces, p) \
    do { \
        (target).finger_1_normal_force = (forces)->peer[p][0].along.normal; \
        (target).finger_2_normal_force = (forces)->peer[p][1].along.normal; \
        (target).finger_1_contact_state = (forces)->peer_contact[p][0].mode; \
        (target).finger_2_contact_state = (forces)->peer_contact[p][1].mode; \
        (target).finger_1_contact_losses = (forces)->peer_contact[p][0].losses; \
        (target).finger_2_contact_losses = (forces)->peer_contact[p][1].losses; \
        (target).finger_1_energy = (forces)->peer_port[p][0].energy; \
        (target).finger_2_energy = (forces)->peer_port[p][1].energy; \
        (target).coupling_energy = (forces)->coupling_port[p].energy; \
    } while (0)

static void environment_outputs(Variables *v, const Station *station, const StationState *own,
                                const World *world, const WorldState *state, const FingerMeasurement measured[FINGERS],
                                const WorldForces *forces)
{
    for (int f = 0; f < FINGERS; f++) {
        station_render(v, station, own, f, &measured[f], forces->own[f].force);
        v->finger[f].normal_force = forces->own[f].along.normal;
        v->finger[f].tangential_force = forces->own[f].along.tangential;
        v->finger[f].contact_state = forces->own_contact[f].mode;
        v->finger[f].contact_face = forces->own_contact[f].face;
        v->finger[f].contact_losses = forces->own_contact[f].losses;
    }
    WRITE_PLANAR(v->box_pose, state->box.pose);
    WRITE_PLANAR(v->box_velocity, state->box.velocity);
    WRITE_PLANAR(v->finger_wrench, forces->from_own);
    WRITE_PLANAR(v->coupling_wrench, forces->from_peers);
    WRITE_PLANAR(v->wall_wrench, forces->from_walls);
    v->wall_penetration = forces->wall_penetration;
    v->box_energy = box_energy(&world->box, &state->box);
    const LatticeState nodes =
        world->soft ? state->lattice : lattice_at(&world->lattice, state->box.pose);
    for (int i = 0; i < LATTICE_NODES; i++) {
        v->node_position[2 * i] = nodes.position[i].x;
        v->node_position[2 * i + 1] = nodes.position[i].y;
    }
}

static void environment_commit(const Variables *v, const Station *station, StationState *own,
                               const World *world, WorldState *state,
                               const FingerMeasurement measured[FINGERS], const WorldForces *forces)
{
    const Vector force[FINGERS] = {forces->own[0].force, forces->own[1].force};
    world_step(world, state, forces);
    station_commit(v, station, own, measured, force);
}

static int64_t contact_bit(const WorldForces *forces)
{
    for (int f = 0; f < FINGERS; f++)
        if (forces->own_contact[f].mode != CONTACT_FREE) return STATUS_CONTACT;
    return 0;
}

#endif
