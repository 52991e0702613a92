/* Reading and writing variables by value reference, which is the slot. */
#include "instance.h"

static const char *const type_names[] = {
    [TYPE_REAL] = "real",       [TYPE_INTEGER] = "integer", [TYPE_BOOLEAN] = "boolean",
    [TYPE_STRING] = "string",   [TYPE_ENUMERATION] = "enumeration",
};

/* How many values the variable takes: in the archive with arrays, the whole array. */
static size_t length_of(const Instance *i, uint32_t slot)
{
    return i->has_arrays && slot < model_slots ? model_elements[slot].length : 1;
}

static bool is_time(const Instance *i, Type type, uint32_t vr)
{
    return i->is_fmi3 && type == TYPE_REAL && vr == model_slots;
}

/* In FMI 2.0 an enumeration is read and written as an integer. */
static bool fits(const Instance *i, Type type, uint32_t vr)
{
    if (vr >= model_slots)
        return false;
    const Type actual = model_elements[vr].type;
    return actual == type ||
           (type == TYPE_INTEGER && actual == TYPE_ENUMERATION && !i->is_fmi3);
}

static Status check_references(Instance *i, const char *function, Type type, const uint32_t vr[],
                               size_t n, const void *values, size_t count, bool *computed)
{
    if (n > 0 && (vr == NULL || values == NULL))
        return instance_complain(i, ERROR, "%s: an array is missing (a null pointer).", function);
    size_t total = 0;
    for (size_t k = 0; k < n; ++k) {
        if (__builtin_expect(!fits(i, type, vr[k]), 0)) {
            if (!is_time(i, type, vr[k]))
                return instance_complain(i, ERROR,
                                         "%s: there is no %s variable with value reference %d.",
                                         function, type_names[type], (int)vr[k]);
            *computed = true;
            ++total;
            continue;
        }
        const size_t length = length_of(i, vr[k]);
        if (length == 0)
            return instance_complain(i, ERROR, "%s: value reference %d is inside an array.",
                                     function, (int)vr[k]);
        *computed |= model_elements[vr[k]].access == ACCESS_COMPUTED;
        total += length;
    }
    if (total != count)
        return instance_complain(i, ERROR, "%s: %d values are given for variables of %d elements.",
                                 function, (int)count, (int)total);
    return OK;
}

static Status check_get(Instance *i, const char *function, Type type, const uint32_t vr[], size_t n,
                        const void *values, size_t count)
{
    bool computed = false;
    const uint32_t always = PHASE_INITIALISATION | PHASE_STEP | PHASE_TERMINATED;
    Status status = instance_expect(i, function, always | PHASE_INSTANTIATED);
    if (status == OK)
        status = check_references(i, function, type, vr, n, values, count, &computed);
    if (status != OK || !computed)
        return status;
    status = instance_expect(i, function, always);
    return status == OK && i->is_outdated ? instance_evaluate(i) : status;
}

static Status check_set(Instance *i, const char *function, Type type, const uint32_t vr[], size_t n,
                        const void *values, size_t count)
{
    bool computed = false;
    const uint32_t before = PHASE_INSTANTIATED | PHASE_INITIALISATION;
    Status status = instance_expect(i, function, before | PHASE_STEP);
    if (status == OK)
        status = check_references(i, function, type, vr, n, values, count, &computed);
    if (status != OK)
        return status;
    for (size_t k = 0; k < n; ++k) {
        if (is_time(i, type, vr[k]))
            return instance_complain(i, ERROR, "%s: time cannot be set.", function);
        const Element *element = &model_elements[vr[k]];
        if (element->access == ACCESS_COMPUTED)
            return instance_complain(i, ERROR, "%s: '%s' is computed by the model and cannot be set.",
                                     function, element->name);
        if (element->access == ACCESS_PARAMETER && (i->clock.phase & before) == 0)
            return instance_complain(i, ERROR,
                                     "%s: '%s' is a fixed parameter; it can be set only before the "
                                     "simulation starts.",
                                     function, element->name);
    }
    return OK;
}

/* After values were set: outputs are to be computed again, and what follows from parameters. */
static void note_set(Instance *i, const uint32_t vr[], size_t n)
{
    i->is_outdated = true;
    if (i->clock.phase != PHASE_STEP)
        return; /* initialisation works everything out */
    for (size_t k = 0; k < n; ++k)
        if (model_elements[vr[k]].access == ACCESS_TUNABLE) {
            instance_retune(i);
            return;
        }
}

static Status check_range(Instance *i, const char *function, const Element *element, double value)
{
    const bool limited = element->access <= ACCESS_TUNABLE || element->type == TYPE_BOOLEAN ||
                         element->type == TYPE_ENUMERATION;
    if (__builtin_expect(!isfinite(value), 0))
        return instance_complain(i, ERROR, "%s: '%s' cannot be set to %g; give a finite number.",
                                 function, element->name, value);
    if (limited && value < element->minimum)
        return instance_complain(i, ERROR, "%s: '%s' cannot be set to %g; the least value is %g.",
                                 function, element->name, value, element->minimum);
    if (limited && value > element->maximum)
        return instance_complain(i, ERROR, "%s: '%s' cannot be set to %g; the greatest value is %g.",
                                 function, element->name, value, element->maximum);
    return OK;
}

Status get_reals(Instance *i, const char *function, const uint32_t vr[], size_t n, double *values,
                 size_t count)
{
    const Status status = check_get(i, function, TYPE_REAL, vr, n, values, count);
    if (status != OK)
        return status;
    for (size_t k = 0; k < n; ++k) {
        const size_t length = length_of(i, vr[k]);
        for (size_t j = 0; j < length; ++j)
            *values++ = vr[k] == model_slots ? i->clock.time : i->cells[vr[k] + j].real;
    }
    return OK;
}

Status set_reals(Instance *i, const char *function, const uint32_t vr[], size_t n,
                 const double *values, size_t count)
{
    Status status = check_set(i, function, TYPE_REAL, vr, n, values, count);
    const double *value = values;
    for (size_t k = 0; status == OK && k < n; ++k)
        for (size_t j = 0; status == OK && j < length_of(i, vr[k]); ++j)
            status = check_range(i, function, &model_elements[vr[k] + j], *value++);
    if (status != OK)
        return status;
    for (size_t k = 0; k < n; ++k)
        for (size_t j = 0; j < length_of(i, vr[k]); ++j)
            i->cells[vr[k] + j].real = *values++;
    note_set(i, vr, n);
    return OK;
}

static int64_t load(const void *values, size_t width, size_t index)
{
    switch (width) {
    case 1:
        return ((const bool *)values)[index];
    case 4:
        return ((const int32_t *)values)[index];
    default:
        return ((const int64_t *)values)[index];
    }
}

static void store(void *values, size_t width, size_t index, int64_t value)
{
    switch (width) {
    case 1:
        ((bool *)values)[index] = value != 0;
        break;
    case 4:
        ((int32_t *)values)[index] = (int32_t)value;
        break;
    default:
        ((int64_t *)values)[index] = value;
    }
}

Status get_integers(Instance *i, const char *function, Type type, const uint32_t vr[], size_t n,
                    void *values, size_t width, size_t count)
{
    const Status status = check_get(i, function, type, vr, n, values, count);
    if (status != OK)
        return status;
    size_t index = 0;
    for (size_t k = 0; k < n; ++k)
        for (size_t j = 0; j < length_of(i, vr[k]); ++j)
            store(values, width, index++, i->cells[vr[k] + j].integer);
    return OK;
}

Status set_integers(Instance *i, const char *function, Type type, const uint32_t vr[], size_t n,
                    const void *values, size_t width, size_t count)
{
    Status status = check_set(i, function, type, vr, n, values, count);
    size_t index = 0;
    for (size_t k = 0; status == OK && k < n; ++k)
        for (size_t j = 0; status == OK && j < length_of(i, vr[k]); ++j)
            status = check_range(i, function, &model_elements[vr[k] + j],
                                 (double)load(values, width, index++));
    if (status != OK)
        return status;
    index = 0;
    for (size_t k = 0; k < n; ++k)
        for (size_t j = 0; j < length_of(i, vr[k]); ++j)
            i->cells[vr[k] + j].integer = load(values, width, index++);
    note_set(i, vr, n);
    return OK;
}

static size_t text_length(const char *text)
{
    size_t length = 0;
    while (text[length] != '\0')
        ++length;
    return length;
}

Status get_strings(Instance *i, const char *function, const uint32_t vr[], size_t n,
                   const char **values, size_t count)
{
    const Status status = check_get(i, function, TYPE_STRING, vr, n, values, count);
    if (status != OK)
        return status;
    for (size_t k = 0; k < n; ++k)
        for (size_t j = 0; j < length_of(i, vr[k]); ++j)
            *values++ = (const char *)&i->cells[vr[k] + j * STRING_SLOTS];
    return OK;
}

Status set_strings(Instance *i, const char *function, const uint32_t vr[], size_t n,
                   const char *const *values, size_t count)
{
    const Status status = check_set(i, function, TYPE_STRING, vr, n, values, count);
    if (status != OK)
        return status;
    for (size_t k = 0; k < count; ++k) {
        if (values[k] == NULL)
            return instance_complain(i, ERROR, "%s: a string is missing (a null pointer).", function);
        if (text_length(values[k]) >= STRING_BYTES)
            return instance_complain(i, ERROR, "%s: a string is longer than %d bytes.", function,
                                     STRING_BYTES - 1);
    }
    for (size_t k = 0; k < n; ++k)
        for (size_t j = 0; j < length_of(i, vr[k]); ++j, ++values) {
            char *target = (char *)&i->cells[vr[k] + j * STRING_SLOTS];
            memset(target, 0, STRING_BYTES);
            memcpy(target, *values, text_length(*values));
        }
    note_set(i, vr, n);
    return OK;
}
