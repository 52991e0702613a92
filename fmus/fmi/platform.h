/* The few things that the glue needs from an operating system, without a C library. */
#ifndef COHAPTIC_PLATFORM_H
#define COHAPTIC_PLATFORM_H

#include <stddef.h>
#include <stdint.h>

/* Zeroed memory, or NULL. */
void *platform_allocate(size_t bytes);
void platform_free(void *memory, size_t bytes);

/* Files are read only, from start to end. A handle below zero means that it could not be opened;
   platform_read returns 0 at the end and a negative number on an error. */
intptr_t platform_open(const char *utf8_path);
intptr_t platform_read(intptr_t file, char *buffer, size_t capacity);
void platform_close(intptr_t file);

#ifndef COHAPTIC_HOSTED
void *memcpy(void *restrict to, const void *restrict from, size_t bytes);
void *memmove(void *to, const void *from, size_t bytes);
void *memset(void *to, int value, size_t bytes);
int memcmp(const void *a, const void *b, size_t bytes);
#else
#include <string.h>
#endif

#endif
