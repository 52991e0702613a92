#include "probe_types_variables.h"

struct State {
    int64_t steps;
};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{
    report_log(r, "probe_types starts.");
    return NULL;
}

static void copy(char *to, const char *from)
{
    while ((*to++ = *from++) != '\0')
        ;
}

void model_outputs(Variables *v, const State *s)
{
    v->real_out = -v->real_in;
    v->integer_out = -v->integer_in;
    v->boolean_out = !v->boolean_in;
    v->enumeration_out = v->enumeration_in == COLOUR_RED ? COLOUR_BLUE : COLOUR_RED;
    copy(v->string_out, v->string_in);
    for (int i = 0; i < 3; ++i)
        v->reals_out[i] = -v->reals_in[i];
    for (int i = 0; i < 2; ++i) {
        v->integers_out[i] = -v->integers_in[i];
        v->booleans_out[i] = !v->booleans_in[i];
        copy(v->strings_out[i], v->strings_in[i]);
    }
}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{
    ++s->steps;
    return NULL;
}
