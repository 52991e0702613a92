/* Two brushless motors under SimpleFOC as a cohaptic device, over the framed protocol: open it as cobs:///dev/ttyACM0.
 *
 * Put cohaptic_device.c, cohaptic_device.h and cohaptic_frames.h beside this file. SimpleFOC's own text
 * commander is not used:
 * it has no watchdog and no checksum, so one lost byte changes a torque and a dead host leaves it standing.
 * Change what stands between the two lines; then try it, motors' supply off first:
 *   cohaptic device conform cobs:///dev/ttyACM0 --file cobs.device.yaml
 */
#include <SimpleFOC.h>
extern "C" {
#include "cohaptic_device.h"
}

/* ---- your board --------------------------------------------------------------------------------------- */
const int POLE_PAIRS = 7;
const float SUPPLY = 12.0f;            /* V */
const float TORQUE_CONSTANT = 0.036f;  /* N.m/A, of both motors */
const float LARGEST_CURRENT = 3.0f;    /* A; the drivers' and the motors', whichever is less */
const long COUNTS = 16384;             /* counts_per_turn in the device file */
const int SWITCH_PIN = -1;             /* a switch to ground that a hand holds closed; -1: none */

BLDCMotor motors[2] = {BLDCMotor(POLE_PAIRS), BLDCMotor(POLE_PAIRS)};
BLDCDriver3PWM drivers[2] = {BLDCDriver3PWM(9, 10, 11, 8), BLDCDriver3PWM(5, 6, 3, 7)};
MagneticSensorSPI sensors[2] = {MagneticSensorSPI(AS5147_SPI, 4), MagneticSensorSPI(AS5147_SPI, 2)};
/* ------------------------------------------------------------------------------------------------------- */

static Device device;
static bool driven = true; /* so that the first pass switches the drivers off */

void setup() {
    Serial.begin(115200);
    device_init(&device);
    if (SWITCH_PIN >= 0) pinMode(SWITCH_PIN, INPUT_PULLUP);
    for (int i = 0; i < 2; i++) {
        sensors[i].init();
        motors[i].linkSensor(&sensors[i]);
        drivers[i].voltage_power_supply = SUPPLY;
        drivers[i].init();
        motors[i].linkDriver(&drivers[i]);
        motors[i].torque_controller = TorqueControlType::foc_current;
        motors[i].controller = MotionControlType::torque;
        motors[i].current_limit = LARGEST_CURRENT;
        motors[i].init();
        motors[i].initFOC();
    }
}

static int32_t counts_of(MagneticSensorSPI &sensor) {
    float turns = sensor.getAngle() / _2PI;
    return (int32_t)lroundf(turns * (float)COUNTS);
}

/* The stage is on only while the device says so: after a reset, a watchdog or a zero frame it is off. */
static void drive() {
    if ((bool)device.enabled != driven) {
        driven = device.enabled;
        for (int i = 0; i < 2; i++) driven ? motors[i].enable() : motors[i].disable();
    }
    for (int i = 0; i < 2; i++) {
        float current = driven ? device.torque[i] / TORQUE_CONSTANT : 0.0f;
        motors[i].move(_constrain(current, -LARGEST_CURRENT, LARGEST_CURRENT));
    }
}

void loop() {
    for (int i = 0; i < 2; i++) motors[i].loopFOC();
    device.input = SWITCH_PIN >= 0 && digitalRead(SWITCH_PIN) == LOW;
    while (Serial.available() > 0) {
        uint8_t reply[DEVICE_REPLY_BYTES];
        int32_t count[2] = {counts_of(sensors[0]), counts_of(sensors[1])};
        /* The clock is read after the byte: one that was read before would lie ahead of its own command. */
        uint8_t byte = (uint8_t)Serial.read();
        size_t size = device_receive(&device, byte, micros(), count, reply);
        drive();
        if (size) Serial.write(reply, size);
    }
    device_tick(&device, micros());
    drive();
}
