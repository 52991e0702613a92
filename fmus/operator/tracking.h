/* A reference that follows samples of a person's hand without steps.
 *
 * Samples come some sixty times a second and not evenly. Position and velocity of the newest are
 * moved on for at most one and a half intervals, and a critically damped second-order filter
 * follows both: the lag of a steady motion is gone, and the force has no steps. Who says nothing any
 * more is held where they were for a while, and then lets go.
 */
#ifndef COHAPTIC_OPERATOR_TRACKING_H
#define COHAPTIC_OPERATOR_TRACKING_H

#include <stdbool.h>
#include <stdint.h>

enum { TRACKING_NOBODY, TRACKING_HELD, TRACKING_RELEASED };

typedef struct {
    bool valid;
    int64_t count;      /* another number is another sample */
    double age;         /* of the sample, s */
    double position[2]; /* m */
} Target;

typedef struct {
    double frequency; /* rad/s */
    double speed;     /* largest, m/s */
    double hold;      /* s */
} TrackingLimits;

typedef struct {
    double position[2], velocity[2];               /* of the reference, m and m/s */
    double weight;                                 /* of the hand, 1 while it holds on */
    double sample[2], sample_velocity[2];          /* of the newest sample */
    double sample_time, interval, silence;         /* s */
    int64_t count, presence;
} Tracking;

/* The reference at t + h, `finger` being where the finger is; false while nobody was ever there. */
bool tracking_step(Tracking *k, const Target *target, const TrackingLimits *limits,
                   const double finger[2], double t, double h);

#endif
