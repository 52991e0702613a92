#include "cohaptic_sensor.h"

#include "cohaptic_frames.h"

enum { ASK = 0x02, WHO = 0x03, ANSWER = 0x82, IDENTITY = 0x83, VERSION = 1 };
enum { QUESTION_BYTES = 6, ANSWER_HEAD = 10, IDENTITY_BYTES = 10 }; /* the question with its checksum */

void sensor_init(Sensor *sensor, uint8_t channels, uint32_t serial) {
    for (size_t i = 0; i < sizeof *sensor; i++) ((uint8_t *)sensor)[i] = 0;
    sensor->channels = channels < SENSOR_MOST_CHANNELS ? channels : SENSOR_MOST_CHANNELS;
    sensor->serial = serial;
}

void sensor_sample(Sensor *sensor, const int32_t *counts, const int32_t *ends) {
    for (uint8_t i = 0; i < sensor->channels; i++) {
        sensor->counts[i] = counts[i];
        if (counts[i] >= ends[i] || counts[i] <= -ends[i]) sensor->clipped |= (uint8_t)(1u << i);
    }
}

void sensor_report(Sensor *sensor, uint8_t what) { sensor->status |= what; }

static size_t measured(Sensor *sensor, const uint8_t *question, uint32_t now_us, uint8_t *reply) {
    uint8_t plain[ANSWER_HEAD + 4 * SENSOR_MOST_CHANNELS + 2] = {ANSWER, sensor->status};
    size_t size = 4u * sensor->channels;
    plain[2] = question[2];
    plain[3] = question[3];
    copy(plain + 4, &now_us, 4);
    plain[8] = sensor->clipped;
    plain[9] = sensor->channels;
    copy(plain + ANSWER_HEAD, sensor->counts, size);
    sensor->status = sensor->clipped = 0;
    return sealed(plain, ANSWER_HEAD + size, reply);
}

static size_t named(const Sensor *sensor, const uint8_t *question, uint8_t *reply) {
    uint8_t plain[IDENTITY_BYTES + 2] = {IDENTITY, sensor->channels, question[2], question[3], VERSION};
    copy(plain + 6, &sensor->serial, 4);
    return sealed(plain, IDENTITY_BYTES, reply);
}

size_t sensor_receive(Sensor *sensor, uint8_t byte, uint32_t now_us, uint8_t reply[SENSOR_REPLY_BYTES]) {
    if (byte != 0) {
        if (sensor->length == SENSOR_LONGEST_FRAME) sensor->overflow = 1;
        else sensor->pending[sensor->length++] = byte;
        return 0;
    }
    uint8_t plain[SENSOR_LONGEST_FRAME];
    size_t length = sensor->overflow ? 0 : unstuff(sensor->pending, sensor->length, plain);
    sensor->length = sensor->overflow = 0;
    if (length != QUESTION_BYTES || !is_whole(plain, length)) return 0;
    if (plain[0] == ASK) return measured(sensor, plain, now_us, reply);
    if (plain[0] == WHO) return named(sensor, plain, reply);
    return 0;
}
