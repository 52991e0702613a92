/* Where a hand will be: two models of its intent, tried against every packet.
 *
 * A coordinate either rests, and drifts a little, or moves with an acceleration that decays,
 * a' = -a / tau; it changes between the two at random. Both models run as Kalman filters at packet
 * rate, mixed by how likely each is (interacting multiple models: Blom, Bar-Shalom, "The interacting
 * multiple model algorithm for systems with Markovian switching coefficients", IEEE Trans. Automatic
 * Control 33(8), 1988; decaying acceleration: Singer, "Estimating optimal tracking filter performance
 * for manned maneuvering targets", IEEE Trans. Aerospace and Electronic Systems 6(4), 1970).
 */
#ifndef COHAPTIC_INTENT_H
#define COHAPTIC_INTENT_H

#include <stdint.h>

#include "packet.h"

enum { INTENT_COORDINATES = 7 }; /* of two fingers and a box: x, y, x, y, x, y, angle */

typedef struct {
    double acceleration;   /* of a hand that moves, rms, m/s2 */
    double decay;          /* tau, s */
    double drift;          /* of a hand at rest, rms, m/s */
    double position_noise; /* of what a packet says, rms, m */
    double velocity_noise; /* m/s */
    double start_rate;     /* how often a hand at rest begins to move, 1/s */
    double stop_rate;      /* how often one that moves stops, 1/s */
    double arm;            /* at which an angle counts as metres, m */
} IntentTuning;

/* A normal distribution of position, velocity and acceleration; of its covariance the upper half. */
typedef struct {
    double mean[3];
    double covariance[6]; /* xx, xv, xa, vv, va, aa */
} Belief;

typedef struct {
    Belief rest, move;
    double moving; /* how likely it moves, 0 to 1 */
} CoordinateIntent;

/* Committed for each peer. */
typedef struct {
    CoordinateIntent coordinate[INTENT_COORDINATES];
    int64_t tick; /* the sender's, of the content that was heard last */
    int64_t heard;
} Intent;

/* Take in what a peer says, content of its tick `tick`: no news where that was heard already. */
void intent_hear(const IntentTuning *tuning, Intent *intent, Motion motion[MOTIONS], int64_t tick,
                 double period);

/* Move what a peer says, content of its tick `tick`, on by `ahead` seconds; `intent` is what was believed
 * before it said so. */
void intent_ahead(const IntentTuning *tuning, const Intent *intent, double ahead, int64_t tick,
                  double period, Motion motion[MOTIONS]);

#endif
