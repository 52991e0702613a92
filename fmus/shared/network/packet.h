/* What a workstation tells others, and a perceptual deadband on it.
 *
 * With a deadband a network sample repeats the last content unless someone could feel the change:
 * a velocity or force that changes by more than a fraction of itself (Weber's law), or a position
 * that leaves what the receiver makes of the last content. Hinterseer, Hirche, Chaudhuri, Steinbach,
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
    double fraction;              /* Weber's; 0: every sample is sent */
    double position, angle;       /* m, rad that may be off */
    double velocity, rate, force; /* m/s, rad/s, N below which nothing is felt */
    bool predicted;               /* whether receivers move positions on with their velocities */
    bool forces_only;             /* where the motions are for display */
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

/* The content at this tick, and the record as it will be committed. Pure. */
SentPacket packet_send(const Deadband *deadband, const SentPacket *before, const Packet *now,
                       int64_t tick);

#endif
