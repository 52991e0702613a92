/* Drives one FMU through its life with a sanitizer watching: random inputs and parameters within
   their limits, saved and damaged states, wrong calls. Ends with 0 and the number of good steps.
   An argument says for how many lives; there are 60 without one. */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"
#include "instance.h"

static uint64_t state = 1;

static uint64_t next(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return state >> 11;
}

static double uniform(double low, double high)
{
    return low + (high - low) * ((double)next() * 0x1p-53);
}

static void quiet(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                  fmi3String message)
{
    (void)environment, (void)status, (void)category;
    if (message[0] == '\0')
        abort();
}

static void quiet2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                   fmi2String category, fmi2String message, ...)
{
    (void)name;
    quiet(environment, (fmi3Status)status, category, message);
}

static void disturb(fmi3Instance fmu, uint8_t access, double size)
{
    for (uint32_t slot = 0; slot < model_slots; ++slot) {
        const Element *e = &model_elements[slot];
        if (e->access != access)
            continue;
        const double low = e->minimum > -1e9 ? e->minimum : -1e9;
        const double high = e->maximum < 1e9 ? e->maximum : 1e9;
        if (e->type == TYPE_REAL) {
            double value = e->start.real + uniform(-size, size);
            value = value < low ? low : value > high ? high : value;
            fmi3SetFloat64(fmu, &slot, 1, &value, 1);
        } else if (e->type == TYPE_INTEGER) {
            int32_t value = (int32_t)(e->start.integer + (int64_t)(next() % 3));
            fmi3SetInt32(fmu, &slot, 1, &value, 1);
        } else if (e->type == TYPE_ENUMERATION) {
            int64_t value = (int64_t)uniform(low, high + 0.99);
            fmi3SetInt64(fmu, &slot, 1, &value, 1);
        } else if (e->type == TYPE_BOOLEAN) {
            bool value = next() & 1;
            fmi3SetBoolean(fmu, &slot, 1, &value, 1);
        }
    }
}

static void read_all(fmi3Instance fmu)
{
    double real;
    int32_t whole;
    int64_t item;
    bool flag;
    fmi3String text;
    for (uint32_t slot = 0; slot < model_slots + 3; ++slot) {
        fmi3GetFloat64(fmu, &slot, 1, &real, 1);
        fmi3GetInt32(fmu, &slot, 1, &whole, 1);
        fmi3GetInt64(fmu, &slot, 1, &item, 1);
        fmi3GetBoolean(fmu, &slot, 1, &flag, 1);
        fmi3GetString(fmu, &slot, 1, &text, 1);
    }
}

static void save_and_restore(fmi3Instance fmu)
{
    fmi3FMUState saved = NULL, copy = NULL;
    size_t size = 0;
    fmi3GetFMUState(fmu, &saved);
    fmi3GetFMUState(fmu, &saved);
    if (fmi3SerializedFMUStateSize(fmu, saved, &size) != fmi3OK)
        return;
    fmi3Byte *bytes = malloc(size);
    fmi3SerializeFMUState(fmu, saved, bytes, size - 1);
    fmi3SerializeFMUState(fmu, saved, bytes, size);
    fmi3DeserializeFMUState(fmu, bytes, size - 1, &copy);
    if (fmi3DeserializeFMUState(fmu, bytes, size, &copy) != fmi3OK)
        abort();
    bytes[next() % size] ^= 1;
    fmi3FMUState damaged = NULL;
    if (fmi3DeserializeFMUState(fmu, bytes, size, &damaged) == fmi3OK)
        abort();
    free(bytes);
    fmi3SetFMUState(fmu, copy);
    fmi3SetFMUState(fmu, NULL);
    fmi3FreeFMUState(fmu, &saved);
    fmi3FreeFMUState(fmu, &saved);
    fmi3FreeFMUState(fmu, &copy);
}

int main(int count, char **words)
{
    int good = 0;
    const int lives = count > 1 ? atoi(words[1]) : 60;
    for (int life = 0; life < lives; ++life) {
        fmi3Instance fmu = fmi3InstantiateCoSimulation("x", model_token, "", false, life % 2, false,
                                                       false, NULL, 0, NULL, quiet, NULL);
        if (life % 3)
            disturb(fmu, ACCESS_PARAMETER, life % 3 == 1 ? 1e-3 : 10.0);
        if (life % 3)
            disturb(fmu, ACCESS_TUNABLE, life % 3 == 1 ? 1e-3 : 10.0);
        fmi3EnterInitializationMode(fmu, false, 0, 0.25, false, 0);
        read_all(fmu);
        fmi3ExitInitializationMode(fmu);
        double t = 0.25;
        for (int tick = 0; tick < 60; ++tick) {
            disturb(fmu, ACCESS_INPUT, tick % 20 == 7 ? 1e6 : 0.05);
            read_all(fmu);
            if (tick % 8 == 5)
                disturb(fmu, ACCESS_TUNABLE, 1.0);
            if (tick % 16 == 3)
                save_and_restore(fmu);
            bool flags[3];
            double last;
            if (fmi3DoStep(fmu, t, 1.0 / 1024, false, flags, flags + 1, flags + 2, &last) == fmi3OK) {
                t += 1.0 / 1024;
                ++good;
            }
        }
        disturb(fmu, ACCESS_COMPUTED, 1.0);
        fmi3Reset(fmu);
        fmi3FreeInstance(fmu);
    }
    fmi2CallbackFunctions functions = {quiet2, NULL, NULL, NULL, NULL};
    fmi2Component old = fmi2Instantiate("100 %s", fmi2CoSimulation, model_token, "", &functions,
                                        false, true);
    fmi2SetupExperiment(old, false, 0, 0, false, 0);
    fmi2EnterInitializationMode(old);
    fmi2ExitInitializationMode(old);
    for (int tick = 0; tick < 5; ++tick)
        fmi2DoStep(old, tick / 1024.0, 1.0 / 1024, true);
    fmi2DoStep(old, -1, 0, true);
    fmi2FreeInstance(old);
    printf("%d\n", good);
    return 0;
}
