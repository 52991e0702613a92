#include "world.h"

#include "cohaptic_math.h"

static const Cancellation NO_CANCELLATION = {0.0, 0.0, 0.0};

static bool is_finite(Vector v) { return isfinite(v.x) && isfinite(v.y); }

/* One finger on the box: its next contact, the force on it, and the wrench of its reaction. */
static Contact finger_contact(const World *world, const BoxState *box, Rotation rotation,
                              const Surface *surface, const Cancellation *cancellation,
                              const Contact *before, const FingerInput *finger, double weight,
                              FingerForce *force, Planar *wrench)
{
    *force = (FingerForce){0};
    Touch touch = {.touching = false};
    if (finger->present && is_finite(finger->position) && is_finite(finger->velocity))
        touch = box_touch(&world->box, box, rotation, before, finger->position, finger->velocity);
    const Contact next = contact_next(before, surface, &touch, cancellation, &force->along);
    if (!touch.touching) return next;
    force->along.normal *= weight;
    force->along.tangential *= weight;
    const Vector normal = box_normal(touch.face);
    force->force = turn(rotation, plus(times(force->along.normal, normal),
                                       times(force->along.tangential, left_of(normal))));
    *wrench = planar_sum(*wrench, wrench_at(times(-1.0, force->force), finger->position,
                                            (Vector){box->pose.x, box->pose.y}));
    return next;
}

static void walls(const World *world, const WorldState *state, Rotation rotation,
                  WorldForces *forces)
{
    const Vector centre = {state->box.pose.x, state->box.pose.y};
    for (int w = 0; w < WALLS; w++) {
        const Wall *wall = &world->wall[w];
        for (int c = 0; c < CORNERS; c++) forces->wall_contact[w][c] = state->wall[w][c];
        if (!wall->enabled) continue;
        const Vector tangent = left_of(wall->normal);
        for (int c = 0; c < CORNERS; c++) {
            const Vector corner = box_corner(&world->box, &state->box, rotation, c);
            const Vector velocity = box_point_velocity(&state->box, corner);
            const Vector arm = minus(corner, wall->point);
            const double depth = -dot(arm, wall->normal);
            const Touch touch = {depth > 0.0, 1, depth, dot(arm, tangent),
                                 dot(velocity, wall->normal), dot(velocity, tangent)};
            ContactForce along;
            forces->wall_contact[w][c] = contact_next(&state->wall[w][c], &wall->surface, &touch,
                                                      &NO_CANCELLATION, &along);
            if (!touch.touching) continue;
            const Vector force = plus(times(along.normal, wall->normal), times(along.tangential, tangent));
            forces->from_walls = planar_sum(forces->from_walls, wrench_at(force, corner, centre));
            forces->wall_penetration = fmax(forces->wall_penetration, depth);
        }
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
                world, &state->box, rotation, &world->peer_surface, &NO_CANCELLATION,
                &state->peer[p][f], &peer->finger[f], peer->weight, &forces->peer[p][f],
                &forces->from_peers);
        if (!(peer->coupled && peer->weight > 0.0 && state_is_finite(&peer->box))) continue;
        const Planar pull = coupling_wrench(&world->coupling, &state->box, &peer->box);
        forces->from_peers =
            planar_sum(forces->from_peers, (Planar){peer->weight * pull.x, peer->weight * pull.y,
                                                    peer->weight * pull.theta});
    }
}

void world_forces(const World *world, const WorldState *state, const WorldInput *input,
                  WorldForces *forces)
{
    *forces = (WorldForces){0};
    const BoxState *box = &state->box;
    const Rotation rotation = {cos(box->pose.theta), sin(box->pose.theta)};
    for (int f = 0; f < OWN_FINGERS; f++)
        forces->own_contact[f] = finger_contact(world, box, rotation, &world->own_surface,
                                                &world->cancellation[f], &state->own[f],
                                                &input->own[f], 1.0, &forces->own[f],
                                                &forces->from_own);
    peers(world, state, input, rotation, forces);
    walls(world, state, rotation, forces);
    const Planar compensation = {-world->compensation.x * box->velocity.x,
                                 -world->compensation.y * box->velocity.y,
                                 -world->compensation.theta * box->velocity.theta};
    forces->total = planar_sum(planar_sum(forces->from_own, forces->from_peers),
                               planar_sum(forces->from_walls, compensation));
}

void world_step(const World *world, WorldState *state, const WorldForces *forces)
{
    for (int f = 0; f < OWN_FINGERS; f++) state->own[f] = forces->own_contact[f];
    for (int p = 0; p < PEERS; p++)
        for (int f = 0; f < PEER_FINGERS; f++) state->peer[p][f] = forces->peer_contact[p][f];
    for (int w = 0; w < WALLS; w++)
        for (int c = 0; c < CORNERS; c++) state->wall[w][c] = forces->wall_contact[w][c];
    state->box = box_step(&world->box, &state->box, forces->total, world->period);
}
