/* Sentences without a C library: %s, %d and %g into a fixed buffer. */
#include "report.h"

typedef struct {
    char *text;
    size_t length;
} Writer;

static void put(Writer *w, char c)
{
    if (w->length + 1 < REPORT_CAPACITY)
        w->text[w->length++] = c;
}

static void put_text(Writer *w, const char *text)
{
    for (text = text != NULL ? text : "(none)"; *text != '\0'; ++text)
        put(w, *text);
}

static void put_integer(Writer *w, int64_t value)
{
    char digits[20];
    int count = 0;
    uint64_t rest = value < 0 ? -(uint64_t)value : (uint64_t)value;
    do {
        digits[count++] = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest > 0);
    if (value < 0)
        put(w, '-');
    while (count > 0)
        put(w, digits[--count]);
}

/* Nine significant digits without trailing zeros; good for messages, not for data. */
static void put_number(Writer *w, double value)
{
    enum { DIGITS = 9 };
    if (isnan(value)) {
        put_text(w, "NaN");
        return;
    }
    if (signbit(value))
        put(w, '-');
    value = fabs(value);
    if (isinf(value)) {
        put_text(w, "infinity");
        return;
    }
    int exponent = 0;
    char digits[DIGITS + 1] = "000000000";
    int count = 1;
    if (value > 0.0) {
        for (; value >= 1e9; ++exponent)
            value /= 10.0;
        for (; value < 1e8; --exponent)
            value *= 10.0;
        uint64_t rounded = (uint64_t)(value + 0.5);
        exponent += DIGITS - 1;
        if (rounded >= 1000000000u) {
            rounded /= 10;
            ++exponent;
        }
        for (int i = DIGITS - 1; i >= 0; --i, rounded /= 10)
            digits[i] = (char)('0' + rounded % 10);
        for (count = DIGITS; count > 1 && digits[count - 1] == '0';)
            --count;
    }
    const bool scientific = exponent < -5 || exponent >= DIGITS;
    const int point = scientific ? 0 : exponent; /* the digit that the decimal point follows */
    if (point < 0) {
        put_text(w, "0.");
        for (int i = point + 1; i < 0; ++i)
            put(w, '0');
    }
    for (int i = 0; i < count || i <= point; ++i) {
        put(w, i < count ? digits[i] : '0');
        if (i == point && i + 1 < count)
            put(w, '.');
    }
    if (scientific) {
        put(w, 'e');
        put_integer(w, exponent);
    }
}

const char *report_format_list(Report *r, const char *format, va_list arguments)
{
    Writer w = {r->text, 0};
    for (; *format != '\0'; ++format) {
        if (*format != '%') {
            put(&w, *format);
            continue;
        }
        switch (*++format) {
        case 's':
            put_text(&w, va_arg(arguments, const char *));
            break;
        case 'd':
            put_integer(&w, va_arg(arguments, int));
            break;
        case 'g':
            put_number(&w, va_arg(arguments, double));
            break;
        case '\0':
            --format;
            break;
        default:
            put(&w, *format);
        }
    }
    r->text[w.length] = '\0';
    return r->text;
}

const char *report_format(Report *r, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const char *text = report_format_list(r, format, arguments);
    va_end(arguments);
    return text;
}

void report_log(Report *r, const char *sentence)
{
    if (r->log != NULL)
        r->log(r->context, sentence);
}

void report_severity(Report *r, Severity severity) { r->severity = severity; }

bool report_outputs_are_current(const Report *r) { return r->outputs_are_current; }

double report_start_time(const Report *r) { return r->start_time; }
