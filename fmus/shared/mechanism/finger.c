#include "finger.h"

#include "cohaptic_math.h"

/* Nearer to a singular position than this, forces and torques have little to do with each other. */
#define CONDITION_LIMIT 100.0

bool status_is_active(int64_t status)
{
    const int64_t wanted = STATUS_HOMED | STATUS_ACTIVE;
    return (status & (wanted | STATUS_FAULT)) == wanted;
}

FingerMeasurement finger_measure(const Finger *finger, const FingerState *state,
                                 const double joint_angle[2], int64_t status, int64_t sample_age,
                                 int64_t tick)
{
    FingerMeasurement measured = {.position = state->position};
    FiveBarPose pose;
    if (!finger->used) return measured;
    five_bar_pose(&finger->bar, joint_angle, &pose);
    if (!(pose.valid && five_bar_is_regular(pose.jacobian, CONDITION_LIMIT))) return measured;
    measured.readable = true;
    measured.present = status_is_active(status);
    measured.position = to_world(&finger->place, pose.tip);
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2; j++) measured.jacobian[i][j] = pose.jacobian[i][j];
    const double seen[2] = {finger->adaptive ? joint_angle[0] : pose.tip.x,
                            finger->adaptive ? joint_angle[1] : pose.tip.y};
    const SampleWindow *samples = &state->samples;
    const double *newest = seen;
    int64_t newest_tick = tick;
    measured.sample[0] = seen[0];
    measured.sample[1] = seen[1];
    if (sample_age > 0) { /* nothing new: the estimate of the newest sample in the window */
        if (samples->count == 0) return measured;
        newest = samples->value[samples->newest];
        newest_tick = samples->tick[samples->newest];
    }
    double rate[2];
    if (!finger->adaptive) {
        finite_difference(samples, newest, newest_tick, finger->window, finger->period, rate);
        measured.velocity = turn(finger->place.rotation, (Vector){rate[0], rate[1]});
        return measured;
    }
    foaw_velocity(samples, newest, newest_tick, finger->window, finger->quantum, finger->period, rate);
    measured.velocity =
        turn(finger->place.rotation,
             (Vector){pose.jacobian[0][0] * rate[0] + pose.jacobian[0][1] * rate[1],
                      pose.jacobian[1][0] * rate[0] + pose.jacobian[1][1] * rate[1]});
    return measured;
}

double finger_energy(const Finger *finger, const FingerState *state,
                     const FingerMeasurement *measured)
{
    double energy = finger->reports_work ? state->port.energy - (measured->work - state->work)
                                         : port_energy(&state->port, planar_of(measured->position));
    if (finger->passivity.reserve > 0.0) energy = fmin(energy, finger->passivity.reserve);
    return energy;
}

Vector finger_rendered_force(const Finger *finger, const FingerState *state,
                             const FingerMeasurement *measured, Vector force)
{
    if (!measured->present) return (Vector){0.0, 0.0};
    const Vector before = {state->port.place.x, state->port.place.y};
    const Vector moved = state->port.open ? minus(measured->position, before) : (Vector){0.0, 0.0};
    return passive_force(&finger->passivity, finger_energy(finger, state, measured), force, moved);
}

bool finger_saturates(const Finger *finger, const FingerMeasurement *measured, Vector force)
{
    return measured->present && hypot(force.x, force.y) > finger->passivity.max_force;
}

void finger_commit(const Finger *finger, FingerState *state, const FingerMeasurement *measured,
                   Vector force, int64_t sample_age, int64_t tick)
{
    const Vector rendered = finger_rendered_force(finger, state, measured, force);
    const double energy = finger_energy(finger, state, measured);
    state->port = port_next(&state->port, planar_of(measured->position), planar_of(rendered),
                            measured->readable, 0.0);
    state->port.energy = energy;
    state->work = measured->work;
    state->saturated += finger_saturates(finger, measured, force);
    state->position = measured->position;
    if (measured->readable && sample_age <= 0)
        sample_window_push(&state->samples, measured->sample, tick);
}

void finger_torque(const Finger *finger, const FingerMeasurement *measured, Vector force,
                   double torque[2])
{
    const Vector local = turn_back(finger->place.rotation, force);
    for (int i = 0; i < 2; i++)
        torque[i] = measured->present ? measured->jacobian[0][i] * local.x
                                            + measured->jacobian[1][i] * local.y
                                      : 0.0;
}
