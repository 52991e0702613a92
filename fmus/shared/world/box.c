#include "box.h"

#include "cohaptic_math.h"

Vector box_point_velocity(const BoxState *state, Vector point)
{
    const Vector arm = {point.x - state->pose.x, point.y - state->pose.y};
    return plus((Vector){state->velocity.x, state->velocity.y},
                times(state->velocity.theta, left_of(arm)));
}

Vector box_corner(const Box *box, const BoxState *state, Rotation rotation, int corner)
{
    const Vector arm = {corner == 0 || corner == 3 ? box->half_side : -box->half_side,
                        corner < 2 ? box->half_side : -box->half_side};
    return plus((Vector){state->pose.x, state->pose.y}, turn(rotation, arm));
}

Vector box_normal(int64_t face)
{
    switch (face) {
    case 1: return (Vector){1.0, 0.0};
    case 2: return (Vector){0.0, 1.0};
    case 3: return (Vector){-1.0, 0.0};
    default: return (Vector){0.0, -1.0};
    }
}

Touch box_touch(const Box *box, const BoxState *state, Rotation rotation, const Contact *contact,
                Vector point, Vector velocity)
{
    const Vector arm = turn_back(rotation, minus(point, (Vector){state->pose.x, state->pose.y}));
    const double across = box->half_side - fabs(arm.x), along = box->half_side - fabs(arm.y);
    Touch touch = {.touching = across > 0.0 && along > 0.0};
    if (!touch.touching) return touch;
    touch.face = contact->mode != CONTACT_FREE ? contact->face
                 : across < along              ? (arm.x > 0.0 ? 1 : 3)
                                               : (arm.y > 0.0 ? 2 : 4);
    const Vector normal = box_normal(touch.face), tangent = left_of(normal);
    const Vector relative = turn_back(rotation, minus(velocity, box_point_velocity(state, point)));
    touch.depth = box->half_side - dot(arm, normal);
    touch.slip = dot(arm, tangent);
    touch.normal_velocity = dot(relative, normal);
    touch.tangential_velocity = dot(relative, tangent);
    return touch;
}

BoxState box_step(const Box *box, const BoxState *state, Planar wrench, double period)
{
    const Planar before = state->velocity;
    BoxState next;
    next.velocity.x = before.x + period * (wrench.x / box->mass);
    next.velocity.y = before.y + period * (wrench.y / box->mass);
    next.velocity.theta = before.theta + period * (wrench.theta / box->inertia);
    const double speed = hypot(next.velocity.x, next.velocity.y);
    const double lost = period * box->linear_friction;
    const double kept = speed > lost ? 1.0 - lost / speed : 0.0;
    next.velocity.x *= kept;
    next.velocity.y *= kept;
    const double spin = fabs(next.velocity.theta), spin_lost = period * box->rotational_friction;
    next.velocity.theta *= spin > spin_lost ? 1.0 - spin_lost / spin : 0.0;
    /* A held force gives exactly the mean of both velocities; Euler's rules take one of them. */
    const double newer = box->integration == SEMI_IMPLICIT_EULER ? period
                         : box->integration == EXPLICIT_EULER    ? 0.0
                                                                 : 0.5 * period;
    const double older = period - newer;
    next.pose.x = state->pose.x + newer * next.velocity.x + older * before.x;
    next.pose.y = state->pose.y + newer * next.velocity.y + older * before.y;
    next.pose.theta = state->pose.theta + newer * next.velocity.theta + older * before.theta;
    return next;
}

double box_energy(const Box *box, const BoxState *state)
{
    const Planar v = state->velocity;
    return 0.5 * (box->mass * (v.x * v.x + v.y * v.y) + box->inertia * v.theta * v.theta);
}
