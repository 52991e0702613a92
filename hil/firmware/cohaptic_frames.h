/* Frames of cohaptic's serial protocols: COBS with a checksum (CRC-16/CCITT-FALSE, high byte first), and a
 * zero byte at the end. Described in hil/wire/cobs_frames.py.
 */
#ifndef COHAPTIC_FRAMES_H
#define COHAPTIC_FRAMES_H

#include <stddef.h>
#include <stdint.h>

static inline uint16_t crc16(const uint8_t *data, size_t length) {
    uint16_t crc = 0xFFFF;
    for (size_t i = 0; i < length; i++) {
        crc ^= (uint16_t)(data[i] << 8);
        for (int bit = 0; bit < 8; bit++) {
            crc = (uint16_t)(crc & 0x8000 ? (crc << 1) ^ 0x1021 : crc << 1);
        }
    }
    return crc;
}

static inline void copy(void *to, const void *from, size_t length) {
    for (size_t i = 0; i < length; i++) ((uint8_t *)to)[i] = ((const uint8_t *)from)[i];
}

/* Returns the plain length, 0 where the bytes cannot have been stuffed. */
static inline size_t unstuff(const uint8_t *data, size_t length, uint8_t *plain) {
    size_t place = 0, written = 0;
    while (place < length) {
        size_t size = data[place];
        if (size == 0 || place + size > length) return 0;
        for (size_t i = 1; i < size; i++) plain[written++] = data[place + i];
        place += size;
        if (place < length) plain[written++] = 0;
    }
    return written;
}

static inline size_t stuff(const uint8_t *plain, size_t length, uint8_t *out) {
    size_t code = 0, written = 1;
    for (size_t i = 0; i < length; i++) {
        if (plain[i] == 0) {
            out[code] = (uint8_t)(written - code);
            code = written++;
        } else {
            out[written++] = plain[i];
        }
    }
    out[code] = (uint8_t)(written - code);
    out[written++] = 0;
    return written;
}

/* Adds the checksum behind `length` bytes, for which `plain` has room, and stuffs all of it. */
static inline size_t sealed(uint8_t *plain, size_t length, uint8_t *out) {
    uint16_t crc = crc16(plain, length);
    plain[length] = (uint8_t)(crc >> 8);
    plain[length + 1] = (uint8_t)crc;
    return stuff(plain, length + 2, out);
}

/* Whether the last two of `length` bytes are the checksum of the others. */
static inline int is_whole(const uint8_t *plain, size_t length) {
    return length > 2 && crc16(plain, length - 2) == (uint16_t)(plain[length - 2] << 8 | plain[length - 1]);
}

#endif
