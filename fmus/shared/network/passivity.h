/* Time-domain passivity of a rendered force: Hannaford, Ryu, "Time-domain passivity control of haptic
 * interfaces", IEEE Trans. Robotics and Automation 18(1), 2002, impedance causality.
 *
 * The observer sums the energy that the user has put into the virtual world, E = -sum T F . v; the
 * controller adds just the damping that keeps E from falling below zero.
 */
#ifndef COHAPTIC_PASSIVITY_H
#define COHAPTIC_PASSIVITY_H

#include <stdbool.h>

#include "vector.h"

typedef struct {
    bool controlled;      /* whether the controller acts; the observer always counts */
    double damping_limit; /* of the controller, N.s/m */
    double reserve;       /* the most energy that is kept to be given back, J; 0: no limit */
    double max_force;     /* of the device, N */
    double period;        /* s */
} Passivity;

/* A force (N, world) no larger than a maximum, its direction kept. */
Vector limited_force(Vector force, double max_force);

/* The force to render at a velocity, given the energy so far, and the energy after this tick. Pure. */
Vector passive_force(const Passivity *passivity, double energy, Vector force, Vector velocity,
                     double *energy_after);

#endif
