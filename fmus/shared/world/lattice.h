/* A soft square: 3 x 3 point masses, springs and dampers along edges and diagonals.
 *
 * Nodes are numbered row by row from the lower left, column first. A spring pulls along its line,
 * k (length - rest) + b (rate of length), the usual mass-spring model (Provot, "Deformation constraints
 * in a mass-spring model to describe rigid cloth behaviour", Graphics Interface 1995).
 */
#ifndef COHAPTIC_LATTICE_H
#define COHAPTIC_LATTICE_H

#include "box.h"
#include "contact.h"
#include "vector.h"

enum { LATTICE_WIDTH = 3, LATTICE_NODES = 9, LATTICE_OUTLINE = 8 };

typedef struct {
    double spacing;
    double outer, middle;      /* masses of the nodes, kg */
    double stiffness, damping; /* of every spring, N/m, N.s/m */
    double ground_friction;    /* mu g, m/s2 */
} Lattice;

typedef struct {
    Vector position[LATTICE_NODES], velocity[LATTICE_NODES];
} LatticeState;

/* Where a point holds on to the lattice: between two nodes of its outline. */
typedef struct {
    int first, second;
    double share;  /* of the second node, 0 .. 1 */
    Vector normal; /* outward, world */
} LatticeGrip;

/* Masses that have the square's mass and inertia together: the outer nodes share the inertia, J = 12 m_o h^2
 * at spacing h, and the middle has the rest (1 : 10 for a uniform square). Equal ones are the heaviest that the
 * lightest of the outline can be, which a wall's damper asks for. False where nothing is left for the middle. */
bool lattice_weigh(Lattice *lattice, double mass, double inertia);

/* Whether its own vibration is bounded under semi-implicit Euler, `stiffness` and `damping` of something
 * outside on a node of the outline. */
bool lattice_is_stable(const Lattice *lattice, double stiffness, double damping, double period);

/* The undeformed lattice at rest at a pose. */
LatticeState lattice_at(const Lattice *lattice, Planar pose);

/* Mean pose and velocity: centre of mass, least-squares rotation, spin of the angular momentum. */
BoxState lattice_mean(const Lattice *lattice, const LatticeState *state);

/* How a point touches the outline; slip is measured along the undeformed side. */
Touch lattice_touch(const Lattice *lattice, const LatticeState *state, const Contact *contact,
                    Vector point, Vector velocity, LatticeGrip *grip);

/* Node i of the outline, 0 .. 7. */
int lattice_outline(int i);

/* Add a force that acts at a grip, or a wrench about the centre that deforms nothing, to the forces on
 * the nodes. */
void lattice_push(const LatticeGrip *grip, Vector force, Vector nodes[LATTICE_NODES]);
void lattice_spread(const Lattice *lattice, const LatticeState *state, Planar centre, Planar wrench,
                    Vector nodes[LATTICE_NODES]);

/* One tick of semi-implicit Euler under held outer forces, ground friction as an implicit impulse
 * on every node. */
void lattice_step(const Lattice *lattice, LatticeState *state, const Vector outer[LATTICE_NODES],
                  double period);

#endif
