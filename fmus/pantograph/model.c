/* The five-bar device: see README.md beside this file for the equations and their sources. */
#include "device_parameters.h"
#include "drive.h"
#include "mechanism.h"
#include "pantograph_variables.h"

#define LONGEST_DELAY 8

enum { STATUS_IN_SIMULATION = 1 | 2 | 8 }; /* homed, active, output enabled */

struct State {
    MechanismState motion;
    double current[2];
    double work; /* of the motors on the joints so far, J */
    double delayed[LONGEST_DELAY][2]; /* the last torque commands, oldest at `oldest` */
    int64_t oldest;
    Mechanism mechanism;
    Placement place;
    Drive drive;
    Encoder encoder[2];
};

const size_t model_state_size = sizeof(State);

static void set_up_drive(Drive *drive, const DeviceDynamics *device)
{
    drive->torque_limit = device->torque_limit;
    drive->torque_per_ampere = device->torque_constant * device->gear_ratio;
    drive->torque_per_volt = drive->torque_per_ampere * device->amplifier_gain;
    drive->current_limit = device->current_limit;
    drive->bandwidth = 2.0 * M_PI * device->amplifier_bandwidth;
    drive_set_dac(drive, device->dac_range, device->dac_bits);
}

static void set_up_mechanism(Mechanism *m, const DeviceGeometry *geometry,
                             const DeviceDynamics *device, const Variables *v)
{
    m->bar = five_bar(geometry->proximal_length, geometry->distal_length, geometry->base_distance);
    m->joint_inertia =
        device->proximal_inertia + device->gear_ratio * device->gear_ratio * device->rotor_inertia;
    m->distal_mass = device->distal_mass;
    m->distal_inertia = device->distal_inertia;
    m->end_mass = device->tip_mass + v->finger_mass;
    m->viscous = device->viscous_friction;
    m->coulomb = device->coulomb_friction;
    m->minimum[0] = device->joint_minimum;
    m->maximum[0] = device->joint_maximum;
    m->minimum[1] = M_PI - device->joint_maximum;
    m->maximum[1] = M_PI - device->joint_minimum;
    m->stop_stiffness = v->stop_stiffness;
    m->stop_damping = v->stop_damping;
}

static const char *refusal(const Variables *v, const DeviceGeometry *geometry,
                           const DeviceDynamics *device)
{
    if (!(geometry->proximal_length > 0.0 && geometry->distal_length > 0.0))
        return "proximal_length and distal_length must be positive.";
    if (!(device->torque_constant > 0.0 && device->amplifier_gain > 0.0
          && device->gear_ratio > 0.0))
        return "torque_constant, amplifier_gain and gear_ratio must be positive.";
    if (!(device->proximal_inertia > 0.0))
        return "proximal_inertia must be positive, or the joints have no inertia.";
    if (device->dac_bits == 1 || device->dac_bits > 32)
        return "dac_bits must be 0 (ideal) or between 2 and 32.";
    if (!(device->joint_minimum < device->joint_maximum))
        return "joint_minimum must be below joint_maximum.";
    if (v->computation_delay_ticks < 0 || v->computation_delay_ticks > LONGEST_DELAY)
        return "computation_delay_ticks must be between 0 and 8.";
    if (v->substeps < 1 || v->substeps > 1000) return "substeps must be between 1 and 1000.";
    if (!(v->finger_mass >= 0.0)) return "finger_mass must not be negative.";
    return NULL;
}

static const char *place_tip(const Variables *v, State *s, Report *r)
{
    const Vector wanted = {v->initial_tip_position[0], v->initial_tip_position[1]};
    const Vector tip = to_device(&s->place, wanted);
    FiveBarPose pose;
    if (!five_bar_angles(&s->mechanism.bar, tip, s->motion.angle))
        return report_format(r,
                             "initial_tip_position (%g, %g) m is out of reach: in the frame of the "
                             "device it is (%g, %g) m, and each motor axis can reach from %g to %g m.",
                             wanted.x, wanted.y, tip.x, tip.y,
                             fabs(s->mechanism.bar.distal - s->mechanism.bar.proximal),
                             s->mechanism.bar.distal + s->mechanism.bar.proximal);
    for (int i = 0; i < 2; i++)
        if (s->motion.angle[i] < -0.5 * M_PI) s->motion.angle[i] += 2.0 * M_PI;
    five_bar_pose(&s->mechanism.bar, s->motion.angle, &pose);
    if (!pose.valid || hypot(pose.tip.x - tip.x, pose.tip.y - tip.y) > 1e-9)
        return report_format(r,
                             "initial_tip_position (%g, %g) m cannot be reached with the elbows "
                             "outwards: in the frame of the device it is (%g, %g) m.",
                             wanted.x, wanted.y, tip.x, tip.y);
    for (int i = 0; i < 2; i++)
        if (!(s->motion.angle[i] >= s->mechanism.minimum[i]
              && s->motion.angle[i] <= s->mechanism.maximum[i]))
            return report_format(r,
                                 "initial_tip_position (%g, %g) m puts joint %d at %g rad, beyond "
                                 "its mechanical stops at %g and %g rad.",
                                 wanted.x, wanted.y, i + 1, s->motion.angle[i],
                                 s->mechanism.minimum[i], s->mechanism.maximum[i]);
    return NULL;
}

const char *model_initialise(Variables *v, State *s, Report *r)
{
    DeviceGeometry geometry;
    DeviceDynamics device;
    const char *missing = DEVICE_RESOLVE_ALL(DEVICE_GEOMETRY, &geometry, v, v->device);
    if (!missing) missing = DEVICE_RESOLVE_ALL(DEVICE_DYNAMICS, &device, v, v->device);
    if (missing) return report_format(r, "device is custom, so %s must be given.", missing);
    const char *wrong = refusal(v, &geometry, &device);
    if (wrong) return wrong;
    set_up_mechanism(&s->mechanism, &geometry, &device, v);
    set_up_drive(&s->drive, &device);
    s->place = placement(v->base_x, v->base_y, v->base_angle);
    for (int i = 0; i < 2; i++)
        s->encoder[i] = (Encoder){
            geometry.encoder_counts > 0 ? 2.0 * M_PI / (double)geometry.encoder_counts : 0.0,
            v->encoder_offset[i], v->encoder_bias[i]};
    return place_tip(v, s, r);
}

/* The torque that takes effect in this step. */
static double due_torque(const Variables *v, const State *s, int i)
{
    const double torque = v->computation_delay_ticks > 0 ? s->delayed[s->oldest][i] : v->motor_torque[i];
    return drive_commanded_torque(&s->drive, torque);
}

/* What follows from the motion alone, worked out once a step. */
static void motion_outputs(Variables *v, const State *s)
{
    v->sample_age = 0;
    v->status = STATUS_IN_SIMULATION;
    FiveBarPose pose;
    five_bar_pose(&s->mechanism.bar, s->motion.angle, &pose);
    const double *rate = s->motion.rate;
    const Vector tip = to_world(&s->place, pose.tip);
    const Vector velocity = turn(
        s->place.rotation, (Vector){pose.jacobian[0][0] * rate[0] + pose.jacobian[0][1] * rate[1],
                            pose.jacobian[1][0] * rate[0] + pose.jacobian[1][1] * rate[1]});
    v->tip_position[0] = tip.x;
    v->tip_position[1] = tip.y;
    v->tip_velocity[0] = velocity.x;
    v->tip_velocity[1] = velocity.y;
    v->energy = mechanism_energy(&s->mechanism, &pose, rate);
    v->motor_work = s->work;
    for (int i = 0; i < 2; i++) {
        v->true_joint_angle[i] = s->motion.angle[i];
        v->joint_angle[i] = encoder_angle(&s->encoder[i], s->motion.angle[i]);
        v->encoder_count[i] = encoder_count(&s->encoder[i], s->motion.angle[i]);
    }
}

void model_outputs(Variables *v, const State *s)
{
    bool *motion_is_written = model_work(s);
    if (!*motion_is_written) motion_outputs(v, s);
    *motion_is_written = true;
    for (int i = 0; i < 2; i++) {
        v->applied_torque[i] = due_torque(v, s, i);
        v->motor_current[i] = s->drive.bandwidth > 0.0
                                  ? s->current[i]
                                  : drive_target_current(&s->drive, v->applied_torque[i]);
    }
}

static const char *singular(const MechanismState *motion, Report *r, double t)
{
    return report_format(r,
                         "at t = %g s the five-bar reached a singular position (joints at %g and %g "
                         "rad): the forces are too large for the mechanism; reduce them, move the "
                         "device or stiffen its stops.",
                         t, motion->angle[0], motion->angle[1]);
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    const Drive *drive = &s->drive;
    const double step = h / (double)v->substeps;
    const double half = drive->bandwidth > 0.0 ? exp(-0.5 * step * drive->bandwidth) : 0.0;
    const Vector force = turn_back(s->place.rotation, (Vector){v->hand_force[0], v->hand_force[1]});
    MechanismState motion = s->motion;
    double target[2], away[2]; /* what the amplifiers head for, and how far they are from it, A */
    for (int i = 0; i < 2; i++) {
        target[i] = drive_target_current(drive, due_torque(v, s, i));
        away[i] = drive->bandwidth > 0.0 ? s->current[i] - target[i] : 0.0;
    }
    Rotation joint[2];
    double work = s->work;
    mechanism_joints(&motion, joint);
    for (int64_t n = 0; n < v->substeps; n++) {
        double start[2], middle[2];
        for (int i = 0; i < 2; i++) {
            start[i] = drive->torque_per_ampere * (target[i] + away[i]);
            middle[i] = drive->torque_per_ampere * (target[i] + away[i] * half);
            away[i] *= half * half;
        }
        const double before[2] = {motion.angle[0], motion.angle[1]};
        if (!mechanism_step(&s->mechanism, &motion, joint, start, middle, force, step))
            return singular(&motion, r, t);
        for (int i = 0; i < 2; i++) work += middle[i] * (motion.angle[i] - before[i]);
    }
    FiveBarPose pose;
    five_bar_pose_at(&s->mechanism.bar, joint, &pose);
    if (!(pose.valid && five_bar_is_regular(pose.jacobian, v->condition_limit)))
        return singular(&motion, r, t);
    s->motion = motion;
    s->work = work;
    *(bool *)model_work(s) = false;
    for (int i = 0; i < 2; i++) s->current[i] = target[i] + away[i];
    if (v->computation_delay_ticks > 0) {
        for (int i = 0; i < 2; i++) s->delayed[s->oldest][i] = v->motor_torque[i];
        s->oldest = (s->oldest + 1) % v->computation_delay_ticks;
    }
    return NULL;
}
