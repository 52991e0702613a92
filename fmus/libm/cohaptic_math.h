/* The mathematics that models may use: the same bits on every platform.

   The functions are musl's (COPYRIGHT beside this file), compiled by us with contraction off, under
   prefixed names so that a host's libm can neither replace them nor be replaced. What the
   hardware rounds correctly by itself (sqrt, fabs, copysign) is inline. */
#ifndef COHAPTIC_MATH_H
#define COHAPTIC_MATH_H

#define sin cohaptic_sin
#define cos cohaptic_cos
#define tan cohaptic_tan
#define asin cohaptic_asin
#define acos cohaptic_acos
#define atan cohaptic_atan
#define atan2 cohaptic_atan2
#define tanh cohaptic_tanh
#define exp cohaptic_exp
#define expm1 cohaptic_expm1
#define log cohaptic_log
#define pow cohaptic_pow
#define fmod cohaptic_fmod
#define hypot cohaptic_hypot
#define scalbn cohaptic_scalbn
#define floor cohaptic_floor
#define ceil cohaptic_ceil
#define round cohaptic_round
#define trunc cohaptic_trunc
#define sqrt cohaptic_sqrt
#define fabs cohaptic_fabs
#define copysign cohaptic_copysign
#define fmin cohaptic_fmin
#define fmax cohaptic_fmax

double sin(double), cos(double), tan(double);
double asin(double), acos(double), atan(double), atan2(double y, double x);
double tanh(double), exp(double), expm1(double), log(double), pow(double, double);
double fmod(double, double), hypot(double, double), scalbn(double, int);
double floor(double), ceil(double), round(double), trunc(double);

static inline double sqrt(double x) { return __builtin_sqrt(x); }
static inline double fabs(double x) { return __builtin_fabs(x); }
static inline double copysign(double x, double sign) { return __builtin_copysign(x, sign); }

/* As C99: a NaN loses against a number. Of -0 and +0 the first argument is returned. */
static inline double fmin(double x, double y) { return y < x || x != x ? y : x; }
static inline double fmax(double x, double y) { return y > x || x != x ? y : x; }

#undef M_PI
#undef INFINITY
#undef NAN
#undef isnan
#undef isinf
#undef isfinite
#undef signbit
#define M_PI 3.14159265358979323846
#define INFINITY __builtin_inf()
#define NAN __builtin_nan("")
#define isnan(x) __builtin_isnan(x)
#define isinf(x) __builtin_isinf(x)
#define isfinite(x) __builtin_isfinite(x)
#define signbit(x) __builtin_signbit(x)

#endif
