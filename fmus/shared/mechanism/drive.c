#include "drive.h"

#include "cohaptic_math.h"

static double clamp(double value, double limit) { return fmax(-limit, fmin(limit, value)); }

void drive_set_dac(Drive *drive, double range, int64_t bits)
{
    drive->range = range;
    drive->largest_code = bits > 0 ? (double)((INT64_C(1) << (bits - 1)) - 1) : 0.0;
    drive->step = bits > 0 && range > 0.0 ? range / drive->largest_code : 0.0;
}

double drive_commanded_torque(const Drive *drive, double torque)
{
    if (!(torque == torque)) return 0.0;
    if (drive->torque_limit > 0.0) torque = clamp(torque, drive->torque_limit);
    if (!(drive->range > 0.0)) return torque;
    const double volts = clamp(torque / drive->torque_per_volt, drive->range);
    if (!(drive->step > 0.0)) return volts * drive->torque_per_volt;
    /* The hair keeps a torque that came from a code on that code. */
    const double code = trunc(volts / drive->step * (1.0 + 4e-16));
    return clamp(code, drive->largest_code) * drive->step * drive->torque_per_volt;
}

double drive_target_current(const Drive *drive, double commanded_torque)
{
    const double current = commanded_torque / drive->torque_per_ampere;
    return drive->current_limit > 0.0 ? clamp(current, drive->current_limit) : current;
}

int64_t encoder_count(const Encoder *encoder, double angle)
{
    if (!(encoder->quantum > 0.0)) return 0;
    return (int64_t)floor((angle + encoder->bias - encoder->offset) / encoder->quantum + 0.5);
}

double encoder_angle(const Encoder *encoder, double angle)
{
    if (!(encoder->quantum > 0.0)) return angle + encoder->bias;
    return encoder->offset + (double)encoder_count(encoder, angle) * encoder->quantum;
}
