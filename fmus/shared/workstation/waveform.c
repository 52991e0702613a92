#include "waveform.h"

static bool inside(double t, Window window)
{
    return t >= window.start && !(window.duration > 0.0 && t >= window.start + window.duration);
}

Signal step_signal(double t, Window window) { return (Signal){inside(t, window) ? 1.0 : 0.0, 0.0}; }

Signal sine_signal(double t, Window window, double frequency, double phase)
{
    if (!inside(t, window))
        return (Signal){0.0, 0.0};
    const double angle = frequency * (t - window.start) + phase;
    return (Signal){sin(angle), frequency * cos(angle)};
}

Signal minimum_jerk_signal(double t, double start, double duration)
{
    const double u = (t - start) / duration;
    if (!(u > 0.0))
        return (Signal){0.0, 0.0};
    if (u >= 1.0)
        return (Signal){1.0, 0.0};
    return (Signal){u * u * u * (10.0 + u * (-15.0 + 6.0 * u)),
                    30.0 * u * u * (1.0 - u) * (1.0 - u) / duration};
}

Signal half_wave(Signal s) { return s.value > 0.0 ? s : (Signal){0.0, 0.0}; }

Signal sampled_signal(const double *rows, size_t count, size_t columns, size_t column, double t,
                      bool linear)
{
    size_t low = 0, high = count; /* rows[low] is the last one not after t */
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (rows[columns * middle] <= t)
            low = middle;
        else
            high = middle;
    }
    const double *row = rows + columns * low;
    if (!linear || low + 1 == count || t < row[0])
        return (Signal){row[column], 0.0};
    const double *next = row + columns;
    const double slope = (next[column] - row[column]) / (next[0] - row[0]);
    return (Signal){row[column] + slope * (t - row[0]), slope};
}

const char *read_samples(Report *r, const char *path, size_t columns, size_t capacity,
                         double *rows, size_t *count)
{
    const char *problem = report_read_table(r, path, columns, capacity, rows, count);
    for (size_t i = 1; problem == NULL && i < *count; ++i)
        if (!(rows[columns * i] > rows[columns * (i - 1)]))
            return report_format(r, "%s: the time in row %d is %g s, not after the one before, "
                                    "%g s; times must rise.", path, (int)i + 1, rows[columns * i],
                                 rows[columns * (i - 1)]);
    return problem;
}
