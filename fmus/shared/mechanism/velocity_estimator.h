/* Velocity from sampled, quantised positions of two axes.
 *
 * First-order adaptive windowing (FOAW), end-fit: the longest window whose end-to-end line passes
 * within one quantum of every sample inside it (Janabi-Sharifi, Hayward, Chen, "Discrete-time
 * adaptive windowing for velocity estimation", IEEE Trans. Control Systems Technology 8(6), 2000).
 * Finite difference: over the oldest sample in the window.
 *
 * Samples carry the tick at which they were measured, so that a late or missing one changes the
 * slope's denominator and not its value; what is older than the window is not used, so that the
 * estimate restarts after a long gap.
 */
#ifndef COHAPTIC_VELOCITY_ESTIMATOR_H
#define COHAPTIC_VELOCITY_ESTIMATOR_H

#include <stdint.h>

#define LONGEST_WINDOW 32

typedef struct {
    double value[LONGEST_WINDOW][2];
    int64_t tick[LONGEST_WINDOW];
    int64_t newest; /* index of the newest sample */
    int64_t count;
} SampleWindow;

/* The estimators look `window` ticks (1 .. LONGEST_WINDOW - 1) back from the sample (value, tick), which
 * need not be in the window yet; `period` is a tick in s. No usable sample gives zero velocity. */
void foaw_velocity(const SampleWindow *samples, const double value[2], int64_t tick, int64_t window,
                   double quantum, double period, double velocity[2]);
void finite_difference(const SampleWindow *samples, const double value[2], int64_t tick,
                       int64_t window, double period, double velocity[2]);

/* Take in a sample that is newer than all others. */
void sample_window_push(SampleWindow *samples, const double value[2], int64_t tick);

#endif
