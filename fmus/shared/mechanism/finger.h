/* A workstation's own finger: from joint angles to position and velocity, from force to torque. */
#ifndef COHAPTIC_FINGER_H
#define COHAPTIC_FINGER_H

#include <stdbool.h>
#include <stdint.h>

#include "five_bar.h"
#include "passivity.h"
#include "port.h"
#include "velocity_estimator.h"

enum { STATUS_HOMED = 1, STATUS_ACTIVE = 2, STATUS_FAULT = 4, STATUS_OUTPUT = 8, STATUS_CONTACT = 16,
       STATUS_FINGER = 32, /* finger 1 can be touched; finger 2: twice this */
       STATUS_REPEATED = 128 /* of a packet: its content is an earlier one's, by the deadband */ };

typedef struct {
    FiveBar bar;
    Placement place;
    double quantum;   /* of the joint angle, rad; 0: not quantised */
    Passivity passivity;
    bool used;
    bool reports_work; /* the device says itself what work its motors have done */
    bool adaptive;    /* FOAW on the joint angles, otherwise finite difference on the tip */
    int64_t window;   /* ticks */
    double period;    /* s */
} Finger;

typedef struct {
    SampleWindow samples;
    Vector position; /* the last good one, world */
    Port port;       /* of what is rendered */
    double work;     /* that the device had reported, J */
    int64_t saturated; /* ticks in which the wanted force was more than the device's */
} FingerState;

typedef struct {
    bool readable;     /* the joint angles are a position that the mechanism can take */
    bool present;      /* readable, and the device is homed, active and without fault */
    Vector position, velocity; /* world */
    double jacobian[2][2];
    double sample[2];  /* what the estimator keeps of this tick */
    double work;       /* that the device's motors have done so far, J; where it reports it */
} FingerMeasurement;

/* Whether forces may be exchanged with a device in this status. */
bool status_is_active(int64_t status);

/* Pure. `sample_age` is 0 where joint_angle was measured at this tick; older readings are held and
 * the estimate stays that of the last new sample. */
FingerMeasurement finger_measure(const Finger *finger, const FingerState *state,
                                 const double joint_angle[2], int64_t status, int64_t sample_age,
                                 int64_t tick);

/* The energy that the user has put into what is rendered, up to this tick, J. */
double finger_energy(const Finger *finger, const FingerState *state,
                     const FingerMeasurement *measured);

/* Take this tick's measurement into the window and the force's work into the energy. */
void finger_commit(const Finger *finger, FingerState *state, const FingerMeasurement *measured,
                   Vector force, int64_t sample_age, int64_t tick);

/* The force that is rendered for a wanted one (N, world). */
Vector finger_rendered_force(const Finger *finger, const FingerState *state,
                             const FingerMeasurement *measured, Vector force);

/* Whether a wanted force (N, world) is more than the device gives. */
bool finger_saturates(const Finger *finger, const FingerMeasurement *measured, Vector force);

/* Joint torques of a force on the tip, tau = J' F, N.m. Zero where the finger is not present. */
void finger_torque(const Finger *finger, const FingerMeasurement *measured, Vector force,
                   double torque[2]);

#endif
