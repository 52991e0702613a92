/* What a compiler may call behind our back, and what Windows wants of a library without a CRT. */

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t count)
{
    unsigned char *target = to;
    const unsigned char *source = from;
    while (count--) {
        *target++ = *source++;
        __asm__ volatile("" ::: "memory"); /* keeps the loop from becoming a call to itself */
    }
    return to;
}

void *memmove(void *to, const void *from, size_t count)
{
    unsigned char *target = to;
    const unsigned char *source = from;
    if (target < source)
        return memcpy(to, from, count);
    while (count--) {
        target[count] = source[count];
        __asm__ volatile("" ::: "memory");
    }
    return to;
}

void *memset(void *to, int value, size_t count)
{
    unsigned char *target = to;
    while (count--) {
        *target++ = (unsigned char)value;
        __asm__ volatile("" ::: "memory");
    }
    return to;
}

#if defined(_WIN32)
int _fltused = 0;

int __stdcall DllMainCRTStartup(void *module, unsigned long reason, void *reserved)
{
    (void)module;
    (void)reason;
    (void)reserved;
    return 1;
}
#endif
