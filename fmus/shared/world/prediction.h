/* Where peers are taken to be between their packets. Included after the generated header. */
#ifndef COHAPTIC_PREDICTION_H
#define COHAPTIC_PREDICTION_H

#include "intent.h"
#include "workstation.h"

/* What a peer says of its fingers, from any struct with the members of a packet. */
#define READ_FINGER_MOTIONS(motion, source) \
    do { \
        (motion)[MOTION_FINGER_1] = motion_of((source)->finger_1_position, (source)->finger_1_velocity); \
        (motion)[MOTION_FINGER_2] = motion_of((source)->finger_2_position, (source)->finger_2_velocity); \
    } while (0)

#define READ_BOX_MOTIONS(motion, source) \
    do { \
        (motion)[MOTION_BOX] = (Motion){{(source)->box_x, (source)->box_y}, \
                                        {(source)->box_vx, (source)->box_vy}}; \
        (motion)[MOTION_BOX_ANGLE] = (Motion){{(source)->box_theta, 0.0}, {(source)->box_omega, 0.0}}; \
    } while (0)

static inline Motion motion_of(const double position[2], const double velocity[2])
{
    return (Motion){{position[0], position[1]}, {velocity[0], velocity[1]}};
}

static IntentTuning intent_tuning(const Variables *v)
{
    return (IntentTuning){v->intent.acceleration,   v->intent.decay,
                          v->intent.drift,          v->intent.position_noise,
                          v->intent.velocity_noise, v->intent.start_rate,
                          v->intent.stop_rate,      0.5 * v->side};
}

/* The sentence where the predictor cannot be used as it is set. */
static const char *prediction_set_up(const Variables *v)
{
    if (v->predictor != PREDICTOR_INTENT) return NULL;
    if (v->deadband > 0.0)
        return "predictor 'intent' and a deadband do not go together: a sender that withholds what "
               "its receiver would guess cannot know what this receiver guesses. Take 'linear', or "
               "set deadband to 0.";
    const double least[] = {v->intent.acceleration,   v->intent.decay,      v->intent.position_noise,
                            v->intent.velocity_noise, v->intent.start_rate, v->intent.stop_rate};
    for (size_t i = 0; i < sizeof least / sizeof *least; i++)
        if (!(least[i] > 0.0))
            return "intent.acceleration, decay, position_noise, velocity_noise, start_rate and "
                   "stop_rate have to be above 0.";
    return NULL;
}

/* How long ago what a peer last said was so, s. `peer_age` comes from the link; where nothing drives it
 * the ticks of both sides count from the same instant. */
static double prediction_time(const Variables *v, int p, int64_t tick, int64_t source_tick,
                              int64_t source_age)
{
    int64_t age = v->peer_age[p] > 0 ? v->peer_age[p] : tick - source_tick + source_age;
    if (age < 0) age = 0;
    if (age > v->prediction_limit) age = v->prediction_limit;
    return (double)age * v->sample_period;
}

/* Whether the predictor has to hear peer p. */
static bool is_heard(const Variables *v, int p, int64_t source_tick)
{
    return v->predictor == PREDICTOR_INTENT && p < v->peers && v->peer_valid[p]
           && v->peer_weight[p] > 0.0 && source_tick >= 0;
}

/* Commit what peer p says; what was believed of one that does not count any more is forgotten. */
static void hear_peer(const Variables *v, int p, Intent *intent, int64_t source_tick,
                      int64_t source_age, Motion motion[MOTIONS])
{
    if (is_heard(v, p, source_tick)) {
        const IntentTuning tuning = intent_tuning(v);
        intent_hear(&tuning, intent, motion, source_tick - source_age, v->sample_period);
    } else if (intent->heard)
        *intent = (Intent){0};
}

/* Move what peer p says on to this tick. */
static void move_on(const Variables *v, int p, const Intent *intent, int64_t tick,
                    int64_t source_tick, int64_t source_age, Motion motion[MOTIONS])
{
    const double age = prediction_time(v, p, tick, source_tick, source_age);
    if (is_heard(v, p, source_tick)) {
        const IntentTuning tuning = intent_tuning(v);
        intent_ahead(&tuning, intent, age, source_tick - source_age, v->sample_period, motion);
        return;
    }
    const double ahead = v->predictor == PREDICTOR_LINEAR ? age : 0.0;
    for (int m = 0; m < MOTIONS; m++)
        motion[m].position = plus(motion[m].position, times(ahead, motion[m].velocity));
}

#endif
