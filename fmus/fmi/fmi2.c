/* The FMI 2.0 functions for co-simulation. What this FMU says it cannot do ends in fmi2Error. */
#include "fmi2Functions.h"
#include "instance.h"

#define NEED(c)                                                                                   \
    if ((c) == NULL)                                                                              \
    return fmi2Error

/* FMI 2.0 loggers take a printf format, so a percent sign is doubled. */
static void emit(Instance *i, Status status, const char *category, const char *message)
{
    char escaped[2 * REPORT_CAPACITY];
    size_t length = 0;
    for (; *message != '\0' && length + 2 < sizeof escaped; ++message) {
        escaped[length++] = *message;
        if (*message == '%')
            escaped[length++] = '%';
    }
    escaped[length] = '\0';
    if (i->logger != NULL)
        ((fmi2CallbackLogger)i->logger)(i->environment, i->name, (fmi2Status)status, category,
                                        escaped);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean loggingOn)
{
    (void)fmuResourceLocation, (void)visible;
    if (functions == NULL)
        return NULL;
    const char *problem = NULL;
    if (instanceName == NULL || *instanceName == '\0')
        problem = "fmi2Instantiate: the instance has no name.";
    else if (fmuType != fmi2CoSimulation)
        problem = "fmi2Instantiate: this FMU is for co-simulation only.";
    else if (fmuGUID == NULL || !same_text(fmuGUID, model_token))
        problem = "fmi2Instantiate: the GUID is not the one of this library; its "
                  "modelDescription.xml belongs to another build.";
    if (problem == NULL) {
        Instance *i = instance_new(instanceName, emit, (void (*)(void))functions->logger,
                                   functions->componentEnvironment, loggingOn);
        if (i != NULL)
            return i;
        problem = "fmi2Instantiate: memory has run out.";
    }
    if (functions->logger != NULL)
        functions->logger(functions->componentEnvironment, instanceName ? instanceName : "",
                          fmi2Error, "logStatusError", problem);
    return NULL;
}

void fmi2FreeInstance(fmi2Component c) { instance_free(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    NEED(c);
    return (fmi2Status)instance_set_logging(c, __func__, loggingOn, nCategories, categories);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    (void)toleranceDefined, (void)tolerance;
    NEED(c);
    return (fmi2Status)instance_setup(c, __func__, startTime, stopTimeDefined, stopTime);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    NEED(c);
    return (fmi2Status)instance_enter_initialisation(c, __func__);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    NEED(c);
    return (fmi2Status)instance_exit_initialisation(c, __func__);
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    NEED(c);
    return (fmi2Status)instance_terminate(c, __func__);
}

fmi2Status fmi2Reset(fmi2Component c)
{
    NEED(c);
    return (fmi2Status)instance_reset(c, __func__);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize, fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    (void)noSetFMUStatePriorToCurrentPoint;
    NEED(c);
    return (fmi2Status)instance_step(c, __func__, currentCommunicationPoint, communicationStepSize);
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    NEED(c);
    return (fmi2Status)get_reals(c, __func__, vr, nvr, value, nvr);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[])
{
    NEED(c);
    return (fmi2Status)set_reals(c, __func__, vr, nvr, value, nvr);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Integer value[])
{
    NEED(c);
    return (fmi2Status)get_integers(c, __func__, TYPE_INTEGER, vr, nvr, value, 4, nvr);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Integer value[])
{
    NEED(c);
    return (fmi2Status)set_integers(c, __func__, TYPE_INTEGER, vr, nvr, value, 4, nvr);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Boolean value[])
{
    NEED(c);
    return (fmi2Status)get_integers(c, __func__, TYPE_BOOLEAN, vr, nvr, value, 4, nvr);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Boolean value[])
{
    NEED(c);
    return (fmi2Status)set_integers(c, __func__, TYPE_BOOLEAN, vr, nvr, value, 4, nvr);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[])
{
    NEED(c);
    return (fmi2Status)get_strings(c, __func__, vr, nvr, value, nvr);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[])
{
    NEED(c);
    return (fmi2Status)set_strings(c, __func__, vr, nvr, value, nvr);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    NEED(c);
    return (fmi2Status)snapshot_get(c, __func__, FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    NEED(c);
    return (fmi2Status)snapshot_set(c, __func__, FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    NEED(c);
    return (fmi2Status)snapshot_free(c, __func__, FMUstate);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    NEED(c);
    return (fmi2Status)snapshot_size(c, __func__, FMUstate, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[],
                                 size_t size)
{
    NEED(c);
    return (fmi2Status)snapshot_serialise(c, __func__, FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    NEED(c);
    return (fmi2Status)snapshot_deserialise(c, __func__, serializedState, size, FMUstate);
}

/* A step is never pending: fmi2DoStep returns when it is done. */
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    NEED(c);
    if (s != fmi2LastSuccessfulTime || value == NULL)
        return fmi2Discard;
    *value = ((Instance *)c)->clock.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    NEED(c);
    if (s != fmi2Terminated || value == NULL)
        return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

/* The rest: functions of model exchange, and options that the description says are not there. */

static fmi2Status refuse(fmi2Component c, const char *function)
{
    NEED(c);
    return (fmi2Status)instance_complain(c, ERROR, "%s is not supported by this FMU.", function);
}

#define REFUSE(name, ...)                                                                         \
    fmi2Status name(fmi2Component c, ##__VA_ARGS__) { return refuse(c, #name); }

REFUSE(fmi2GetDirectionalDerivative, const fmi2ValueReference u[], size_t nu,
       const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[])
REFUSE(fmi2SetRealInputDerivatives, const fmi2ValueReference vr[], size_t n,
       const fmi2Integer order[], const fmi2Real value[])
REFUSE(fmi2GetRealOutputDerivatives, const fmi2ValueReference vr[], size_t n,
       const fmi2Integer order[], fmi2Real value[])
REFUSE(fmi2CancelStep)
REFUSE(fmi2GetStatus, const fmi2StatusKind s, fmi2Status *value)
REFUSE(fmi2GetIntegerStatus, const fmi2StatusKind s, fmi2Integer *value)
REFUSE(fmi2GetStringStatus, const fmi2StatusKind s, fmi2String *value)
REFUSE(fmi2EnterEventMode)
REFUSE(fmi2NewDiscreteStates, fmi2EventInfo *info)
REFUSE(fmi2EnterContinuousTimeMode)
REFUSE(fmi2CompletedIntegratorStep, fmi2Boolean no, fmi2Boolean *enter, fmi2Boolean *terminate)
REFUSE(fmi2SetTime, fmi2Real time)
REFUSE(fmi2SetContinuousStates, const fmi2Real x[], size_t nx)
REFUSE(fmi2GetDerivatives, fmi2Real derivatives[], size_t nx)
REFUSE(fmi2GetEventIndicators, fmi2Real indicators[], size_t n)
REFUSE(fmi2GetContinuousStates, fmi2Real x[], size_t nx)
REFUSE(fmi2GetNominalsOfContinuousStates, fmi2Real nominals[], size_t nx)
