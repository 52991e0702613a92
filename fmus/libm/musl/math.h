/* What musl's sources find as <math.h>: our names, and the one evaluation type. */
#ifndef COHAPTIC_MUSL_MATH_H
#define COHAPTIC_MUSL_MATH_H

#include "../cohaptic_math.h"

typedef double double_t;

#endif
