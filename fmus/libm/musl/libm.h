/* The part of musl's src/internal/libm.h that double precision needs (MIT, see ../COPYRIGHT),
   with every internal name prefixed and fused multiply-add switched off on every platform. */
#ifndef COHAPTIC_MUSL_LIBM_H
#define COHAPTIC_MUSL_LIBM_H

#include <float.h>
#include <stdint.h>

#include "math.h"

/* arm64 announces fused multiply-add; using it there would give bits other than x86-64's. */
#undef __FP_FAST_FMA
#define __FP_FAST_FMA 0

#define WANT_ROUNDING 1
#define WANT_SNAN 0
#define issignaling_inline(x) 0
#define TOINT_INTRINSICS 0
#define hidden
#define predict_true(x) __builtin_expect(!!(x), 1)
#define predict_false(x) __builtin_expect(x, 0)

static inline double eval_as_double(double x) { return x; }

static inline double fp_barrier(double x)
{
	volatile double y = x;
	return y;
}

static inline void fp_force_eval(double x)
{
	volatile double y;
	y = x;
	(void)y;
}

#define FORCE_EVAL(x) fp_force_eval(x)
static inline void fp_force_evalf(float x)
{
	volatile float y;
	y = x;
	(void)y;
}

#define asuint64(f) ((union { double _f; uint64_t _i; }){f})._i
#define asdouble(i) ((union { uint64_t _i; double _f; }){i})._f

#define EXTRACT_WORDS(hi, lo, d) \
do { uint64_t __u = asuint64(d); (hi) = __u >> 32; (lo) = (uint32_t)__u; } while (0)
#define GET_HIGH_WORD(hi, d) \
do { (hi) = asuint64(d) >> 32; } while (0)
#define GET_LOW_WORD(lo, d) \
do { (lo) = (uint32_t)asuint64(d); } while (0)
#define INSERT_WORDS(d, hi, lo) \
do { (d) = asdouble(((uint64_t)(hi) << 32) | (uint32_t)(lo)); } while (0)
#define SET_HIGH_WORD(d, hi) INSERT_WORDS(d, hi, (uint32_t)asuint64(d))
#define SET_LOW_WORD(d, lo) INSERT_WORDS(d, asuint64(d) >> 32, lo)

#define __rem_pio2_large cohaptic_libm_rem_pio2_large
#define __rem_pio2 cohaptic_libm_rem_pio2
#define __sin cohaptic_libm_sin
#define __cos cohaptic_libm_cos
#define __tan cohaptic_libm_tan
#define __math_xflow cohaptic_libm_xflow
#define __math_uflow cohaptic_libm_uflow
#define __math_oflow cohaptic_libm_oflow
#define __math_divzero cohaptic_libm_divzero
#define __math_invalid cohaptic_libm_invalid
#define __exp_data cohaptic_libm_exp_data
#define __log_data cohaptic_libm_log_data
#define __pow_log_data cohaptic_libm_pow_log_data

int __rem_pio2_large(double *, double *, int, int, int);
int __rem_pio2(double, double *);
double __sin(double, double, int);
double __cos(double, double);
double __tan(double, double, int);
double __math_xflow(uint32_t, double);
double __math_uflow(uint32_t);
double __math_oflow(uint32_t);
double __math_divzero(uint32_t);
double __math_invalid(double);

#endif
