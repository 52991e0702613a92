/* The pieces below the FMI functions, for tests: numbers, sentences, mathematics. */
#include "platform.h"
#include "report.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

EXPORT int probe_parse(const char *text, double *value);
EXPORT const char *probe_format(const char *text, int integer, double number);
EXPORT const char *probe_table(const char *path, size_t columns, size_t capacity, double *rows,
                               size_t *count);
EXPORT double probe_unary(int function, double x);
EXPORT double probe_binary(int function, double x, double y);
EXPORT uint64_t probe_hash(int function);

static struct Report report;

/* How many characters were a number; 0 where there is none. */
int probe_parse(const char *text, double *value)
{
    const char *end = text;
    return parse_number(&end, value) ? (int)(end - text) : 0;
}

const char *probe_format(const char *text, int integer, double number)
{
    return report_format(&report, "%s|%d|%g|%%", text, integer, number);
}

const char *probe_table(const char *path, size_t columns, size_t capacity, double *rows,
                        size_t *count)
{
    return report_read_table(&report, path, columns, capacity, rows, count);
}

typedef double Unary(double);
typedef double Binary(double, double);

static double apply_sqrt(double x) { return sqrt(x); }
static double apply_fabs(double x) { return fabs(x); }
static double apply_fmin(double x, double y) { return fmin(x, y); }
static double apply_fmax(double x, double y) { return fmax(x, y); }
static double apply_copysign(double x, double y) { return copysign(x, y); }

static Unary *const unary[] = {sin,  cos,   tan, asin,  acos, atan,  tanh,       exp,
                               expm1, log, floor, ceil, round, trunc, apply_sqrt, apply_fabs};
static Binary *const binary[] = {atan2, pow, fmod, hypot, apply_fmin, apply_fmax, apply_copysign};

enum { UNARY = sizeof unary / sizeof *unary };

double probe_unary(int function, double x) { return unary[function](x); }

double probe_binary(int function, double x, double y) { return binary[function](x, y); }

static uint64_t state;

static double next(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(int64_t)state * 0x1p-63;
}

/* FNV-1a over the bits of 20000 results; arguments of many sizes from a fixed generator. */
uint64_t probe_hash(int function)
{
    uint64_t hash = 0xcbf29ce484222325u;
    state = (uint64_t)function + 1;
    for (int i = 0; i < 20000; ++i) {
        const double size = scalbn(1.0, i % 24 - 8);
        const double x = next() * size, y = next() * size;
        const double bounded = function == 3 || function == 4 ? x / size : x;
        const double positive = function == 9 || function == 14 || function == UNARY + 1
                                    ? fabs(bounded)
                                    : bounded;
        double result = function < UNARY ? unary[function](positive)
                                         : binary[function - UNARY](positive, y);
        if (isnan(result))
            result = 0.0; /* the bits of a NaN are the processor's */
        uint64_t bits;
        memcpy(&bits, &result, 8);
        hash = (hash ^ bits) * 0x100000001b3u;
    }
    return hash;
}

#ifdef PROBE_STANDALONE
#if defined(__aarch64__)
static void leave(void)
{
    register long x8 __asm__("x8") = 93;
    register long x0 __asm__("x0") = 0;
    __asm__ volatile("svc 0" : : "r"(x8), "r"(x0));
}
static void print(const char *text, long length)
{
    register long x8 __asm__("x8") = 64;
    register long x0 __asm__("x0") = 1;
    register long x1 __asm__("x1") = (long)text;
    register long x2 __asm__("x2") = length;
    __asm__ volatile("svc 0" : "+r"(x0) : "r"(x8), "r"(x1), "r"(x2) : "memory");
}
#endif

void _start(void)
{
    for (int function = 0; function < UNARY + 7; ++function) {
        char line[17];
        uint64_t hash = probe_hash(function);
        for (int i = 15; i >= 0; --i, hash >>= 4)
            line[i] = "0123456789abcdef"[hash & 15];
        line[16] = '\n';
        print(line, 17);
    }
    leave();
}
#endif
