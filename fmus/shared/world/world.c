#include "world.h"

#include "cohaptic_math.h"

static const Cancellation NO_CANCELLATION = {0.0, 0.0, 0.0};

static bool is_finite(Vector v) { return isfinite(v.x) && isfinite(v.y); }

void world_place(const World *world, WorldState *state, Planar pose)
{
    state->box = (BoxState){.pose = pose};
    if (world->soft) state->lattice = lattice_at(&world->lattice, pose);
}

/* One finger on the object: its next contact, the force on it, and the wrench of its reaction. */
static Contact finger_contact(const World *world, const WorldState *state, Rotation rotation,
                              const Surface *surface, const Cancellation *cancellation,
                              const Contact *before, const FingerInput *finger, double weight,
                              double limit, WorldForces *forces, FingerForce *force, Planar *wrench)
{
    *force = (FingerForce){0};
    Touch touch = {.touching = false};
    LatticeGrip grip = {0};
    if (finger->present && is_finite(finger->position) && is_finite(finger->velocity))
        touch = world->soft ? lattice_touch(&world->lattice, &state->lattice, before,
                                            finger->position, finger->velocity, &grip)
                            : box_touch(&world->box, &state->box, rotation, before,
                                        finger->position, finger->velocity);
    const Contact next = contact_next(before, surface, &touch, cancellation, &force->along);
    if (!touch.touching) return next;
    force->along.normal *= weight;
    force->along.tangential *= weight;
    const double size = hypot(force->along.normal, force->along.tangential);
    if (limit > 0.0 && size > limit) {
        force->along.normal *= limit / size;
        force->along.tangential *= limit / size;
    }
    const Vector normal = world->soft ? grip.normal : turn(rotation, box_normal(touch.face));
    force->force = plus(times(force->along.normal, normal),
                        times(force->along.tangential, left_of(normal)));
    const Vector reaction = times(-1.0, force->force);
    if (world->soft) lattice_push(&grip, reaction, forces->node);
    *wrench = planar_sum(*wrench, wrench_at(reaction, finger->position,
                                            (Vector){state->box.pose.x, state->box.pose.y}));
    return next;
}

/* A point of the object that may meet a wall. */
typedef struct {
    Vector position, velocity;
    int node;
} WallPoint;

static WallPoint wall_point(const World *world, const WorldState *state, Rotation rotation, int i)
{
    if (world->soft) {
        const int node = lattice_outline(i);
        return (WallPoint){state->lattice.position[node], state->lattice.velocity[node], node};
    }
    const Vector corner = box_corner(&world->box, &state->box, rotation, i);
    return (WallPoint){corner, box_point_velocity(&state->box, corner), 0};
}

static int wall_points(const World *world) { return world->soft ? LATTICE_OUTLINE : CORNERS; }

/* The next contact of a point with a wall, and the force on the point (world). */
static Contact wall_contact(const Wall *wall, const Contact *before, const WallPoint *point,
                            double *depth, Vector *force)
{
    const Vector tangent = left_of(wall->normal);
    const Vector arm = minus(point->position, wall->point);
    *depth = -dot(arm, wall->normal);
    const Touch touch = {*depth > 0.0, 1, *depth, dot(arm, tangent),
                         dot(point->velocity, wall->normal), dot(point->velocity, tangent)};
    ContactForce along;
    const Contact next = contact_next(before, &wall->surface, &touch, &NO_CANCELLATION, &along);
    *force = plus(times(along.normal, wall->normal), times(along.tangential, tangent));
    return next;
}

static void wall_forces(const World *world, const WorldState *state, Rotation rotation,
                        WorldForces *forces)
{
    const Vector centre = {state->box.pose.x, state->box.pose.y};
    for (int w = 0; w < WALLS; w++)
        for (int i = 0; world->wall[w].enabled && i < wall_points(world); i++) {
            const WallPoint point = wall_point(world, state, rotation, i);
            double depth;
            Vector force;
            wall_contact(&world->wall[w], &state->wall[w][i], &point, &depth, &force);
            if (!(depth > 0.0)) continue;
            if (world->soft) forces->node[point.node] = plus(forces->node[point.node], force);
            forces->from_walls =
                planar_sum(forces->from_walls, wrench_at(force, point.position, centre));
            forces->wall_penetration = fmax(forces->wall_penetration, depth);
        }
}

static void commit_walls(const World *world, WorldState *state)
{
    bool any = false;
    for (int w = 0; w < WALLS; w++) any = any || world->wall[w].enabled;
    if (!any) return;
    const Rotation rotation = {cos(state->box.pose.theta), sin(state->box.pose.theta)};
    for (int w = 0; w < WALLS; w++)
        for (int i = 0; world->wall[w].enabled && i < wall_points(world); i++) {
            const WallPoint point = wall_point(world, state, rotation, i);
            double depth;
            Vector force;
            state->wall[w][i] =
                wall_contact(&world->wall[w], &state->wall[w][i], &point, &depth, &force);
        }
}

static double clamp(double value, double limit) { return fmax(-limit, fmin(limit, value)); }

/* The shorter way round; exact, and the difference itself, below half a turn. */
static double angle_between(double from, double to)
{
    const double difference = to - from;
    return difference - 2.0 * M_PI * floor(difference / (2.0 * M_PI) + 0.5);
}

/* Pull towards a peer's copy of the box. */
static Planar coupling_wrench(const Coupling *k, const BoxState *own, const BoxState *peer)
{
    Planar pull = {
        k->stiffness * (peer->pose.x - own->pose.x) + k->damping * (peer->velocity.x - own->velocity.x),
        k->stiffness * (peer->pose.y - own->pose.y) + k->damping * (peer->velocity.y - own->velocity.y),
        k->rotational_stiffness * angle_between(own->pose.theta, peer->pose.theta)
            + k->rotational_damping * (peer->velocity.theta - own->velocity.theta)};
    const double size = hypot(pull.x, pull.y);
    if (k->force_limit > 0.0 && size > k->force_limit) {
        pull.x *= k->force_limit / size;
        pull.y *= k->force_limit / size;
    }
    if (k->torque_limit > 0.0) pull.theta = clamp(pull.theta, k->torque_limit);
    return pull;
}

static bool state_is_finite(const BoxState *box)
{
    return isfinite(box->pose.x) && isfinite(box->pose.y) && isfinite(box->pose.theta)
           && isfinite(box->velocity.x) && isfinite(box->velocity.y)
           && isfinite(box->velocity.theta);
}

static void peers(const World *world, const WorldState *state, const WorldInput *input,
                  Rotation rotation, WorldForces *forces)
{
    for (int p = 0; p < PEERS; p++) {
        const PeerInput *peer = &input->peer[p];
        for (int f = 0; f < PEER_FINGERS; f++)
            forces->peer_contact[p][f] = finger_contact(
                world, state, rotation, &world->peer_surface, &NO_CANCELLATION, &state->peer[p][f],
                &peer->finger[f], peer->weight, 0.0, forces, &forces->peer[p][f],
                &forces->from_peers);
        for (int f = 0; f < PEER_FINGERS; f++)
            forces->peer_port[p][f] = port_next(
                &state->peer_port[p][f], planar_of(peer->finger[f].position),
                planar_of(forces->peer[p][f].force), peer->finger[f].present, 0.0);
        forces->coupling_port[p] =
            port_next(&state->coupling_port[p], peer->box.pose, (Planar){0}, false, 0.0);
        if (!(peer->coupled && peer->weight > 0.0 && state_is_finite(&peer->box))) continue;
        const Planar pull = coupling_wrench(&world->coupling, &state->box, &peer->box);
        const Planar felt = {peer->weight * pull.x, peer->weight * pull.y,
                             peer->weight * pull.theta};
        if (world->soft) lattice_spread(&world->lattice, &state->lattice, state->box.pose, felt, forces->node);
        forces->from_peers = planar_sum(forces->from_peers, felt);
        const Planar reaction = {-felt.x, -felt.y, -felt.theta};
        forces->coupling_port[p] =
            port_next(&state->coupling_port[p], peer->box.pose, reaction, true, 0.0);
    }
}

void world_forces(const World *world, const WorldState *state, const WorldInput *input,
                  WorldForces *forces)
{
    *forces = (WorldForces){0};
    const BoxState *box = &state->box;
    const Rotation rotation = {cos(box->pose.theta), sin(box->pose.theta)};
    for (int f = 0; f < OWN_FINGERS; f++)
        forces->own_contact[f] = finger_contact(
            world, state, rotation, &world->own_surface, &world->cancellation[f], &state->own[f],
            &input->own[f], 1.0, world->own_limit[f], forces, &forces->own[f], &forces->from_own);
    peers(world, state, input, rotation, forces);
    wall_forces(world, state, rotation, forces);
    const Planar compensation = {-world->compensation.x * box->velocity.x,
                                 -world->compensation.y * box->velocity.y,
                                 -world->compensation.theta * box->velocity.theta};
    if (world->soft) lattice_spread(&world->lattice, &state->lattice, box->pose, compensation, forces->node);
    forces->total = planar_sum(planar_sum(forces->from_own, forces->from_peers),
                               planar_sum(forces->from_walls, compensation));
}

void world_step(const World *world, WorldState *state, const WorldForces *forces)
{
    for (int f = 0; f < OWN_FINGERS; f++) state->own[f] = forces->own_contact[f];
    for (int p = 0; p < PEERS; p++)
        for (int f = 0; f < PEER_FINGERS; f++) {
            state->peer[p][f] = forces->peer_contact[p][f];
            state->peer_port[p][f] = forces->peer_port[p][f];
        }
    for (int p = 0; p < PEERS; p++) state->coupling_port[p] = forces->coupling_port[p];
    commit_walls(world, state);
    if (!world->soft) {
        state->box = box_step(&world->box, &state->box, forces->total, world->period);
        return;
    }
    lattice_step(&world->lattice, &state->lattice, forces->node, world->period);
    const BoxState mean = lattice_mean(&world->lattice, &state->lattice);
    const double turned = angle_between(state->box.pose.theta, mean.pose.theta);
    const double theta = state->box.pose.theta + turned;
    state->box = mean;
    state->box.pose.theta = theta;
}
