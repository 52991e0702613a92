#include "velocity_estimator.h"

#include "cohaptic_math.h"

/* Index of the sample `back` places before the newest; the ring's length is a power of two. */
static uint64_t place(const SampleWindow *samples, int64_t back)
{
    return (uint64_t)(samples->newest - back) & (LONGEST_WINDOW - 1);
}

/* 1 / age for the ages that a window can have: a division for each sample would cost most of it. */
static const double SHARE[LONGEST_WINDOW] = {
    0.0,      1.0,      1.0 / 2,  1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,  1.0 / 7,
    1.0 / 8,  1.0 / 9,  1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13, 1.0 / 14, 1.0 / 15,
    1.0 / 16, 1.0 / 17, 1.0 / 18, 1.0 / 19, 1.0 / 20, 1.0 / 21, 1.0 / 22, 1.0 / 23,
    1.0 / 24, 1.0 / 25, 1.0 / 26, 1.0 / 27, 1.0 / 28, 1.0 / 29, 1.0 / 30, 1.0 / 31,
};

/* The slope per tick. */
static double foaw_axis(const SampleWindow *samples, int axis, double value, int64_t tick,
                        int64_t window, double quantum)
{
    /* The slopes that stay within a quantum of every sample so far form an interval. Counts often lie
     * on its very ends, which rounding must not decide. */
    const double band = quantum * (1.0 + 1e-6);
    double slope = 0.0, lowest = -INFINITY, highest = INFINITY;
    for (int64_t back = 0; back < samples->count; back++) {
        const uint64_t i = place(samples, back);
        const int64_t age = tick - samples->tick[i];
        if (age <= 0) continue;
        if (age > window) break;
        const double candidate = (value - samples->value[i][axis]) * SHARE[age];
        if (candidate < lowest || candidate > highest) break;
        slope = candidate;
        const double low = candidate - band * SHARE[age], high = candidate + band * SHARE[age];
        lowest = low > lowest ? low : lowest;
        highest = high < highest ? high : highest;
    }
    return slope;
}

void foaw_velocity(const SampleWindow *samples, const double value[2], int64_t tick, int64_t window,
                   double quantum, double period, double velocity[2])
{
    for (int axis = 0; axis < 2; axis++)
        velocity[axis] = foaw_axis(samples, axis, value[axis], tick, window, quantum) / period;
}

void finite_difference(const SampleWindow *samples, const double value[2], int64_t tick,
                       int64_t window, double period, double velocity[2])
{
    velocity[0] = velocity[1] = 0.0;
    for (int64_t back = samples->count - 1; back >= 0; back--) {
        const uint64_t i = place(samples, back);
        const int64_t age = tick - samples->tick[i];
        if (age <= 0 || age > window) continue;
        for (int axis = 0; axis < 2; axis++)
            velocity[axis] = (value[axis] - samples->value[i][axis]) / ((double)age * period);
        return;
    }
}

void sample_window_push(SampleWindow *samples, const double value[2], int64_t tick)
{
    samples->newest = (samples->newest + 1) % LONGEST_WINDOW;
    samples->value[samples->newest][0] = value[0];
    samples->value[samples->newest][1] = value[1];
    samples->tick[samples->newest] = tick;
    if (samples->count < LONGEST_WINDOW) samples->count++;
}
