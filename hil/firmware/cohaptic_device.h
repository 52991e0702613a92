/* Reference of the device side of cohaptic's serial protocol, for boards of your own making.
 *
 * Plain C11, no allocation, no operating system. You bring the clock, the encoders and the motors:
 *
 *   device_init(&device);
 *   for (;;) {
 *       size_t n = device_receive(&device, byte, now_us, count, reply);   // a byte at a time
 *       if (n) usb_write(reply, n);             // a whole frame was answered
 *       device_tick(&device, now_us);           // at least every millisecond: the watchdog
 *       motors_set(device.torque[0], device.torque[1]);   // N.m; zero unless enabled and alive
 *   }
 *
 * The frames are described in hil/drivers/cobs/protocol.py. Set the motors from device.torque and from
 * nothing else: it is zero after a reset, without the enable flag, and when the watchdog has fired.
 */
#ifndef COHAPTIC_DEVICE_H
#define COHAPTIC_DEVICE_H

#include <stddef.h>
#include <stdint.h>

#define DEVICE_REPLY_BYTES 24
#define DEVICE_LONGEST_FRAME 64

enum { DEVICE_ENABLE = 1, DEVICE_CLEAR = 2 };
enum { DEVICE_ENABLED = 1, DEVICE_WATCHDOG_FIRED = 2, DEVICE_ZERO = 4, DEVICE_FAULT = 8, DEVICE_INPUT = 16 };

typedef struct {
    float torque[2];          /* what the motors have to do now, N.m */
    uint32_t last_command_us; /* when the last valid command came */
    uint16_t watchdog_ms;     /* 0: no command has armed it yet, and the torque is zero */
    uint8_t fired;            /* the watchdog has fired; only DEVICE_CLEAR takes that back */
    uint8_t enabled;
    uint8_t input;            /* set by you: the dead-man switch on the board is closed */
    uint8_t overflow;         /* the present frame is too long to be one */
    uint8_t length;
    uint8_t pending[DEVICE_LONGEST_FRAME];
} Device;

void device_init(Device *device);

/* Take one byte. Returns the length of the reply that was written to `reply`, 0 for none. */
size_t device_receive(Device *device, uint8_t byte, uint32_t now_us, const int32_t count[2],
                      uint8_t reply[DEVICE_REPLY_BYTES]);

/* Time has passed: fires the watchdog. Never interrupted by device_receive: where bytes are received in
 * an interrupt, mask it around this call. A clock that was read before the last command counts as none. */
void device_tick(Device *device, uint32_t now_us);

#endif
