/* The logger callbacks: FMI 2.0's is variadic, so it has to be C.

   An FMU may call them at any time, from any thread, with anything for an environment: that pointer
   is looked up among the logs that are open and never followed. */

#include "kernel.h"

#include <stdarg.h>

static Log *first;
static bool is_locked;

static char stray_text[2048], stray_grave[2048];
static Log stray = {stray_text, stray_grave, 2048, 0, 0, 0, 0};

/* A message on its way into one of the two texts of a log. It takes a quarter of the room at most: of
   a longer one the beginning is kept. */
typedef struct {
    char *text;
    int64_t capacity;
    int64_t *used;
    int64_t left; /* characters; below 0 some were left out */
} Line;

static void lock(void)
{
    while (__atomic_test_and_set(&is_locked, __ATOMIC_ACQUIRE))
        ;
}

static void unlock(void)
{
    __atomic_clear(&is_locked, __ATOMIC_RELEASE);
}

/* Drops the older half, in whole messages. */
static void make_room(Line *line)
{
    int64_t from = line->capacity / 2;
    while (from < line->capacity && line->text[from - 1] != '\n')
        from++;
    for (int64_t i = from; i < line->capacity; i++)
        line->text[i - from] = line->text[i];
    *line->used = line->capacity - from;
}

static void put_raw(Line *line, char c)
{
    if (*line->used == line->capacity)
        make_room(line);
    line->text[(*line->used)++] = c;
}

static void put(Line *line, char c)
{
    if (--line->left >= 0)
        put_raw(line, c == '\n' || c == '\r' ? ' ' : c);
}

/* At most `most` characters; what follows them may not be there. */
static void put_part(Line *line, const char *text, int64_t most)
{
    if (!text)
        text = "(null)";
    for (int64_t i = 0; i < most && line->left >= 0 && text[i]; i++)
        put(line, text[i]);
}

static void put_text(Line *line, const char *text)
{
    put_part(line, text, INT64_MAX);
}

static void put_integer(Line *log, uint64_t value, unsigned base, int least_digits)
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

static void put_signed(Line *log, int64_t value)
{
    if (value < 0)
        put(log, '-');
    put_integer(log, value < 0 ? 0 - (uint64_t)value : (uint64_t)value, 10, 1);
}

/* Nine significant digits: a message for a person, not a value to read back. */
static void put_real(Line *log, double value)
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

/* printf's conversions. Flags and width are read over, and so is the precision of all but text, which
   may end with it. A pointer is followed for %s alone. */
static void put_format(Line *log, const char *format, va_list *arguments)
{
    for (const char *c = format; *c; c++) {
        if (*c != '%') {
            put(log, *c);
            continue;
        }
        int64_t most = -1; /* as printf, where a negative precision is none */
        for (c++; *c && is_one_of(*c, "-+ #0123456789.*"); c++) {
            if (*c == '.')
                most = 0;
            else if (*c == '*' && most == 0)
                most = va_arg(*arguments, int);
            else if (*c == '*')
                (void)va_arg(*arguments, int);
            else if (most >= 0 && *c >= '0' && *c <= '9')
                most = most * 10 + (*c - '0');
        }
        if (most < 0)
            most = INT64_MAX;
        bool is_long_double = false;
        int longs = 0;
        for (; *c && is_one_of(*c, "hlzjtL"); c++)
            longs += *c == 'l' ? 1 : is_one_of(*c, "zjt") ? 2 : 0, is_long_double |= *c == 'L';
        bool wide = longs > 1 || (longs == 1 && sizeof(long) == 8);
        switch (*c) {
        case 'd':
        case 'i':
            put_signed(log, wide ? va_arg(*arguments, int64_t) : va_arg(*arguments, int));
            break;
        case 'u':
        case 'o':
        case 'x':
        case 'X':
            put_integer(log,
                        wide ? va_arg(*arguments, uint64_t) : va_arg(*arguments, unsigned),
                        *c == 'u' ? 10 : *c == 'o' ? 8 : 16, 1);
            break;
        case 'f':
        case 'F':
        case 'e':
        case 'E':
        case 'g':
        case 'G':
        case 'a':
        case 'A':
            put_real(log, is_long_double ? (double)va_arg(*arguments, long double)
                                         : va_arg(*arguments, double));
            break;
        case 's': {
            const char *text = va_arg(*arguments, const char *);
            put_part(log, longs ? "(wide text)" : text, longs ? INT64_MAX : most);
            break;
        }
        case 'n': /* would write through the pointer */
            (void)va_arg(*arguments, void *);
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

EXPORT void kernel_log_open(Log *log)
{
    lock();
    if (!first) /* what stray messages of earlier runs there are is nobody's any more */
        stray.used = stray.grave_used = 0;
    log->next = first;
    first = log;
    unlock();
}

EXPORT void kernel_log_close(Log *log)
{
    lock();
    Log *before = 0;
    for (Log *each = first; each; before = each, each = each->next) {
        if (each != log)
            continue;
        if (before)
            before->next = each->next;
        else
            first = each->next;
        break;
    }
    unlock();
}

/* Where messages go whose environment is of no log that is open. */
EXPORT Log *kernel_log_stray(void)
{
    return &stray;
}

/* Begins a message; the lock is held until it ends. */
static Line begin(const void *environment, int status, Log **found)
{
    lock();
    Log *log = first;
    while (log && log != environment)
        log = log->next;
    *found = log = log ? log : &stray;
    const int64_t most = log->capacity / 4;
    if (status == STATUS_OK)
        return (Line){log->text, log->capacity, &log->used, most};
    Line line = {log->grave, log->capacity, &log->grave_used, most};
    put(&line, (char)('0' + (status > 0 && status < 10 ? status : 9)));
    return line;
}

/* A character of several bytes is not left in half. */
static void show_cut(Line *line)
{
    for (int i = 0; i < 3 && (line->text[*line->used - 1] & 0xc0) == 0x80; i++)
        --*line->used;
    if (line->text[*line->used - 1] & 0x80)
        --*line->used;
    for (const char *c = " (\xe2\x80\xa6)"; *c; c++)
        put_raw(line, *c);
}

static void end(Line *line, Log *log)
{
    if (line->left < 0)
        show_cut(line);
    put_raw(line, '\n');
    log->messages++;
    unlock();
}

EXPORT void kernel_log_fmi2(void *environment, const char *instance, int status,
                            const char *category, const char *message, ...)
{
    (void)instance;
    (void)category;
    if (!message)
        return;
    Log *log;
    Line line = begin(environment, status, &log);
    va_list arguments;
    va_start(arguments, message);
    put_format(&line, message, &arguments);
    va_end(arguments);
    end(&line, log);
}

EXPORT void kernel_log_fmi3(void *environment, int status, const char *category,
                            const char *message)
{
    (void)category;
    if (!message)
        return;
    Log *log;
    Line line = begin(environment, status, &log);
    put_text(&line, message);
    end(&line, log);
}
