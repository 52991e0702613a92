/* The FMI 3.0 functions for co-simulation. What this FMU says it cannot do ends in fmi3Error. */
#include "fmi3Functions.h"
#include "instance.h"

#define NEED(c)                                                                                   \
    if ((c) == NULL)                                                                              \
    return fmi3Error

static void emit(Instance *i, Status status, const char *category, const char *message)
{
    if (i->logger != NULL)
        ((fmi3LogMessageCallback)i->logger)(i->environment, (fmi3Status)status, category, message);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
    fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
    size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate)
{
    (void)resourcePath, (void)visible, (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables, (void)intermediateUpdate;
    const char *problem = NULL;
    const bool arrays = instantiationToken != NULL && same_text(instantiationToken, model_array_token);
    if (instanceName == NULL || *instanceName == '\0')
        problem = "fmi3InstantiateCoSimulation: the instance has no name.";
    else if (instantiationToken == NULL || (!arrays && !same_text(instantiationToken, model_token)))
        problem = "fmi3InstantiateCoSimulation: the instantiation token is not the one of this "
                  "library; its modelDescription.xml belongs to another build.";
    else if (eventModeUsed)
        problem = "fmi3InstantiateCoSimulation: this FMU has no event mode.";
    else if (nRequiredIntermediateVariables > 0)
        problem = "fmi3InstantiateCoSimulation: this FMU gives no intermediate values.";
    if (problem == NULL) {
        Instance *i = instance_new(instanceName, emit, (void (*)(void))logMessage,
                                   instanceEnvironment, loggingOn);
        if (i != NULL) {
            i->is_fmi3 = true;
            i->has_arrays = arrays;
            return i;
        }
        problem = "fmi3InstantiateCoSimulation: memory has run out.";
    }
    if (logMessage != NULL)
        logMessage(instanceEnvironment, fmi3Error, "logStatusError", problem);
    return NULL;
}

static fmi3Instance refuse_kind(fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    if (log != NULL)
        log(environment, fmi3Error, "logStatusError", "This FMU is for co-simulation only.");
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)loggingOn;
    return refuse_kind(environment, log);
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean loggingOn, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
    fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)loggingOn;
    (void)update, (void)lock, (void)unlock;
    return refuse_kind(environment, log);
}

void fmi3FreeInstance(fmi3Instance instance) { instance_free(instance); }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    NEED(instance);
    return (fmi3Status)instance_set_logging(instance, __func__, loggingOn, nCategories, categories);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    (void)toleranceDefined, (void)tolerance;
    NEED(instance);
    const Status status = instance_setup(instance, __func__, startTime, stopTimeDefined, stopTime);
    return (fmi3Status)(status == OK ? instance_enter_initialisation(instance, __func__) : status);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    NEED(instance);
    return (fmi3Status)instance_exit_initialisation(instance, __func__);
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    NEED(instance);
    return (fmi3Status)instance_terminate(instance, __func__);
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    NEED(instance);
    return (fmi3Status)instance_reset(instance, __func__);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    NEED(instance);
    const Status status =
        instance_step(instance, __func__, currentCommunicationPoint, communicationStepSize);
    if (eventHandlingNeeded != NULL)
        *eventHandlingNeeded = fmi3False;
    if (terminateSimulation != NULL)
        *terminateSimulation = fmi3False;
    if (earlyReturn != NULL)
        *earlyReturn = fmi3False;
    if (lastSuccessfulTime != NULL)
        *lastSuccessfulTime = ((Instance *)instance)->clock.time;
    return (fmi3Status)status;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, fmi3Float64 values[], size_t nValues)
{
    NEED(instance);
    return (fmi3Status)get_reals(instance, __func__, valueReferences, nValueReferences, values,
                                 nValues);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Float64 values[], size_t nValues)
{
    NEED(instance);
    return (fmi3Status)set_reals(instance, __func__, valueReferences, nValueReferences, values,
                                 nValues);
}

/* Integers are Int32; in FMI 3.0 an enumeration is read and written as Int64. */
#define WHOLE_NUMBERS(Name, type)                                                                 \
    fmi3Status fmi3Get##Name(fmi3Instance instance, const fmi3ValueReference valueReferences[],   \
                             size_t nValueReferences, fmi3##Name values[], size_t nValues)        \
    {                                                                                             \
        NEED(instance);                                                                           \
        return (fmi3Status)get_integers(instance, __func__, type, valueReferences,                \
                                        nValueReferences, values, sizeof *values, nValues);       \
    }                                                                                             \
    fmi3Status fmi3Set##Name(fmi3Instance instance, const fmi3ValueReference valueReferences[],   \
                             size_t nValueReferences, const fmi3##Name values[], size_t nValues)  \
    {                                                                                             \
        NEED(instance);                                                                           \
        return (fmi3Status)set_integers(instance, __func__, type, valueReferences,                \
                                        nValueReferences, values, sizeof *values, nValues);       \
    }

WHOLE_NUMBERS(Int32, TYPE_INTEGER)
WHOLE_NUMBERS(Int64, TYPE_ENUMERATION)
WHOLE_NUMBERS(Boolean, TYPE_BOOLEAN)

fmi3Status fmi3GetString(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, fmi3String values[], size_t nValues)
{
    NEED(instance);
    return (fmi3Status)get_strings(instance, __func__, valueReferences, nValueReferences, values,
                                   nValues);
}

fmi3Status fmi3SetString(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, const fmi3String values[], size_t nValues)
{
    NEED(instance);
    return (fmi3Status)set_strings(instance, __func__, valueReferences, nValueReferences, values,
                                   nValues);
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    NEED(instance);
    return (fmi3Status)snapshot_get(instance, __func__, FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    NEED(instance);
    return (fmi3Status)snapshot_set(instance, __func__, FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    NEED(instance);
    return (fmi3Status)snapshot_free(instance, __func__, FMUState);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    NEED(instance);
    return (fmi3Status)snapshot_size(instance, __func__, FMUState, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState,
                                 fmi3Byte serializedState[], size_t size)
{
    NEED(instance);
    return (fmi3Status)snapshot_serialise(instance, __func__, FMUState, serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[],
                                   size_t size, fmi3FMUState *FMUState)
{
    NEED(instance);
    return (fmi3Status)snapshot_deserialise(instance, __func__, serializedState, size, FMUState);
}

/* The rest: other kinds of simulation, types that no variable has, and options that the
   description says are not there. */

static fmi3Status refuse(fmi3Instance instance, const char *function)
{
    NEED(instance);
    return (fmi3Status)instance_complain(instance, ERROR, "%s is not supported by this FMU.",
                                         function);
}

#define REFUSE(name, ...)                                                                         \
    fmi3Status name(fmi3Instance instance, ##__VA_ARGS__) { return refuse(instance, #name); }

#define VR const fmi3ValueReference vr[], size_t n

#define NO_SUCH_TYPE(Name)                                                                        \
    REFUSE(fmi3Get##Name, VR, fmi3##Name values[], size_t count)                                  \
    REFUSE(fmi3Set##Name, VR, const fmi3##Name values[], size_t count)

NO_SUCH_TYPE(Float32)
NO_SUCH_TYPE(Int8)
NO_SUCH_TYPE(UInt8)
NO_SUCH_TYPE(Int16)
NO_SUCH_TYPE(UInt16)
NO_SUCH_TYPE(UInt32)
NO_SUCH_TYPE(UInt64)
REFUSE(fmi3GetBinary, VR, size_t sizes[], fmi3Binary values[], size_t count)
REFUSE(fmi3SetBinary, VR, const size_t sizes[], const fmi3Binary values[], size_t count)
REFUSE(fmi3GetClock, VR, fmi3Clock values[])
REFUSE(fmi3SetClock, VR, const fmi3Clock values[])
REFUSE(fmi3GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t *count)
REFUSE(fmi3GetVariableDependencies, fmi3ValueReference dependent, size_t elements[],
       fmi3ValueReference independents[], size_t of[], fmi3DependencyKind kinds[], size_t count)
REFUSE(fmi3GetDirectionalDerivative, const fmi3ValueReference u[], size_t nu,
       const fmi3ValueReference k[], size_t nk, const fmi3Float64 seed[], size_t nSeed,
       fmi3Float64 sensitivity[], size_t nSensitivity)
REFUSE(fmi3GetAdjointDerivative, const fmi3ValueReference u[], size_t nu,
       const fmi3ValueReference k[], size_t nk, const fmi3Float64 seed[], size_t nSeed,
       fmi3Float64 sensitivity[], size_t nSensitivity)
REFUSE(fmi3GetOutputDerivatives, VR, const fmi3Int32 orders[], fmi3Float64 values[], size_t count)
REFUSE(fmi3EnterConfigurationMode)
REFUSE(fmi3ExitConfigurationMode)
REFUSE(fmi3EnterEventMode)
REFUSE(fmi3EnterStepMode)
REFUSE(fmi3EnterContinuousTimeMode)
REFUSE(fmi3EvaluateDiscreteStates)
REFUSE(fmi3UpdateDiscreteStates, fmi3Boolean *need, fmi3Boolean *terminate, fmi3Boolean *nominals,
       fmi3Boolean *states, fmi3Boolean *defined, fmi3Float64 *next)
REFUSE(fmi3GetIntervalDecimal, VR, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
REFUSE(fmi3GetIntervalFraction, VR, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
       fmi3IntervalQualifier qualifiers[])
REFUSE(fmi3GetShiftDecimal, VR, fmi3Float64 shifts[])
REFUSE(fmi3GetShiftFraction, VR, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
REFUSE(fmi3SetIntervalDecimal, VR, const fmi3Float64 intervals[])
REFUSE(fmi3SetIntervalFraction, VR, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSE(fmi3SetShiftDecimal, VR, const fmi3Float64 shifts[])
REFUSE(fmi3SetShiftFraction, VR, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
REFUSE(fmi3CompletedIntegratorStep, fmi3Boolean no, fmi3Boolean *enter, fmi3Boolean *terminate)
REFUSE(fmi3SetTime, fmi3Float64 time)
REFUSE(fmi3SetContinuousStates, const fmi3Float64 states[], size_t count)
REFUSE(fmi3GetContinuousStateDerivatives, fmi3Float64 derivatives[], size_t count)
REFUSE(fmi3GetEventIndicators, fmi3Float64 indicators[], size_t count)
REFUSE(fmi3GetContinuousStates, fmi3Float64 states[], size_t count)
REFUSE(fmi3GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t count)
REFUSE(fmi3GetNumberOfEventIndicators, size_t *count)
REFUSE(fmi3GetNumberOfContinuousStates, size_t *count)
REFUSE(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
