#include "cohaptic_device.h"

#include "cohaptic_frames.h"

enum { COMMAND = 0x01, REPLY = 0x81, COMMAND_BYTES = 16, REPLY_PLAIN = 20 }; /* with their checksums */
static const uint16_t LONGEST_WATCHDOG_MS = 100;

/* A number that is none, or larger than any motor here can give, is no torque. */
static int is_torque(float value) { return value > -10.0f && value < 10.0f; }

static void stop(Device *device) { device->torque[0] = device->torque[1] = 0.0f; }

void device_init(Device *device) {
    for (size_t i = 0; i < sizeof *device; i++) ((uint8_t *)device)[i] = 0;
}

static int take(Device *device, const uint8_t *plain, uint32_t now_us) {
    float torque[2];
    copy(torque, plain + 4, sizeof torque);
    if (!is_torque(torque[0]) || !is_torque(torque[1])) return 0;
    uint8_t flags = plain[1];
    uint16_t watchdog = (uint16_t)(plain[12] | plain[13] << 8);
    if (watchdog == 0 || watchdog > LONGEST_WATCHDOG_MS) watchdog = LONGEST_WATCHDOG_MS;
    device->watchdog_ms = watchdog;
    device->last_command_us = now_us;
    if (flags & DEVICE_CLEAR) device->fired = 0;
    device->enabled = (flags & DEVICE_ENABLE) && !device->fired;
    if (device->enabled) {
        device->torque[0] = torque[0];
        device->torque[1] = torque[1];
    } else {
        stop(device);
    }
    return 1;
}

static size_t answer(const Device *device, const uint8_t *command, uint32_t now_us,
                     const int32_t count[2], uint8_t *reply) {
    uint8_t plain[REPLY_PLAIN] = {REPLY};
    int zero = device->torque[0] == 0.0f && device->torque[1] == 0.0f;
    plain[1] = (uint8_t)((device->enabled ? DEVICE_ENABLED : 0) |
                         (device->fired ? DEVICE_WATCHDOG_FIRED : 0) | (zero ? DEVICE_ZERO : 0) |
                         (device->input ? DEVICE_INPUT : 0));
    plain[2] = command[2];
    plain[3] = command[3];
    copy(plain + 4, &now_us, 4);
    copy(plain + 8, count, 8);
    return sealed(plain, REPLY_PLAIN - 2, reply);
}

size_t device_receive(Device *device, uint8_t byte, uint32_t now_us, const int32_t count[2],
                      uint8_t reply[DEVICE_REPLY_BYTES]) {
    device_tick(device, now_us);
    if (byte != 0) {
        if (device->length == DEVICE_LONGEST_FRAME) device->overflow = 1;
        else device->pending[device->length++] = byte;
        return 0;
    }
    uint8_t plain[DEVICE_LONGEST_FRAME];
    size_t length = device->overflow ? 0 : unstuff(device->pending, device->length, plain);
    device->length = device->overflow = 0;
    if (length != COMMAND_BYTES || plain[0] != COMMAND) return 0;
    if (!is_whole(plain, length) || !take(device, plain, now_us)) return 0;
    return answer(device, plain, now_us, count, reply);
}

void device_tick(Device *device, uint32_t now_us) {
    if (device->watchdog_ms == 0 || device->fired) return;
    /* Signed: a command that came in an interrupt may be newer than the clock that was read. */
    if ((int32_t)(now_us - device->last_command_us) > 1000 * (int32_t)device->watchdog_ms) {
        device->fired = device->enabled;
        device->enabled = 0;
        stop(device);
    }
}
