/* A square box in the plane: where a point touches it, and how it moves. */
#ifndef COHAPTIC_BOX_H
#define COHAPTIC_BOX_H

#include "contact.h"
#include "vector.h"

enum { SEMI_IMPLICIT_EULER, EXPLICIT_EULER, ZERO_ORDER_HOLD };

typedef struct {
    double half_side, mass, inertia;
    double linear_friction;     /* mu g of the ground, m/s2 */
    double rotational_friction; /* friction torque over inertia, rad/s2 */
    int64_t integration;
} Box;

typedef struct {
    Planar pose, velocity;
} BoxState;

/* Velocity of the box's material at a point of the world. */
Vector box_point_velocity(const BoxState *state, Vector point);

/* Corner 0 .. 3 of the box in the world. */
Vector box_corner(const Box *box, const BoxState *state, Rotation rotation, int corner);

/* Outward normal of face 1 .. 4 (+x, +y, -x, -y) in the box's frame. */
Vector box_normal(int64_t face);

/* How a point with a velocity touches the box. A contact keeps the face that it entered by; a new
 * one takes the face with the least depth. */
Touch box_touch(const Box *box, const BoxState *state, Rotation rotation, const Contact *contact,
                Vector point, Vector velocity);

/* One tick under a held wrench: Euler's rule for the velocity, ground friction as an implicit
 * impulse (v <- v max(0, 1 - mu g T / |v|): no chatter, no energy), then the pose by the chosen rule. */
BoxState box_step(const Box *box, const BoxState *state, Planar wrench, double period);

double box_energy(const Box *box, const BoxState *state);

#endif
