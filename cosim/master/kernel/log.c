/* The logger callbacks: FMI 2.0's is variadic, so it has to be C. */

#include "kernel.h"

#include <stdarg.h>

static void put(Log *log, char c)
{
    if (log->used == log->capacity) {
        int64_t half = log->capacity / 2;
        for (int64_t i = half; i < log->capacity; i++)
            log->text[i - half] = log->text[i];
        log->used = log->capacity - half;
    }
    log->text[log->used++] = c;
}

static void put_text(Log *log, const char *text)
{
    for (const char *c = text ? text : "(null)"; *c; c++)
        put(log, *c);
}

static void put_integer(Log *log, uint64_t value, unsigned base, int least_digits)
{
    char digits[64];
    int count = 0;
    do {
        digits[count++] = "0123456789abcdef"[value % base];
        value /= base;
    } while (value);
    while (count < least_digits)
        digits[count++] = '0';
    while (count)
        put(log, digits[--count]);
}

static void put_signed(Log *log, int64_t value)
{
    if (value < 0)
        put(log, '-');
    put_integer(log, value < 0 ? 0 - (uint64_t)value : (uint64_t)value, 10, 1);
}

/* Nine significant digits: a message for a person, not a value to read back. */
static void put_real(Log *log, double value)
{
    if (value != value) {
        put_text(log, "nan");
        return;
    }
    if (value < 0) {
        put(log, '-');
        value = -value;
    }
    if (value > 1.7976931348623157e308) {
        put_text(log, "inf");
        return;
    }
    int exponent = 0;
    if (value != 0 && (value >= 1e9 || value < 1e-4)) {
        for (; value >= 10; exponent++)
            value /= 10;
        for (; value < 1; exponent--)
            value *= 10;
    }
    uint64_t scale = 1000000000;
    for (double top = value; top >= 10 && scale > 10; top /= 10)
        scale /= 10;
    uint64_t scaled = (uint64_t)(value * (double)scale + 0.5);
    put_integer(log, scaled / scale, 10, 1);
    uint64_t fraction = scaled % scale;
    if (fraction) {
        put(log, '.');
        while (fraction) {
            scale /= 10;
            put(log, (char)('0' + fraction / scale));
            fraction %= scale;
        }
    }
    if (exponent) {
        put(log, 'e');
        put_signed(log, exponent);
    }
}

static bool is_one_of(char c, const char *set)
{
    for (; *set; set++)
        if (*set == c)
            return true;
    return false;
}

/* printf's conversions; flags, width and precision are read over. */
static void put_format(Log *log, const char *format, va_list *arguments)
{
    for (const char *c = format; *c; c++) {
        if (*c != '%') {
            put(log, *c);
            continue;
        }
        for (c++; *c && is_one_of(*c, "-+ #0123456789.*"); c++)
            if (*c == '*')
                (void)va_arg(*arguments, int);
        int longs = 0;
        for (; *c && is_one_of(*c, "hlzjtL"); c++)
            longs += *c == 'l' ? 1 : is_one_of(*c, "zjt") ? 2 : 0;
        bool wide = longs > 1 || (longs == 1 && sizeof(long) == 8);
        switch (*c) {
        case 'd':
        case 'i':
            put_signed(log, wide ? va_arg(*arguments, int64_t) : va_arg(*arguments, int));
            break;
        case 'u':
        case 'x':
        case 'X':
            put_integer(log,
                        wide ? va_arg(*arguments, uint64_t) : va_arg(*arguments, unsigned),
                        *c == 'u' ? 10 : 16, 1);
            break;
        case 'f':
        case 'F':
        case 'e':
        case 'E':
        case 'g':
        case 'G':
            put_real(log, va_arg(*arguments, double));
            break;
        case 's':
            put_text(log, va_arg(*arguments, const char *));
            break;
        case 'c':
            put(log, (char)va_arg(*arguments, int));
            break;
        case 'p':
            put_text(log, "0x");
            put_integer(log, (uint64_t)(uintptr_t)va_arg(*arguments, void *), 16, 1);
            break;
        case '\0':
            return;
        default:
            put(log, *c);
        }
    }
}

EXPORT void kernel_log_fmi2(void *environment, const char *instance, int status,
                            const char *category, const char *message, ...)
{
    Log *log = environment;
    (void)instance;
    (void)status;
    (void)category;
    if (!log || !message)
        return;
    va_list arguments;
    va_start(arguments, message);
    put_format(log, message, &arguments);
    va_end(arguments);
    put(log, '\n');
    log->messages++;
}

EXPORT void kernel_log_fmi3(void *environment, int status, const char *category,
                            const char *message)
{
    Log *log = environment;
    (void)status;
    (void)category;
    if (!log || !message)
        return;
    put_text(log, message);
    put(log, '\n');
    log->messages++;
}
