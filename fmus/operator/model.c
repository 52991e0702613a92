/* The emulated user: F = F_cmd + k (x_ref - x) + b (dx_ref/dt - dx/dt), per axis; with a grip, the same on
 * an arm's mass, and the grip's spring and damper from there to the finger. */
#include "operator_variables.h"
#include "tracking.h"
#include "waveform.h"

enum { AXES = 2, VIA_POINTS = 16, CAPACITY = 16384, COLUMNS = 3 };

/* The arm's mass behind the grip; `held` once it is where the finger was. */
typedef struct {
    double position[AXES], velocity[AXES];
    int64_t held;
} Grip;

struct State {
    double time;
    Tracking tracking;
    Grip grip;
    size_t count;
    double rows[CAPACITY * COLUMNS];
};

const size_t model_state_size = sizeof(State);

size_t model_state_used(const State *s)
{
    if (s->count > CAPACITY)
        return SIZE_MAX;
    return offsetof(State, rows) + s->count * COLUMNS * sizeof s->rows[0];
}

const char *model_initialise(Variables *v, State *s, Report *r)
{
    s->time = report_start_time(r);
    if (v->impedance == OPERATOR_IMPEDANCE_CUSTOM_GRIP && !(v->hand_mass > 0.0))
        return "impedance is 'custom_grip', which needs a hand_mass above 0.";
    if (v->trajectory == OPERATOR_TRAJECTORY_MINIMUM_JERK) {
        if (v->via_count == 0)
            return "trajectory is 'minimum_jerk', but via_count is 0; give via points.";
        double before = v->trajectory_start_time;
        for (int64_t i = 0; i < v->via_count; before = v->via_time[i++])
            if (!(v->via_time[i] > before))
                return report_format(r, "via_time[%d] is %g s, not after %g s; times must rise, "
                                        "from trajectory_start_time on.",
                                     (int)i + 1, v->via_time[i], before);
    }
    if (v->trajectory == OPERATOR_TRAJECTORY_TRACKED) {
        if (!(v->tracking_frequency > 0.0 && v->tracking_speed > 0.0))
            return "tracking_frequency and tracking_speed have to be above 0.";
        for (int axis = 0; axis < AXES; ++axis)
            s->tracking.position[axis] = v->initial_position[axis];
        s->tracking.weight = 1.0;
    }
    if (v->trajectory != OPERATOR_TRAJECTORY_RECORDED)
        return NULL;
    if (v->trajectory_file[0] == '\0')
        return "trajectory is 'recorded', but trajectory_file is empty; give the path of a file.";
    return read_samples(r, v->trajectory_file, COLUMNS, CAPACITY, s->rows, &s->count);
}

/* The sum over segments; each has run to its end before the next one begins. */
static Signal via_signal(const Variables *v, double t, const double *points, double start)
{
    Signal sum = {start, 0.0};
    double before = v->trajectory_start_time, from = start;
    for (int64_t i = 0; i < v->via_count && t >= before; ++i) {
        const Signal part = minimum_jerk_signal(t, before, v->via_time[i] - before);
        const bool reached = part.value >= 1.0;
        sum.value = reached ? points[i] : from + (points[i] - from) * part.value;
        sum.rate = (points[i] - from) * part.rate;
        before = v->via_time[i];
        from = points[i];
    }
    return sum;
}

static Signal reference(const Variables *v, const State *s, int axis)
{
    const double start = v->initial_position[axis];
    Signal signal = {start, 0.0};
    switch (v->trajectory) {
    case OPERATOR_TRAJECTORY_SINE:
        signal = sine_signal(s->time, (Window){v->trajectory_start_time, 0.0},
                             v->sine_frequency[axis], v->sine_phase[axis]);
        signal.value = start + v->sine_amplitude[axis] * signal.value;
        signal.rate *= v->sine_amplitude[axis];
        break;
    case OPERATOR_TRAJECTORY_MINIMUM_JERK:
        signal = via_signal(v, s->time, axis == 0 ? v->via_x : v->via_y, start);
        break;
    case OPERATOR_TRAJECTORY_TRACKED:
        signal = (Signal){s->tracking.position[axis], s->tracking.velocity[axis]};
        break;
    case OPERATOR_TRAJECTORY_GIVEN:
        signal.value = v->target_position[axis];
        if (s->tracking.interval > 0.0)
            signal.rate = (signal.value - s->tracking.sample[axis]) / s->tracking.interval;
        break;
    case OPERATOR_TRAJECTORY_RECORDED:
        signal = sampled_signal(s->rows, s->count, COLUMNS, (size_t)axis + 1,
                                s->time - v->trajectory_start_time, true);
        break;
    }
    return signal;
}

static double command(const Variables *v, const State *s, int axis)
{
    const Window window = {v->force_start_time[axis], v->force_duration[axis]};
    Signal signal = {0.0, 0.0};
    if (s->tracking.presence != TRACKING_NOBODY)
        return 0.0; /* the emulated user's */
    switch (v->force_mode[axis]) {
    case OPERATOR_FORCE_MODE_CONSTANT:
        signal.value = 1.0;
        break;
    case OPERATOR_FORCE_MODE_STEP:
        signal = step_signal(s->time, window);
        break;
    case OPERATOR_FORCE_MODE_SINE:
        signal = sine_signal(s->time, window, v->force_frequency[axis], v->force_phase[axis]);
        break;
    }
    signal.value *= v->force_amplitude[axis];
    return v->force_rectify[axis] ? half_wave(signal).value : signal.value;
}

/* Arm and grip on one axis. */
typedef struct {
    double stiffness, damping;
    double mass; /* behind the grip; 0: there is none */
    double grip_stiffness, grip_damping;
} Hand;

static Hand hand_of(const Variables *v, int axis)
{
    const double *row = OPERATOR_HANDS[v->impedance];
    switch (v->impedance) {
    case OPERATOR_IMPEDANCE_CUSTOM:
        return (Hand){v->stiffness[axis], v->damping[axis], 0.0, 0.0, 0.0};
    case OPERATOR_IMPEDANCE_CUSTOM_GRIP:
        return (Hand){v->stiffness[axis], v->damping[axis], v->hand_mass, v->grip_stiffness,
                      v->grip_damping};
    default:
        return (Hand){row[0], row[1], row[2], row[3], row[4]};
    }
}

/* Where the arm's mass is: at first, where it took hold of the finger. */
static Signal arm_place(const Variables *v, const State *s, int axis)
{
    if (!s->grip.held) return (Signal){v->position[axis], v->velocity[axis]};
    return (Signal){s->grip.position[axis], s->grip.velocity[axis]};
}

static double pull(double stiffness, double damping, Signal from, const Variables *v, int axis)
{
    return stiffness * (from.value - v->position[axis]) + damping * (from.rate - v->velocity[axis]);
}

void model_outputs(Variables *v, const State *s)
{
    for (int axis = 0; axis < AXES; ++axis) {
        const Hand hand = hand_of(v, axis);
        const Signal wanted = reference(v, s, axis);
        v->reference_position[axis] = wanted.value;
        v->reference_velocity[axis] = wanted.rate;
        v->force_command[axis] = command(v, s, axis);
        if (hand.mass > 0.0)
            v->force[axis] = v->force_command[axis] + pull(hand.grip_stiffness, hand.grip_damping,
                                                           arm_place(v, s, axis), v, axis);
        else
            v->force[axis] = v->force_command[axis] +
                             hand.stiffness * (wanted.value - v->position[axis]) +
                             hand.damping * (wanted.rate - v->velocity[axis]);
        if (v->trajectory == OPERATOR_TRAJECTORY_TRACKED)
            v->force[axis] *= s->tracking.weight;
    }
}

/* The arm's mass over a step, by the implicit midpoint rule: the finger goes on as it does, and so does
 * the reference. */
static void move_arm(const Variables *v, State *s, int axis, double h)
{
    const Hand hand = hand_of(v, axis);
    if (!(hand.mass > 0.0)) { /* so that a grip begins where the finger is */
        s->grip.position[axis] = v->position[axis];
        s->grip.velocity[axis] = v->velocity[axis];
        return;
    }
    const Signal wanted = reference(v, s, axis), arm = arm_place(v, s, axis);
    const double half = 0.5 * h;
    const double finger = v->position[axis] + half * v->velocity[axis] - arm.value;
    const double goal = wanted.value + half * wanted.rate - arm.value;
    const double push = hand.grip_stiffness * finger + hand.grip_damping * v->velocity[axis]
                        + hand.stiffness * goal + hand.damping * wanted.rate;
    const double held = half * (hand.grip_damping + hand.damping)
                        + half * half * (hand.grip_stiffness + hand.stiffness);
    const double middle = (hand.mass * arm.rate + half * push) / (hand.mass + held);
    s->grip.position[axis] = arm.value + h * middle;
    s->grip.velocity[axis] = 2.0 * middle - arm.rate;
}

/* Nobody was there yet: the via points. */
static void emulate(const Variables *v, Tracking *k, double t)
{
    for (int axis = 0; axis < AXES; ++axis) {
        const double *points = axis == 0 ? v->via_x : v->via_y;
        const Signal signal = via_signal(v, t, points, v->initial_position[axis]);
        k->position[axis] = signal.value;
        k->velocity[axis] = signal.rate;
    }
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    for (int axis = 0; axis < AXES; ++axis) move_arm(v, s, axis, h);
    s->grip.held = 1;
    s->time = t + h;
    if (v->trajectory == OPERATOR_TRAJECTORY_GIVEN) {
        s->tracking.interval = h;
        for (int axis = 0; axis < AXES; ++axis)
            s->tracking.sample[axis] = v->target_position[axis];
    }
    if (v->trajectory != OPERATOR_TRAJECTORY_TRACKED)
        return NULL;
    const Target target = {
        .valid = v->target_valid, .count = v->target_count, .age = v->target_age,
        .position = {v->target_position[0], v->target_position[1]},
    };
    const TrackingLimits limits = {
        v->tracking_frequency, v->tracking_speed, v->target_hold_time,
    };
    if (!tracking_step(&s->tracking, &target, &limits, v->position, t, h))
        emulate(v, &s->tracking, s->time);
    return NULL;
}
