/* Wave variables between a hand and a distant coupler: Niemeyer, Slotine, "Stable adaptive
 * teleoperation", IEEE J. Oceanic Engineering 16(1), 1991; integrals of waves as in Niemeyer, Slotine,
 * "Telemanipulation with time delays", Int. J. Robotics Research 23(9), 2004.
 *
 * In newtons: alpha = b v + F goes out, beta = b v - F comes back, and (alpha^2 - beta^2) / 4b is the
 * power v F. What travels is the integral of a wave (N.s), so that nothing is lost with a packet. A
 * receiver plays the mean of what it has not yet consumed for as long as the sender took to send it,
 * and then the wave zero. A mean holds no more energy than what it is the mean of; so the channel
 * stays passive whatever is late, held or lost, and at worst the delay grows to the longest gap. A peer
 * that was given up is heard anew: what it sent meanwhile, or before it was restarted, is not made up for.
 */
#ifndef COHAPTIC_WAVE_H
#define COHAPTIC_WAVE_H

#include <stdbool.h>
#include <stdint.h>

#include "vector.h"

/* Committed by a receiver for each wave. */
typedef struct {
    Vector consumed;       /* of the received integral, N.s */
    Vector wave;           /* played now, N */
    int64_t consumed_tick; /* the sender's tick up to which all is consumed */
    int64_t source_tick;   /* of the last packet */
    int64_t heard;
} WavePort;

/* The port at this tick, given what the packet says now and whether its sender counts; what the first
 * packet has is taken as consumed. Pure. */
WavePort wave_receive(const WavePort *before, const double integral[2], int64_t source_tick,
                      bool counts, double period);

/* The port after this tick. */
WavePort wave_consume(const WavePort *port, double period);

#endif
