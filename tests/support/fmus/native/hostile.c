/* An importer that keeps no rule: calls in any order, references that do not exist, counts that do
   not fit, states of other instances, times and steps that are no numbers, thousands of instances.
   With a sanitizer watching it ends with 0 and the number of calls that were refused. */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"
#include "instance.h"

enum { CROWD = 2000, CALLS = 40000, ROOM = 8, KINDS = 19 };

static uint64_t state = 7;
static int refused;

static uint64_t next(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return state >> 17;
}

static double any_number(void)
{
    static const double odd[] = {0.0, -0.0, 1.0, -1.0, 1.0 / 1024, 1e308, -1e308, 5e-324,
                                 __builtin_inf(), -__builtin_inf(), __builtin_nan("")};
    return odd[next() % (sizeof odd / sizeof *odd)];
}

static uint32_t any_reference(void)
{
    static const uint32_t odd[] = {UINT32_MAX, INT32_MAX, 1u << 31, 100000};
    return next() % 4 ? (uint32_t)(next() % (model_slots + 2)) : odd[next() % 4];
}

static void hear(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                 fmi3String message)
{
    (void)environment, (void)status, (void)category, (void)message;
}

static void hear2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                  fmi2String category, fmi2String message, ...)
{
    (void)environment, (void)name, (void)status, (void)category, (void)message;
}

static void judge(int status)
{
    if (status < 0 || status > 5)
        abort();
    refused += status > 1;
}

static fmi3Instance make(void)
{
    return fmi3InstantiateCoSimulation("x", next() % 8 ? model_token : "{another}", "", false,
                                       next() % 2, false, false, NULL, 0, NULL, hear, NULL);
}

static void one_call(fmi3Instance fmu, fmi3FMUState *states, fmi3FMUState foreign)
{
    uint32_t references[ROOM];
    double reals[ROOM];
    int32_t wholes[ROOM];
    int64_t items[ROOM];
    bool flags[ROOM];
    fmi3String texts[ROOM];
    size_t count = next() % ROOM, values = next() % 4 ? count : next() % ROOM;
    for (int i = 0; i < ROOM; i++) {
        references[i] = any_reference();
        reals[i] = any_number();
        wholes[i] = (int32_t)next();
        items[i] = (int64_t)next() - (1 << 20);
        flags[i] = next() & 1;
        texts[i] = next() % 2 ? "/no/such/file" : "";
    }
    double last;
    size_t size = 0;
    switch (next() % KINDS) {
    case 0: judge(fmi3EnterInitializationMode(fmu, next() % 2, any_number(), any_number(),
                                              next() % 2, any_number())); break;
    case 1: judge(fmi3ExitInitializationMode(fmu)); break;
    case 2: judge(fmi3Terminate(fmu)); break;
    case 3: judge(fmi3Reset(fmu)); break;
    case 4: judge(fmi3GetFloat64(fmu, references, count, reals, values)); break;
    case 5: judge(fmi3SetFloat64(fmu, references, count, reals, values)); break;
    case 6: judge(fmi3GetInt32(fmu, references, count, wholes, values)); break;
    case 7: judge(fmi3SetInt32(fmu, references, count, wholes, values)); break;
    case 8: judge(fmi3GetInt64(fmu, references, count, items, values)); break;
    case 9: judge(fmi3SetInt64(fmu, references, count, items, values)); break;
    case 10: judge(fmi3GetBoolean(fmu, references, count, flags, values)); break;
    case 11: judge(fmi3SetBoolean(fmu, references, count, flags, values)); break;
    case 12: judge(fmi3GetString(fmu, references, count, texts, values)); break;
    case 13: judge(fmi3SetString(fmu, references, count, texts, values)); break;
    case 14: judge(fmi3DoStep(fmu, any_number(), any_number(), next() % 2, flags, flags + 1,
                              flags + 2, &last)); break;
    case 15: judge(fmi3GetFMUState(fmu, states)); break;
    case 16: judge(fmi3SetFMUState(fmu, next() % 2 ? foreign : *states)); break;
    case 17: judge(fmi3FreeFMUState(fmu, states)); break;
    case 18: judge(fmi3SerializedFMUStateSize(fmu, *states, &size)); break;
    }
}

int main(void)
{
    static fmi3Instance crowd[CROWD];
    fmi3FMUState states[4] = {NULL, NULL, NULL, NULL};
    for (int i = 0; i < CROWD; i++)
        crowd[i] = make();
    /* A state is freed by the instance that it was made by, or by another one: both are ours. */
    for (int i = 0; i < CALLS; i++) {
        fmi3Instance fmu = crowd[next() % (next() % 2 ? 4 : CROWD)];
        if (fmu)
            one_call(fmu, &states[next() % 4], states[next() % 4]);
    }
    for (int i = 0; i < 4; i++)
        for (int owner = 0; owner < CROWD && states[i]; owner++)
            if (crowd[owner])
                fmi3FreeFMUState(crowd[owner], &states[i]);
    for (int i = 0; i < CROWD; i++)
        if (crowd[i])
            fmi3FreeInstance(crowd[i]);

    fmi2CallbackFunctions functions = {hear2, NULL, NULL, NULL, NULL};
    for (int life = 0; life < 50; life++) {
        fmi2Component fmu = fmi2Instantiate("x", fmi2CoSimulation, model_token, "", &functions,
                                            false, life % 2);
        for (int i = 0; fmu && i < 200; i++) {
            uint32_t reference = any_reference();
            double real = any_number();
            int whole = (int)next();
            fmi2String text = "";
            switch (next() % 12) {
            case 0: judge(fmi2SetupExperiment(fmu, life % 2, any_number(), any_number(), life % 3,
                                              any_number())); break;
            case 1: judge(fmi2EnterInitializationMode(fmu)); break;
            case 2: judge(fmi2ExitInitializationMode(fmu)); break;
            case 3: judge(fmi2Terminate(fmu)); break;
            case 4: judge(fmi2Reset(fmu)); break;
            case 5: judge(fmi2GetReal(fmu, &reference, 1, &real)); break;
            case 6: judge(fmi2SetReal(fmu, &reference, 1, &real)); break;
            case 7: judge(fmi2GetInteger(fmu, &reference, 1, &whole)); break;
            case 8: judge(fmi2SetInteger(fmu, &reference, 1, &whole)); break;
            case 9: judge(fmi2GetString(fmu, &reference, 1, &text)); break;
            case 10: judge(fmi2SetBoolean(fmu, &reference, 1, &whole)); break;
            case 11: judge(fmi2DoStep(fmu, any_number(), any_number(), true)); break;
            }
        }
        if (fmu)
            fmi2FreeInstance(fmu);
    }
    printf("%d\n", refused);
    return 0;
}
