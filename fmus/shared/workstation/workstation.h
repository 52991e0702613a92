/* Between a workstation model's variables and the shared C. Included by a model after its generated
 * header, because each model has its own struct Variables; the names are those of
 * fmus/shared/workstation/{station,fingers,peers}.py. */
#ifndef COHAPTIC_WORKSTATION_H
#define COHAPTIC_WORKSTATION_H

#include "device_parameters.h"
#include "finger.h"
#include "packet.h"

enum { FINGERS = 2 };

typedef struct {
    Finger finger[FINGERS];
    Deadband deadband;
    double period;
} Station;

/* What every workstation commits. */
typedef struct {
    FingerState finger[FINGERS];
    int64_t tick;
} StationState;

static const char *station_set_up(const Variables *v, Station *station, StationState *state, Report *r)
{
    if (!(v->sample_period > 0.0)) return "sample_period must be positive.";
    if (v->velocity_window < 1 || v->velocity_window > LONGEST_WINDOW - 1)
        return "velocity_window must be between 1 and 31 samples.";
    if (v->fingers < 1 || v->fingers > FINGERS) return "fingers must be 1 or 2.";
    if (v->network_ticks < 1) return "network_ticks must be at least 1.";
    station->period = v->sample_period;
    station->deadband = (Deadband){
        .fraction = v->deadband,
        .force = v->deadband_force,
        .arm = v->deadband_arm,
        .samples = v->network_ticks,
        .longest = v->deadband_longest,
        .period = v->sample_period,
    };
    state->tick = (int64_t)round(report_start_time(r) / v->sample_period);
    for (int f = 0; f < FINGERS; f++) {
        DeviceGeometry geometry;
        const char *missing =
            DEVICE_RESOLVE_ALL(DEVICE_GEOMETRY, &geometry, &v->finger[f], v->finger[f].device);
        if (missing)
            return report_format(r, "finger_%d.device is custom, so finger_%d.%s must be given.",
                                 f + 1, f + 1, missing);
        if (!(geometry.proximal_length > 0.0 && geometry.distal_length > 0.0))
            return report_format(r, "The link lengths of finger_%d must be positive.", f + 1);
        if (!(v->finger[f].max_force > 0.0))
            return report_format(r, "finger_%d.max_force must be positive.", f + 1);
        station->finger[f] = (Finger){
            .bar = five_bar(geometry.proximal_length, geometry.distal_length,
                            geometry.base_distance),
            .place = placement(v->finger[f].base_x, v->finger[f].base_y, v->finger[f].base_angle),
            .quantum = geometry.encoder_counts > 0 ? 2.0 * M_PI / (double)geometry.encoder_counts : 0.0,
            .passivity = {v->passivity == PASSIVITY_TIME_DOMAIN, v->passivity_damping_limit,
                          v->passivity_reserve, v->finger[f].max_force, v->sample_period},
            .used = f < v->fingers,
            .reports_work = v->finger[f].device_reports_work,
            .adaptive = v->velocity_estimator == VELOCITYESTIMATOR_FOAW,
            .window = v->velocity_window,
            .period = v->sample_period,
        };
    }
    return NULL;
}

static void station_measure(const Variables *v, const Station *station, const StationState *state,
                            FingerMeasurement measured[FINGERS])
{
    for (int f = 0; f < FINGERS; f++) {
        measured[f] = finger_measure(&station->finger[f], &state->finger[f], v->finger[f].joint_angle,
                                     v->finger[f].status, v->finger[f].sample_age, state->tick);
        measured[f].work = v->finger[f].device_work;
    }
}

static const char *station_check_step(const Station *station, double h, Report *r)
{
    if (fabs(h - station->period) <= 1e-9 * station->period) return NULL;
    return report_format(r,
                         "The communication step is %g s but sample_period is %g s: set "
                         "sample_period to the period at which this workstation runs.",
                         h, station->period);
}

static void station_commit(const Variables *v, const Station *station, StationState *state,
                           const FingerMeasurement measured[FINGERS], const Vector force[FINGERS])
{
    for (int f = 0; f < FINGERS; f++)
        finger_commit(&station->finger[f], &state->finger[f], &measured[f], force[f],
                      v->finger[f].sample_age, state->tick);
    state->tick++;
}

/* Position, velocity, force and torque of one finger into its outputs. */
static void station_render(Variables *v, const Station *station, const StationState *state, int f,
                           const FingerMeasurement *measured, Vector force)
{
    const Vector rendered =
        finger_rendered_force(&station->finger[f], &state->finger[f], measured, force);
    v->finger[f].position[0] = measured->position.x;
    v->finger[f].position[1] = measured->position.y;
    v->finger[f].velocity[0] = measured->velocity.x;
    v->finger[f].velocity[1] = measured->velocity.y;
    v->finger[f].force[0] = rendered.x;
    v->finger[f].force[1] = rendered.y;
    v->finger[f].observed_energy = finger_energy(&station->finger[f], &state->finger[f], measured);
    v->finger[f].saturated_ticks = state->finger[f].saturated;
    finger_torque(&station->finger[f], measured, rendered, v->finger[f].motor_torque);
}

/* Status and age of all fingers together, for a packet. */
static int64_t station_status(const Variables *v, const FingerMeasurement measured[FINGERS])
{
    int64_t all = v->finger[0].status, any = all;
    if (v->fingers > 1) {
        all &= v->finger[1].status;
        any |= v->finger[1].status;
    }
    int64_t status = (all & (STATUS_HOMED | STATUS_ACTIVE | STATUS_OUTPUT)) | (any & STATUS_FAULT);
    for (int f = 0; f < FINGERS; f++)
        if (measured[f].present) status |= STATUS_FINGER << f;
    return status;
}

static int64_t station_age(const Variables *v)
{
    const int64_t first = v->finger[0].sample_age, second = v->finger[1].sample_age;
    return v->fingers > 1 && second > first ? second : first;
}

/* The largest force that an own finger was given, N: what a user of this box feels of it. */
static inline double station_felt(const StationState *state)
{
    double largest = 0.0;
    for (int f = 0; f < FINGERS; f++)
        largest = fmax(largest, hypot(state->finger[f].port.effort.x, state->finger[f].port.effort.y));
    return largest;
}

/* The fingers' part of a packet. */
static inline void pack_fingers(const FingerMeasurement measured[FINGERS], Packet *packet)
{
    for (int f = 0; f < FINGERS; f++)
        packet->motion[MOTION_FINGER_1 + f] = (Motion){measured[f].position, measured[f].velocity};
}

/* The head of a packet; what is repeated by the deadband is older than the device's own data. */
#define WRITE_SOURCE(target, v, measured, now, packet_sent, contact) \
    do { \
        (target).source_tick = (now); \
        (target).source_age = station_age(v) + ((now) - (packet_sent)->tick); \
        (target).status = station_status(v, measured) | (contact) \
                          | ((packet_sent)->tick < (now) ? STATUS_REPEATED : 0); \
    } while (0)

#define WRITE_VECTOR(target, vector) \
    do { \
        (target)[0] = (vector).x; \
        (target)[1] = (vector).y; \
    } while (0)

#define WRITE_FINGERS(target, packet) \
    do { \
        WRITE_VECTOR((target).finger_1_position, (packet).motion[MOTION_FINGER_1].position); \
        WRITE_VECTOR((target).finger_1_velocity, (packet).motion[MOTION_FINGER_1].velocity); \
        WRITE_VECTOR((target).finger_2_position, (packet).motion[MOTION_FINGER_2].position); \
        WRITE_VECTOR((target).finger_2_velocity, (packet).motion[MOTION_FINGER_2].velocity); \
    } while (0)

#endif
