/* The energy that goes through a port of the virtual world: something outside moves, and an effort
 * answers that is held until the next tick.
 *
 * Into the world, E_k = E_{k-1} - F_{k-1} . (x_k - x_{k-1}): the effort that was held while the place
 * changed, so that it is exact (Ryu, Kim, Hannaford, "Stable haptic interaction with virtual environments",
 * 2004; Stramigioli, Secchi, van der Schaft, Fantuzzi, "Sampled data systems passivity and discrete
 * port-Hamiltonian systems", IEEE Trans. Robotics 21(4), 2005).
 */
#ifndef COHAPTIC_PORT_H
#define COHAPTIC_PORT_H

#include <stdbool.h>
#include <stdint.h>

#include "vector.h"

/* Committed from tick to tick. */
typedef struct {
    Planar effort; /* on what is outside, held since the last tick: N, N, N.m */
    Planar place;  /* of what is outside, then: m, m, rad */
    double energy; /* that has gone in, J */
    int64_t open;  /* whether effort and place are those of the last tick */
} Port;

/* E_k with what is outside at `place`. */
double port_energy(const Port *port, Planar place);

/* The port after a tick in which `effort` begins to be held; no more than `reserve` J is kept (0: no
 * limit), and `open` says whether anything is there. */
Port port_next(const Port *port, Planar place, Planar effort, bool open, double reserve);

static inline Planar planar_of(Vector v) { return (Planar){v.x, v.y, 0.0}; }

#endif
