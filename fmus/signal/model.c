/* A signal over time, evaluated at the committed time. */
#include "signal_variables.h"
#include "waveform.h"

enum { CAPACITY = 16384, COLUMNS = 2 };

struct State {
    double time;
    size_t count;
    double rows[CAPACITY * COLUMNS];
};

const size_t model_state_size = sizeof(State);

size_t model_state_used(const State *s)
{
    if (s->count > CAPACITY)
        return SIZE_MAX;
    return offsetof(State, rows) + s->count * COLUMNS * sizeof s->rows[0];
}

const char *model_initialise(Variables *v, State *s, Report *r)
{
    s->time = report_start_time(r);
    if (v->mode == SIGNAL_MODE_MINIMUM_JERK && !(v->duration > 0.0))
        return "duration is 0 s; give the time that the minimum jerk movement takes.";
    if (v->mode != SIGNAL_MODE_TABLE)
        return NULL;
    if (v->table_file[0] == '\0')
        return "mode is 'table', but table_file is empty; give the path of a text file.";
    return read_samples(r, v->table_file, COLUMNS, CAPACITY, s->rows, &s->count);
}

static Signal shape(const Variables *v, const State *s)
{
    const Window window = {v->start_time, v->duration};
    switch (v->mode) {
    case SIGNAL_MODE_STEP:
        return step_signal(s->time, window);
    case SIGNAL_MODE_SINE:
        return sine_signal(s->time, window, v->frequency, v->phase);
    case SIGNAL_MODE_MINIMUM_JERK:
        return minimum_jerk_signal(s->time, v->start_time, v->duration);
    case SIGNAL_MODE_TABLE:
        return sampled_signal(s->rows, s->count, COLUMNS, 1, s->time - v->start_time,
                              v->interpolate);
    default:
        return (Signal){1.0, 0.0};
    }
}

void model_outputs(Variables *v, const State *s)
{
    Signal signal = shape(v, s);
    signal.value *= v->amplitude;
    signal.rate *= v->amplitude;
    if (v->rectify)
        signal = half_wave(signal);
    v->value = v->offset + signal.value;
    v->rate = signal.rate;
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    s->time = t + h;
    return NULL;
}
