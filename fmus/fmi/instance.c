/* The life of an instance: phases, initialisation, evaluation and steps. */
#include "instance.h"

static const char *const categories[] = {
    [OK] = "logInfo",
    [WARNING] = "logStatusWarning",
    [DISCARD] = "logStatusDiscard",
    [ERROR] = "logStatusError",
    [FATAL] = "logStatusFatal",
};

static size_t aligned(size_t bytes) { return (bytes + 63) & ~(size_t)63; }

size_t instance_state_room(void) { return ((model_state_size + 15) & ~(size_t)15) + model_work_bytes; }

void instance_clear_work(Instance *i)
{
    if (model_work_bytes > 0)
        memset(model_work(i->state), 0, model_work_bytes);
}

/* Rows of a table that are not in use are never read, so that they need not be cleared. */
void instance_clear_state(Instance *i)
{
    memset(i->state, 0, model_state_used(i->state));
    instance_clear_work(i);
}

static void log_information(void *context, const char *sentence)
{
    Instance *i = context;
    if (i->logs_information)
        i->emit(i, OK, categories[OK], sentence);
}

static void set_start_values(Instance *i)
{
    memset(i->cells, 0, 8 * (size_t)model_slots);
    instance_clear_state(i);
    for (uint32_t slot = 0; slot < model_slots; ++slot)
        i->cells[slot] = model_elements[slot].start;
    for (size_t k = 0; k < model_string_starts_count; ++k) {
        char *target = (char *)&i->cells[model_string_starts[k].slot];
        for (const char *c = model_string_starts[k].text; *c != '\0'; ++c)
            *target++ = *c;
    }
    i->clock = (Clock){.phase = PHASE_INSTANTIATED};
    i->stop_time_defined = false;
    i->is_outdated = true;
}

Instance *instance_new(const char *name, Emit *emit, void (*logger)(void), void *environment,
                       bool logs_information)
{
    const size_t head = aligned(sizeof(Instance)), cells = aligned(8 * (size_t)model_slots);
    const size_t size = head + cells + aligned(instance_state_room());
    char *memory = platform_allocate(size);
    if (memory == NULL)
        return NULL;
    Instance *i = (Instance *)memory;
    i->report.log = log_information;
    i->report.context = i;
    i->emit = emit;
    i->logger = logger;
    i->environment = environment;
    i->logs_information = logs_information;
    i->cells = (Cell *)(memory + head);
    i->state = (State *)(memory + head + cells);
    i->size = size;
    for (size_t k = 0; name[k] != '\0' && k + 1 < sizeof i->name; ++k)
        i->name[k] = name[k];
    set_start_values(i);
    return i;
}

void instance_free(Instance *i)
{
    if (i != NULL)
        platform_free(i, i->size);
}

Status instance_complain(Instance *i, Status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const char *sentence = report_format_list(&i->report, format, arguments);
    va_end(arguments);
    i->emit(i, status, categories[status], sentence);
    return status;
}

Status instance_expect(Instance *i, const char *function, uint32_t phases)
{
    if (__builtin_expect((i->clock.phase & phases) != 0, 1))
        return OK;
    const char *where = "";
    switch (i->clock.phase) {
    case PHASE_INSTANTIATED:
        where = "before initialisation mode";
        break;
    case PHASE_INITIALISATION:
        where = "in initialisation mode";
        break;
    case PHASE_STEP:
        where = "while the simulation runs";
        break;
    case PHASE_TERMINATED:
        where = "after the simulation was terminated";
        break;
    case PHASE_FAILED:
        where = "after an error; reset the instance, restore a state, or free it";
        break;
    case PHASE_DEAD:
        where = "after a fatal error; the instance can only be freed";
        break;
    }
    return instance_complain(i, ERROR, "%s is not allowed %s.", function, where);
}

bool same_text(const char *a, const char *b)
{
    while (*a != '\0' && *a == *b)
        ++a, ++b;
    return *a == *b;
}

Status instance_set_logging(Instance *i, const char *function, bool on, size_t count,
                            const char *const wanted[])
{
    bool information = count == 0;
    if (count > 0 && wanted == NULL)
        return instance_complain(i, ERROR, "%s: the list of categories is missing.", function);
    for (size_t k = 0; k < count; ++k) {
        bool known = wanted[k] != NULL && same_text(wanted[k], "logAll");
        information |= known;
        for (Status status = OK; !known && wanted[k] != NULL && status <= FATAL; ++status)
            if (same_text(wanted[k], categories[status])) {
                known = true;
                information |= status == OK;
            }
        if (!known)
            return instance_complain(i, ERROR, "%s: there is no log category '%s'.", function,
                                     wanted[k]);
    }
    if (information)
        i->logs_information = on;
    return OK;
}

Status instance_setup(Instance *i, const char *function, double start_time, bool stop_time_defined,
                      double stop_time)
{
    const Status status = instance_expect(i, function, PHASE_INSTANTIATED);
    if (status != OK)
        return status;
    if (!isfinite(start_time))
        return instance_complain(i, ERROR, "%s: the start time is %g s.", function, start_time);
    if (stop_time_defined && !(stop_time >= start_time))
        return instance_complain(i, ERROR, "%s: the stop time %g s lies before the start, %g s.",
                                 function, stop_time, start_time);
    i->clock.time = i->clock.start_time = start_time;
    i->stop_time = stop_time;
    i->stop_time_defined = stop_time_defined;
    return OK;
}

Status instance_enter_initialisation(Instance *i, const char *function)
{
    const Status status = instance_expect(i, function, PHASE_INSTANTIATED);
    if (status == OK) {
        i->clock.phase = PHASE_INITIALISATION;
        i->is_outdated = true;
    }
    return status;
}

static Status initialise_model(Instance *i)
{
    instance_clear_state(i);
    i->report.start_time = i->clock.start_time;
    const char *problem = model_initialise((Variables *)i->cells, i->state, &i->report);
    if (problem == NULL)
        return OK;
    i->emit(i, ERROR, categories[ERROR], problem);
    return ERROR;
}

Status instance_evaluate(Instance *i)
{
    if (i->clock.phase == PHASE_INITIALISATION) {
        const Status status = initialise_model(i);
        if (status != OK)
            return status;
    }
    model_outputs((Variables *)i->cells, i->state);
    i->is_outdated = false;
    return OK;
}

void instance_retune(Instance *i)
{
    instance_clear_work(i);
    model_retune((const Variables *)i->cells, i->state);
}

Status instance_exit_initialisation(Instance *i, const char *function)
{
    Status status = instance_expect(i, function, PHASE_INITIALISATION);
    if (status != OK)
        return status;
    status = initialise_model(i);
    i->clock.phase = status == OK ? PHASE_STEP : PHASE_FAILED;
    i->is_outdated = true;
    return status;
}

/* Importers accumulate time or multiply tick numbers; both are right to within this. */
static double tolerance(double t, double h) { return 1e-9 * fmax(fabs(t), 1.0) + 1e-6 * h; }

Status instance_step(Instance *i, const char *function, double t, double h)
{
    const Status status = instance_expect(i, function, PHASE_STEP);
    if (status != OK)
        return status;
    if (!isfinite(h) || !(h > 0.0))
        return instance_complain(i, ERROR, "%s: the step is %g s; it must be above zero.",
                                 function, h);
    if (!(fabs(t - i->clock.time) <= tolerance(i->clock.time, h)))
        return instance_complain(i, ERROR,
                                 "%s: the step starts at %g s, but the last one ended at %g s.",
                                 function, t, i->clock.time);
    if (i->stop_time_defined && t + h > i->stop_time + tolerance(t, h))
        return instance_complain(i, ERROR, "%s: the step ends at %g s, after the stop time %g s.",
                                 function, t + h, i->stop_time);
    if (!model_variable_step && i->clock.step > 0.0 && fabs(h - i->clock.step) > 1e-9 * h)
        return instance_complain(i, ERROR,
                                 "%s: the step is %g s, the earlier ones were %g s; this model "
                                 "cannot change its step.",
                                 function, h, i->clock.step);
    i->report.severity = SEVERITY_ERROR;
    i->report.outputs_are_current = !i->is_outdated;
    const char *problem = model_step((Variables *)i->cells, i->state, t, h, &i->report);
    if (__builtin_expect(problem != NULL, 0)) {
        const Status result = (Status)i->report.severity;
        i->emit(i, result, categories[result], problem);
        if (result != DISCARD)
            i->clock.phase = result == FATAL ? PHASE_DEAD : PHASE_FAILED;
        return result;
    }
    i->clock.time = t + h;
    i->clock.step = h;
    i->is_outdated = true;
    return OK;
}

Status instance_terminate(Instance *i, const char *function)
{
    const Status status = instance_expect(i, function, PHASE_STEP | PHASE_FAILED);
    if (status == OK)
        i->clock.phase = PHASE_TERMINATED;
    return status;
}

Status instance_reset(Instance *i, const char *function)
{
    const Status status = instance_expect(i, function, ~(uint32_t)PHASE_DEAD);
    if (status == OK)
        set_start_values(i);
    return status;
}
