/* Setting and getting of values that are not reals, and steps that are parts of a period. */

#include "direct.h"

#define UNPACK(TYPE, FIELD)                                                                       \
    for (int64_t i = 0; i < op->cell_count; i++)                                                  \
        op->cells[i].FIELD = ((const TYPE *)op->scratch)[i];                                      \
    break

static void unpack(const Operation *op)
{
    switch (op->type) {
    case TYPE_FLOAT32: UNPACK(float, real);
    case TYPE_INT8: UNPACK(int8_t, integer);
    case TYPE_UINT8: UNPACK(uint8_t, integer);
    case TYPE_INT16: UNPACK(int16_t, integer);
    case TYPE_UINT16: UNPACK(uint16_t, integer);
    case TYPE_INT32: UNPACK(int32_t, integer);
    case TYPE_UINT32: UNPACK(uint32_t, integer);
    case TYPE_INT64: UNPACK(int64_t, integer);
    case TYPE_UINT64: UNPACK(int64_t, integer);
    case TYPE_BOOLEAN: /* any byte but 0 is true, whatever an FMU makes of a bool */
        for (int64_t i = 0; i < op->cell_count; i++)
            op->cells[i].integer = ((const uint8_t *)op->scratch)[i] != 0;
        break;
    case TYPE_BOOLEAN_INT:
        for (int64_t i = 0; i < op->cell_count; i++)
            op->cells[i].integer = ((const int32_t *)op->scratch)[i] != 0;
        break;
    default: break;
    }
}

/* The values of an enumeration, for each cell. */
typedef struct {
    const int64_t *values;
    int64_t count;
} Items;

/* The first value that names nothing, or -1. */
static int64_t unnamed(const Operation *op)
{
    const Items *items = op->kind == KIND_SET ? op->table : NULL; /* tune() has judged */
    for (int64_t i = 0; items && i < op->cell_count; i++)
        if (!is_among(op->cells[i].integer, items[i].values, items[i].count))
            return i;
    return -1;
}

#define PACK(TYPE, LOW, HIGH)                                                                     \
    for (int64_t i = 0; i < op->cell_count; i++) {                                                \
        int64_t value = op->cells[i].integer;                                                     \
        if (value < (LOW) || value > (HIGH))                                                      \
            return i;                                                                             \
        ((TYPE *)op->scratch)[i] = (TYPE)value;                                                   \
    }                                                                                             \
    break

/* The first value that does not fit the type, or -1. */
static int64_t pack(const Operation *op)
{
    switch (op->type) {
    case TYPE_FLOAT32:
        for (int64_t i = 0; i < op->cell_count; i++) {
            double value = op->cells[i].real;
            if (!__builtin_isinf(value) && __builtin_isinf((float)value))
                return i;
            ((float *)op->scratch)[i] = (float)value;
        }
        break;
    case TYPE_INT8: PACK(int8_t, INT8_MIN, INT8_MAX);
    case TYPE_UINT8: PACK(uint8_t, 0, UINT8_MAX);
    case TYPE_INT16: PACK(int16_t, INT16_MIN, INT16_MAX);
    case TYPE_UINT16: PACK(uint16_t, 0, UINT16_MAX);
    case TYPE_INT32: PACK(int32_t, INT32_MIN, INT32_MAX);
    case TYPE_UINT32: PACK(uint32_t, 0, UINT32_MAX);
    case TYPE_INT64: PACK(int64_t, INT64_MIN, INT64_MAX);
    case TYPE_UINT64: PACK(uint64_t, 0, INT64_MAX);
    case TYPE_BOOLEAN: PACK(bool, 0, 1);
    case TYPE_BOOLEAN_INT: PACK(int32_t, 0, 1);
    default: break;
    }
    return -1;
}

/* A UInt64 that a cell, which has a sign, would wrap. */
static Outcome refuse_beyond_a_cell(Kernel *kernel, const Operation *op)
{
    for (int64_t i = 0; i < op->cell_count; i++) {
        if (op->cells[i].integer < 0) {
            kernel->cell = &op->cells[i] - kernel->cells;
            return OUTCOME_RANGE;
        }
    }
    return OUTCOME_DONE;
}

Outcome get_values(Kernel *kernel, const Operation *op, Instance *instance)
{
    int status = call_access(op, op->version, instance->instance, op->scratch);
    Outcome outcome = judge_status(kernel, status, &instance->warnings);
    if (outcome != OUTCOME_DONE)
        return outcome;
    unpack(op);
    if (op->type == TYPE_FLOAT32)
        return refuse_nan(kernel, op);
    if (op->type == TYPE_UINT64)
        return refuse_beyond_a_cell(kernel, op);
    return OUTCOME_DONE;
}

Outcome set_values(Kernel *kernel, const Operation *op, Instance *instance)
{
    if (op->type == TYPE_FLOAT64)
        return set_reals(kernel, op, instance);
    int64_t misfit = unnamed(op);
    if (misfit < 0)
        misfit = pack(op);
    if (misfit >= 0) {
        kernel->cell = &op->cells[misfit] - kernel->cells;
        return OUTCOME_RANGE;
    }
    int status = call_access(op, op->version, instance->instance, op->scratch);
    return judge_status(kernel, status, &instance->warnings);
}

/* One period of an instance in equal steps. */
Outcome step_in_parts(Kernel *kernel, Instance *instance)
{
    const int version = (int)instance->version;
    for (int64_t i = 0; i < instance->substeps; i++) {
        Outcome outcome = step_once(kernel, instance, version, time_of_part(kernel, instance, i));
        if (outcome != OUTCOME_DONE)
            return outcome;
    }
    return OUTCOME_DONE;
}
