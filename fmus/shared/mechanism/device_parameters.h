/* The parameters of a planar five-bar device, once: name, unit, the two presets, what it is.
 *
 * X(type, name, unit, Quanser-like, Haply-2DIY-v3-like, description)
 *
 * The C struct, the model's variables and their documentation all come from these two lists
 * (fmus/shared/mechanism/device.py reads them). "published": from the maker's or a third party's documents;
 * "assumed": our estimate, not measured on a device. A variable left at -1 takes its preset.
 */
#ifndef COHAPTIC_DEVICE_PARAMETERS_H
#define COHAPTIC_DEVICE_PARAMETERS_H

#include <stdint.h>

#define DEVICE_GEOMETRY(X) \
    X(real, proximal_length, "m", 0.100, 0.070, "length l of each proximal link (published)") \
    X(real, distal_length, "m", 0.165, 0.090, "length L of each distal link (published)") \
    X(real, base_distance, "m", 0.085, 0.038, "distance d between the motor axes (published)") \
    X(integer, encoder_counts, "1", 20000, 4880, "encoder counts per turn after quadrature (published); 0: ideal, not quantised")

#define DEVICE_DYNAMICS(X) \
    X(real, proximal_inertia, "kg.m2", 5.2e-5, 2.2e-5, "inertia of each proximal link about its motor axis (assumed)") \
    X(real, distal_mass, "kg", 0.013, 0.008, "mass of each distal link, centred (assumed)") \
    X(real, distal_inertia, "kg.m2", 2.9e-5, 5.4e-6, "inertia of each distal link about its centre (assumed)") \
    X(real, tip_mass, "kg", 0.015, 0.010, "mass of the device's own end effector (assumed)") \
    X(real, rotor_inertia, "kg.m2", 6.99e-6, 2e-6, "inertia of each motor's rotor (Quanser: published; Haply: assumed)") \
    X(real, gear_ratio, "1", 1.0, 1.0, "motor turns per joint turn (published: direct drive)") \
    X(real, coulomb_friction, "N.m", 3e-3, 4e-3, "Coulomb friction torque of each joint (assumed)") \
    X(real, viscous_friction, "N.m.s/rad", 1e-5, 1e-5, "viscous friction of each joint (assumed)") \
    X(real, torque_constant, "N.m/A", 0.0364, 0.06, "motor torque constant K_t (Quanser: published; Haply: assumed)") \
    X(real, amplifier_gain, "A/V", 0.5, 3.0, "amplifier gain (Quanser: published; Haply: assumed, per unit of duty)") \
    X(real, amplifier_bandwidth, "Hz", 2000.0, 0.0, "first-order bandwidth of the current amplifier (assumed); 0: ideal") \
    X(real, current_limit, "A", 7.0, 0.0, "saturation of the amplifier (assumed); 0: none") \
    X(real, dac_range, "V", 10.0, 1.0, "the DAC reaches from minus to plus this (Quanser: published; Haply: duty cycle); 0: unlimited and not quantised") \
    X(integer, dac_bits, "1", 16, 12, "resolution of the DAC or PWM over its whole range (published); 0: ideal, not quantised") \
    X(real, torque_limit, "N.m", 0.255, 0.18, "limit of the commanded joint torque (assumed); 0: none") \
    X(real, joint_minimum, "rad", 1.4835298641951802, 1.4835298641951802, "lower mechanical stop of joint 1; joint 2 is its mirror image (assumed)") \
    X(real, joint_maximum, "rad", 3.490658503988659, 3.2288591161895095, "upper mechanical stop of joint 1; joint 2 is its mirror image (assumed)")

#define DEVICE_FIELD_real(name) double name;
#define DEVICE_FIELD_integer(name) int64_t name;
#define DEVICE_FIELD(type, name, unit, quanser, haply, description) DEVICE_FIELD_##type(name)

typedef struct {
    DEVICE_GEOMETRY(DEVICE_FIELD)
} DeviceGeometry;

typedef struct {
    DEVICE_DYNAMICS(DEVICE_FIELD)
} DeviceDynamics;

/* Replace one given value by its preset where it is negative; a custom device has none. The
 * enumeration Device is the model's (fmus/shared/mechanism/device.py). */
#define DEVICE_RESOLVE(type, name, unit, quanser, haply, description) \
    target->name = source->name; \
    if (source->name < 0) { \
        target->name = device == DEVICE_HAPLY ? haply : quanser; \
        if (device == DEVICE_CUSTOM && !missing) missing = #name; \
    }

/* Fill *target from the variables *source (any struct with the fields); evaluates to the name of
 * the first parameter that a custom device left open, or to a null pointer. */
#define DEVICE_RESOLVE_ALL(LIST, target_pointer, source_pointer, device_value) \
    __extension__({ \
        __typeof__(target_pointer) target = (target_pointer); \
        __typeof__(source_pointer) source = (source_pointer); \
        const int64_t device = (device_value); \
        const char *missing = 0; \
        LIST(DEVICE_RESOLVE) \
        missing; \
    })

#endif
