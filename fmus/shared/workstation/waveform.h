/* Signals over time that several models offer: step, sine, minimum jerk, and samples from a file. */
#ifndef COHAPTIC_WAVEFORM_H
#define COHAPTIC_WAVEFORM_H

#include "model.h"

/* A value and its time derivative. */
typedef struct {
    double value, rate;
} Signal;

/* Zero before `start` and, where `duration` > 0, from start + duration on. Times in s. */
typedef struct {
    double start, duration;
} Window;

Signal step_signal(double t, Window window);
/* sin(frequency (t - start) + phase); frequency in rad/s, phase in rad. */
Signal sine_signal(double t, Window window, double frequency, double phase);
/* From 0 to 1 with zero velocity and acceleration at both ends (Flash and Hogan 1985). */
Signal minimum_jerk_signal(double t, double start, double duration);
/* What is below zero becomes zero. */
Signal half_wave(Signal s);

/* Rows of `columns` numbers, the first one the time, strictly rising; `column` counts from 1. Held
   before the first and after the last row; in between linear, or held where `linear` is false. */
Signal sampled_signal(const double *rows, size_t count, size_t columns, size_t column, double t,
                      bool linear);

/* report_read_table with a check that time rises. */
const char *read_samples(Report *r, const char *path, size_t columns, size_t capacity,
                         double *rows, size_t *count);

#endif
