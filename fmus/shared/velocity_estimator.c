#include "velocity_estimator.h"

#include "cohaptic_math.h"

/* Index of the sample `back` places before the newest. */
static int64_t place(const SampleWindow *samples, int64_t back)
{
    return (samples->newest - back + LONGEST_WINDOW) % LONGEST_WINDOW;
}

static double foaw_axis(const SampleWindow *samples, int axis, double value, int64_t tick,
                        int64_t window, double quantum, double period)
{
    /* The slopes that stay within a quantum of every sample so far form an interval. Counts often lie
     * on its very ends, which rounding must not decide. */
    const double band = quantum * (1.0 + 1e-6);
    double slope = 0.0, lowest = -INFINITY, highest = INFINITY;
    for (int64_t back = 0; back < samples->count; back++) {
        const int64_t i = place(samples, back), age = tick - samples->tick[i];
        if (age <= 0) continue;
        if (age > window) break;
        const double inverse = 1.0 / ((double)age * period);
        const double candidate = (value - samples->value[i][axis]) * inverse;
        if (candidate < lowest || candidate > highest) break;
        slope = candidate;
        lowest = fmax(lowest, candidate - band * inverse);
        highest = fmin(highest, candidate + band * inverse);
    }
    return slope;
}

void foaw_velocity(const SampleWindow *samples, const double value[2], int64_t tick, int64_t window,
                   double quantum, double period, double velocity[2])
{
    for (int axis = 0; axis < 2; axis++)
        velocity[axis] = foaw_axis(samples, axis, value[axis], tick, window, quantum, period);
}

void finite_difference(const SampleWindow *samples, const double value[2], int64_t tick,
                       int64_t window, double period, double velocity[2])
{
    velocity[0] = velocity[1] = 0.0;
    for (int64_t back = samples->count - 1; back >= 0; back--) {
        const int64_t i = place(samples, back), age = tick - samples->tick[i];
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
