#include "intent.h"

#include "cohaptic_math.h"

enum { XX, XV, XA, VV, VA, AA };

/* Place in `covariance` of row i and column j. */
static const int PLACE[3][3] = {{XX, XV, XA}, {XV, VV, VA}, {XA, VA, AA}};

/* What a decaying acceleration does in a time: to position, to velocity, to itself. */
typedef struct {
    double time, to_position, to_velocity, kept;
} Decay;

static Decay decay_over(const IntentTuning *tuning, double time)
{
    const double kept = exp(-time / tuning->decay);
    const double to_velocity = tuning->decay * (1.0 - kept);
    return (Decay){time, tuning->decay * (time - to_velocity), to_velocity, kept};
}

static double *coordinate_of(Motion motion[MOTIONS], int number, bool velocity)
{
    Vector *vector = velocity ? &motion[number / 2].velocity : &motion[number / 2].position;
    return number % 2 ? &vector->y : &vector->x;
}

static double unit_of(const IntentTuning *tuning, int number)
{
    return number / 2 == MOTION_BOX_ANGLE ? tuning->arm : 1.0;
}

/* Both beliefs as one: its share of `other` is `weight`. */
static Belief mixed(const Belief *one, const Belief *other, double weight)
{
    Belief mix;
    for (int i = 0; i < 3; i++)
        mix.mean[i] = (1.0 - weight) * one->mean[i] + weight * other->mean[i];
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++) {
            const int k = PLACE[i][j];
            const double apart = (one->mean[i] - mix.mean[i]) * (one->mean[j] - mix.mean[j]);
            const double beyond = (other->mean[i] - mix.mean[i]) * (other->mean[j] - mix.mean[j]);
            mix.covariance[k] = (1.0 - weight) * (one->covariance[k] + apart)
                                + weight * (other->covariance[k] + beyond);
        }
    return mix;
}

static Belief rested(const IntentTuning *tuning, const Belief *now, double time)
{
    Belief later = {.mean = {now->mean[0], 0.0, 0.0}};
    const double drifted = tuning->drift * time;
    later.covariance[XX] = now->covariance[XX] + drifted * drifted;
    return later;
}

static Belief moved(const IntentTuning *tuning, const Belief *now, const Decay *decay)
{
    const double step[3][3] = {{1.0, decay->time, decay->to_position},
                               {0.0, 1.0, decay->to_velocity},
                               {0.0, 0.0, decay->kept}};
    Belief later = {0};
    double half[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            later.mean[i] += step[i][j] * now->mean[j];
            half[i][j] = 0.0;
            for (int k = 0; k < 3; k++) half[i][j] += step[i][k] * now->covariance[PLACE[k][j]];
        }
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++)
            for (int k = 0; k < 3; k++)
                later.covariance[PLACE[i][j]] += half[i][k] * step[j][k];
    const double lost = 1.0 - decay->kept * decay->kept;
    later.covariance[AA] += tuning->acceleration * tuning->acceleration * lost;
    return later;
}

/* The belief after position and velocity were seen, and how likely that was: its logarithm. */
static double corrected(const IntentTuning *tuning, Belief *belief, double position,
                        double velocity)
{
    const Belief b = *belief;
    const double *c = b.covariance;
    const double xx = c[XX] + tuning->position_noise * tuning->position_noise;
    const double vv = c[VV] + tuning->velocity_noise * tuning->velocity_noise, xv = c[XV];
    const double size = xx * vv - xv * xv;
    const double dx = position - b.mean[0], dv = velocity - b.mean[1];
    double gain[3][2];
    for (int i = 0; i < 3; i++) {
        const double p = c[PLACE[i][0]], q = c[PLACE[i][1]];
        gain[i][0] = (p * vv - q * xv) / size;
        gain[i][1] = (q * xx - p * xv) / size;
        belief->mean[i] += gain[i][0] * dx + gain[i][1] * dv;
    }
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++)
            belief->covariance[PLACE[i][j]] -=
                gain[i][0] * c[PLACE[0][j]] + gain[i][1] * c[PLACE[1][j]];
    return -0.5 * ((vv * dx * dx - 2.0 * xv * dx * dv + xx * dv * dv) / size + log(size));
}

static CoordinateIntent begun(const IntentTuning *tuning, double position, double velocity)
{
    const Belief seen = {{position, velocity, 0.0},
                         {tuning->position_noise * tuning->position_noise, 0.0, 0.0,
                          tuning->velocity_noise * tuning->velocity_noise, 0.0,
                          tuning->acceleration * tuning->acceleration}};
    return (CoordinateIntent){seen, seen, 0.5};
}

static CoordinateIntent gone_on(const IntentTuning *tuning, const CoordinateIntent *one,
                                double position, double velocity, const Decay *decay)
{
    const double start = 1.0 - exp(-tuning->start_rate * decay->time);
    const double stop = 1.0 - exp(-tuning->stop_rate * decay->time);
    const double resting = 1.0 - one->moving;
    const double rest = (1.0 - start) * resting + stop * one->moving;
    const double move = start * resting + (1.0 - stop) * one->moving;
    const Belief before_rest = mixed(&one->rest, &one->move, stop * one->moving / rest);
    const Belief before_move = mixed(&one->move, &one->rest, start * resting / move);
    CoordinateIntent now;
    now.rest = rested(tuning, &before_rest, decay->time);
    now.move = moved(tuning, &before_move, decay);
    const double likely_rest = corrected(tuning, &now.rest, position, velocity);
    const double likely_move = corrected(tuning, &now.move, position, velocity);
    now.moving = move / (move + rest * exp(likely_rest - likely_move));
    return now;
}

/* One coordinate after what its peer says at `tick`; as it was where that is no news or no number. */
static CoordinateIntent heard(const IntentTuning *tuning, const Intent *before, int number,
                              Motion motion[MOTIONS], int64_t tick, double period)
{
    const CoordinateIntent *one = &before->coordinate[number];
    const double unit = unit_of(tuning, number);
    const double position = unit * *coordinate_of(motion, number, false);
    const double velocity = unit * *coordinate_of(motion, number, true);
    if (before->heard && tick == before->tick) return *one;
    if (!isfinite(position) || !isfinite(velocity)) return *one;
    if (!before->heard || tick < before->tick) return begun(tuning, position, velocity);
    const Decay decay = decay_over(tuning, (double)(tick - before->tick) * period);
    return gone_on(tuning, one, position, velocity, &decay);
}

void intent_hear(const IntentTuning *tuning, Intent *intent, Motion motion[MOTIONS], int64_t tick,
                 double period)
{
    for (int n = 0; n < INTENT_COORDINATES; n++)
        intent->coordinate[n] = heard(tuning, intent, n, motion, tick, period);
    intent->tick = tick;
    intent->heard = 1;
}

void intent_ahead(const IntentTuning *tuning, const Intent *intent, double ahead, int64_t tick,
                  double period, Motion motion[MOTIONS])
{
    const Decay decay = decay_over(tuning, ahead);
    for (int n = 0; n < INTENT_COORDINATES; n++) {
        const CoordinateIntent one = heard(tuning, intent, n, motion, tick, period);
        const double *move = one.move.mean;
        const double further = move[0] + ahead * move[1] + decay.to_position * move[2];
        const double rate = move[1] + decay.to_velocity * move[2];
        const double unit = unit_of(tuning, n);
        *coordinate_of(motion, n, false) =
            ((1.0 - one.moving) * one.rest.mean[0] + one.moving * further) / unit;
        *coordinate_of(motion, n, true) = one.moving * rate / unit;
    }
}
