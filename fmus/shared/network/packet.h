/* What a workstation tells others, and a perceptual deadband on it.
 *
 * With a deadband a network sample is a keep-alive, a head with the content's age, unless someone
 * could feel the change: the force that the receiver's coupler makes of it, K dp + B dv, against a
 * fraction of the force that is felt (Weber's law). A position is compared with what the receiver
 * makes of the last content. Hinterseer, Hirche, Chaudhuri, Steinbach,
 * Buss, "Perception-based data reduction and transmission of haptic data in telepresence and
 * teleaction systems", IEEE Trans. Signal Processing 56(2), 2008.
 */
#ifndef COHAPTIC_PACKET_H
#define COHAPTIC_PACKET_H

#include <stdbool.h>
#include <stdint.h>

#include "vector.h"

enum { MOTION_FINGER_1, MOTION_FINGER_2, MOTION_BOX, MOTION_BOX_ANGLE, MOTIONS };

typedef struct {
    Vector position, velocity; /* an angle and its rate take x alone */
} Motion;

typedef struct {
    Motion motion[MOTIONS];
    Vector force[2];
} Packet;

typedef struct {
    double fraction;           /* Weber's; 0: every sample is sent */
    double stiffness[MOTIONS]; /* of the receiver's coupler, N/m or N.m/rad; 0: for display */
    double damping[MOTIONS];   /* N.s/m or N.m.s/rad */
    double force, arm;         /* N below which nothing is felt; m at which a torque is */
    bool predicted;            /* whether receivers move positions on with their velocities */
    int64_t samples;              /* ticks between network samples */
    int64_t longest;              /* network samples until a repeat is sent anew */
    double period;                /* s */
} Deadband;

/* Committed: the content that was sent last. */
typedef struct {
    Packet packet;
    int64_t tick; /* of the content */
    int64_t due, sent;
} SentPacket;

/* The content at this tick, and the record as it will be committed; `felt` (N) is what Weber's
 * fraction is taken of. Pure. */
SentPacket packet_send(const Deadband *deadband, const SentPacket *before, const Packet *now,
                       double felt, int64_t tick);

#endif
