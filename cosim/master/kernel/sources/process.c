/* What an FMU may do to its process. How the processor computes (rounding, denormals, traps) is put
   back by whoever called, so that neither our own arithmetic nor another FMU's depends on it. The
   end of the process by exit() is told. */

#include "kernel.h"

#if defined(__x86_64__)
/* The exceptions that have been met are no mode. */
enum { MXCSR_MODE = 0xffc0 };

EXPORT int64_t kernel_float_mode(void)
{
    uint32_t sse;
    uint16_t x87;
    __asm__ volatile("stmxcsr %0" : "=m"(sse));
    __asm__ volatile("fnstcw %0" : "=m"(x87));
    return (int64_t)(sse & MXCSR_MODE) | (int64_t)x87 << 32;
}

static void set_mode(int64_t mode)
{
    uint32_t sse = (uint32_t)mode & MXCSR_MODE;
    uint16_t x87 = (uint16_t)(mode >> 32);
    __asm__ volatile("fnclex"); /* or a trap that is switched on again would come at once */
    __asm__ volatile("fldcw %0" : : "m"(x87));
    __asm__ volatile("ldmxcsr %0" : : "m"(sse));
}
#elif defined(__aarch64__)
EXPORT int64_t kernel_float_mode(void)
{
    int64_t mode;
    __asm__ volatile("mrs %0, fpcr" : "=r"(mode));
    return mode;
}

static void set_mode(int64_t mode)
{
    __asm__ volatile("msr fpcr, %0" : : "r"(mode));
}
#else
EXPORT int64_t kernel_float_mode(void)
{
    return 0;
}

static void set_mode(int64_t mode)
{
    (void)mode;
}
#endif

/* Whether it had to be put back. */
EXPORT int64_t kernel_restore_float_mode(int64_t mode)
{
    if (kernel_float_mode() == mode)
        return 0;
    set_mode(mode);
    return 1;
}

static void (*said)(void);

/* What is called when the process ends by exit(), and before that what was to be; 0: nothing. */
EXPORT void *kernel_on_leaving(void (*say)(void))
{
    void (*before)(void) = said;
    said = say;
    return (void *)before;
}

/* For the C library's list of what is called then. */
EXPORT void kernel_leaving(void *unused)
{
    void (*say)(void) = said;
    (void)unused;
    said = 0;
    if (say)
        say();
}
