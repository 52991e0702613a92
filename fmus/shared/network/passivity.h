/* Time-domain passivity of a rendered force: Hannaford, Ryu, "Time-domain passivity control of haptic
 * interfaces", IEEE Trans. Robotics and Automation 18(1), 2002, impedance causality, with the observer
 * of port.h and one step of prediction (Ryu, Kim, Hannaford, 2004).
 *
 * The controller looks one tick ahead: would the force, held while the finger goes on as it does, take
 * out more than has gone in, it adds just the damping that prevents it.
 */
#ifndef COHAPTIC_PASSIVITY_H
#define COHAPTIC_PASSIVITY_H

#include <stdbool.h>

#include "vector.h"

typedef struct {
    bool controlled;      /* whether the controller acts; the observer always counts */
    double damping_limit; /* of the controller, N.s/m: below 0.34 m/T it does not overshoot */
    double reserve;       /* the most energy that is kept to be given back, J; 0: no limit */
    double max_force;     /* of the device, N */
    double period;        /* s */
} Passivity;

/* A force (N, world) no larger than a maximum, its direction kept. */
Vector limited_force(Vector force, double max_force);

/* The force to render, given the energy so far and how far the finger moved in the last tick. Pure. */
Vector passive_force(const Passivity *passivity, double energy, Vector force, Vector moved);

#endif
