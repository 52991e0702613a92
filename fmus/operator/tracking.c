#include "tracking.h"

#include "cohaptic_math.h"

static const double USUAL_INTERVAL = 1.0 / 60.0, LONGEST_INTERVAL = 0.1; /* s */
static const double INTERVALS_AHEAD = 1.5;
static const double GRIP_TIME = 0.25; /* in which a hand takes hold and lets go, s */

static void clamp_speed(double velocity[2], double limit)
{
    const double speed = hypot(velocity[0], velocity[1]);
    if (speed > limit)
        for (int axis = 0; axis < 2; ++axis)
            velocity[axis] *= limit / speed;
}

static void take_sample(Tracking *k, const Target *target, double limit, double t, bool follows)
{
    const double time = t - target->age, since = time - k->sample_time;
    const bool together = follows && since > 0.0 && since <= LONGEST_INTERVAL;
    for (int axis = 0; axis < 2; ++axis) {
        const double moved = target->position[axis] - k->sample[axis];
        k->sample_velocity[axis] = together ? moved / since : 0.0;
        k->sample[axis] = target->position[axis];
    }
    clamp_speed(k->sample_velocity, limit);
    k->interval = together ? since : USUAL_INTERVAL;
    k->sample_time = time;
    k->count = target->count;
}

static void arrive(Tracking *k, const double finger[2])
{
    for (int axis = 0; axis < 2; ++axis) {
        k->position[axis] = finger[axis];
        k->velocity[axis] = 0.0;
    }
}

bool tracking_step(Tracking *k, const Target *target, const TrackingLimits *limits,
                   const double finger[2], double t, double h)
{
    if (target->valid) {
        const bool follows = k->presence == TRACKING_HELD;
        if (!follows)
            arrive(k, finger);
        if (!follows || target->count != k->count)
            take_sample(k, target, limits->speed, t, follows);
        k->presence = TRACKING_HELD;
        k->silence = 0.0;
    } else if (k->presence == TRACKING_NOBODY) {
        return false;
    } else {
        k->silence += h;
        if (k->silence > limits->hold)
            k->presence = TRACKING_RELEASED;
    }
    const double grip = h / GRIP_TIME;
    k->weight = k->presence == TRACKING_HELD ? fmin(k->weight + grip, 1.0)
                                             : fmax(k->weight - grip, 0.0);
    const double since = t + h - k->sample_time, most = INTERVALS_AHEAD * k->interval;
    const bool moves = target->valid && since <= most;
    const double w = limits->frequency, ahead = target->valid ? fmin(since, most) : most;
    for (int axis = 0; axis < 2; ++axis) {
        const double rate = moves ? k->sample_velocity[axis] : 0.0;
        const double goal = k->sample[axis] + k->sample_velocity[axis] * ahead;
        k->velocity[axis] += h * w * (w * (goal - k->position[axis]) + 2.0 * (rate - k->velocity[axis]));
    }
    clamp_speed(k->velocity, limits->speed);
    for (int axis = 0; axis < 2; ++axis)
        k->position[axis] += h * k->velocity[axis];
    return true;
}
