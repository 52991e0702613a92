/* From a commanded joint torque to the torque on the joint, and from joint angle to counts. */
#ifndef COHAPTIC_DRIVE_H
#define COHAPTIC_DRIVE_H

#include <stdint.h>

typedef struct {
    double torque_limit;      /* N.m, 0: none */
    double torque_per_volt;   /* K_t gear G_amp, N.m/V */
    double torque_per_ampere; /* K_t gear, N.m/A */
    double range;             /* V, 0: unlimited */
    double step;              /* V per code, 0: not quantised */
    double largest_code;
    double current_limit;     /* A, 0: none */
    double bandwidth;         /* rad/s, 0: ideal */
} Drive;

typedef struct {
    double quantum; /* rad per count, 0: not quantised */
    double offset;  /* angle at which the count is zero, rad */
    double bias;    /* homing error that the reading does not know of, rad */
} Encoder;

/* DAC of `bits` over [-range, range]: codes are symmetric, so that minus is as strong as plus. */
void drive_set_dac(Drive *drive, double range, int64_t bits);

/* The torque that the drive was really told, N.m: clamped, turned into volts, clamped, truncated
 * towards zero to a code, and back (V = tau / (K_t gear G_amp)). NaN gives zero. */
double drive_commanded_torque(const Drive *drive, double torque);

/* The current that the amplifier heads for, A. */
double drive_target_current(const Drive *drive, double commanded_torque);

int64_t encoder_count(const Encoder *encoder, double angle);
double encoder_angle(const Encoder *encoder, double angle);

#endif
