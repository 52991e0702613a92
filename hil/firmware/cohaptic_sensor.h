/* Reference of a board that measures force and pushes nothing, for sensors of your own making.
 *
 * Plain C11, no allocation, no operating system. You bring the clock and the converters:
 *
 *   sensor_init(&sensor, channels, serial);
 *   for (;;) {
 *       if (converted) sensor_sample(&sensor, counts, ends);      // as often as they convert
 *       if (supply_is_low) sensor_report(&sensor, SENSOR_BROWN_OUT);
 *       size_t n = sensor_receive(&sensor, byte, now_us, reply);  // a byte at a time
 *       if (n) usb_write(reply, n);                               // a whole question was answered
 *   }
 *
 * The frames are described in hil/drivers/force_sensor/protocol.py. What was reported, and channels that
 * stood at the end of their range, are told in the next answer, however short it was.
 */
#ifndef COHAPTIC_SENSOR_H
#define COHAPTIC_SENSOR_H

#include <stddef.h>
#include <stdint.h>

#define SENSOR_MOST_CHANNELS 6
#define SENSOR_REPLY_BYTES 40
#define SENSOR_LONGEST_FRAME 16

enum { SENSOR_BROWN_OUT = 1, SENSOR_FAULT = 2 };

typedef struct {
    int32_t counts[SENSOR_MOST_CHANNELS]; /* the newest ones */
    uint32_t serial;
    uint8_t channels;
    uint8_t status;   /* since the last answer */
    uint8_t clipped;  /* channels at the end of their range since the last answer, a bit each */
    uint8_t overflow; /* the present frame is too long to be a question */
    uint8_t length;
    uint8_t pending[SENSOR_LONGEST_FRAME];
} Sensor;

void sensor_init(Sensor *sensor, uint8_t channels, uint32_t serial);

/* New counts of every channel; `ends` are those (of either sign) at which its range ends. */
void sensor_sample(Sensor *sensor, const int32_t *counts, const int32_t *ends);

/* Something is wrong: SENSOR_BROWN_OUT or SENSOR_FAULT, told in the next answer. */
void sensor_report(Sensor *sensor, uint8_t what);

/* Take one byte. Returns the length of the reply that was written to `reply`, 0 for none. */
size_t sensor_receive(Sensor *sensor, uint8_t byte, uint32_t now_us, uint8_t reply[SENSOR_REPLY_BYTES]);

#endif
