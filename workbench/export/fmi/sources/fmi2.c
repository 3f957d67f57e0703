/* The machine as FMI 2.0 wants it, for model exchange and co-simulation. */
#include "fmi2.h"

#include <stdlib.h>
#include <string.h>

#include "machine.h"

typedef struct {
    Machine machine;
    const fmi2CallbackFunctions *callbacks;
    char name[NAME_LENGTH];
} Instance;

/* A message is its own format: it has no per cent sign, and few importers fill one in. */
static fmi2Status failed(Instance *instance, const char *message)
{
    if (instance->callbacks != NULL && instance->callbacks->logger != NULL)
        instance->callbacks->logger(instance->callbacks->componentEnvironment, instance->name, fmi2Error,
                                    "logStatusError", message);
    return fmi2Error;
}

static fmi2Status unsupported(fmi2Component component, const char *message)
{
    return failed((Instance *)component, message);
}

/* --- what it is ------------------------------------------------------------------------------------------------- */

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }

EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }

EXPORTED fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean on, size_t count, const fmi2String names[])
{
    (void)component, (void)on, (void)count, (void)names; /* errors are all that is logged */
    return fmi2OK;
}

EXPORTED fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                       const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    Instance *instance;

    (void)type, (void)resources, (void)visible, (void)logging;
    if (guid == NULL || strcmp(guid, TOKEN) != 0)
        return NULL;
    instance = (Instance *)calloc(1, sizeof(Instance));
    if (instance == NULL)
        return NULL;
    if (name != NULL)
        strncpy(instance->name, name, NAME_LENGTH - 1);
    instance->callbacks = callbacks;
    machine_start(&instance->machine);
    return instance;
}

EXPORTED void fmi2FreeInstance(fmi2Component component) { free(component); }

/* --- its phases ------------------------------------------------------------------------------------------------- */

EXPORTED fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                        fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop)
{
    Machine *machine = &((Instance *)component)->machine;

    (void)stop_defined, (void)stop;
    if (tolerance_defined && tolerance > 0.0)
        machine->tolerance = tolerance;
    machine->time = start;
    machine->known = 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    ((Instance *)component)->machine.phase = INITIALIZING;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    ((Instance *)component)->machine.phase = RUNNING;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2Terminate(fmi2Component component)
{
    ((Instance *)component)->machine.phase = TERMINATED;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2Reset(fmi2Component component)
{
    machine_start(&((Instance *)component)->machine);
    return fmi2OK;
}

/* --- its numbers ------------------------------------------------------------------------------------------------ */

EXPORTED fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                fmi2Real values[])
{
    Instance *instance = (Instance *)component;
    size_t i;

    for (i = 0; i < count; i++)
        if (!machine_get(&instance->machine, references[i], &values[i]))
            return failed(instance, "fmi2GetReal: there is no variable with this reference");
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference references[], size_t count,
                                const fmi2Real values[])
{
    Instance *instance = (Instance *)component;
    size_t i;

    for (i = 0; i < count; i++)
        if (!machine_set(&instance->machine, references[i], values[i]))
            return failed(instance, "fmi2SetReal: states, inputs and parameters can be set, no other variables");
    return fmi2OK;
}

#define NO_VARIABLES(Type, name)                                                                                       \
    EXPORTED fmi2Status fmi2Get##name(fmi2Component component, const fmi2ValueReference references[], size_t count,    \
                                      Type values[])                                                                   \
    {                                                                                                                  \
        (void)references, (void)values;                                                                                \
        return count == 0 ? fmi2OK : unsupported(component, "fmi2Get" #name ": all variables are of type Real");       \
    }                                                                                                                  \
    EXPORTED fmi2Status fmi2Set##name(fmi2Component component, const fmi2ValueReference references[], size_t count,    \
                                      const Type values[])                                                             \
    {                                                                                                                  \
        (void)references, (void)values;                                                                                \
        return count == 0 ? fmi2OK : unsupported(component, "fmi2Set" #name ": all variables are of type Real");       \
    }

NO_VARIABLES(fmi2Integer, Integer)
NO_VARIABLES(fmi2Boolean, Boolean)
NO_VARIABLES(fmi2String, String)

EXPORTED fmi2Status fmi2GetDirectionalDerivative(fmi2Component component, const fmi2ValueReference unknowns[],
                                                 size_t unknown_count, const fmi2ValueReference knowns[],
                                                 size_t known_count, const fmi2Real seed[], fmi2Real derivative[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)derivative;
    return unsupported(component, "fmi2GetDirectionalDerivative: not provided");
}

/* --- its state, saved and restored ------------------------------------------------------------------------------ */

EXPORTED fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    if (*state == NULL)
        *state = malloc(sizeof(Machine));
    if (*state == NULL)
        return unsupported(component, "fmi2GetFMUstate: out of memory");
    memcpy(*state, &((Instance *)component)->machine, sizeof(Machine));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    memcpy(&((Instance *)component)->machine, state, sizeof(Machine));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    (void)component;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    (void)component, (void)state;
    *size = sizeof(Machine);
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (size < sizeof(Machine))
        return unsupported(component, "fmi2SerializeFMUstate: fewer bytes than a state takes");
    memcpy(bytes, state, sizeof(Machine));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte bytes[], size_t size,
                                            fmi2FMUstate *state)
{
    if (size != sizeof(Machine))
        return unsupported(component, "fmi2DeSerializeFMUstate: these bytes are no state of this machine");
    if (*state == NULL)
        *state = malloc(sizeof(Machine));
    if (*state == NULL)
        return unsupported(component, "fmi2DeSerializeFMUstate: out of memory");
    memcpy(*state, bytes, sizeof(Machine));
    return fmi2OK;
}

/* --- model exchange --------------------------------------------------------------------------------------------- */

EXPORTED fmi2Status fmi2EnterEventMode(fmi2Component component)
{
    (void)component;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo *info)
{
    (void)component;
    memset(info, 0, sizeof(*info)); /* nothing in it is discrete */
    return fmi2OK;
}

EXPORTED fmi2Status fmi2EnterContinuousTimeMode(fmi2Component component)
{
    (void)component;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2CompletedIntegratorStep(fmi2Component component, fmi2Boolean no_state_before,
                                                fmi2Boolean *enter_event_mode, fmi2Boolean *terminate)
{
    (void)component, (void)no_state_before;
    *enter_event_mode = *terminate = 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetTime(fmi2Component component, fmi2Real time)
{
    Machine *machine = &((Instance *)component)->machine;

    machine->time = time;
    machine->known = 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2SetContinuousStates(fmi2Component component, const fmi2Real states[], size_t count)
{
    Instance *instance = (Instance *)component;

    if (count != STATES)
        return failed(instance, "fmi2SetContinuousStates: another number of states");
    memcpy(instance->machine.values, states, STATES * sizeof(double));
    instance->machine.known = 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetDerivatives(fmi2Component component, fmi2Real derivatives[], size_t count)
{
    Instance *instance = (Instance *)component;

    if (count != STATES)
        return failed(instance, "fmi2GetDerivatives: another number of states");
    memcpy(derivatives, machine_rates(&instance->machine), STATES * sizeof(double));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetEventIndicators(fmi2Component component, fmi2Real indicators[], size_t count)
{
    (void)indicators;
    return count == 0 ? fmi2OK : unsupported(component, "fmi2GetEventIndicators: there are none");
}

EXPORTED fmi2Status fmi2GetContinuousStates(fmi2Component component, fmi2Real states[], size_t count)
{
    Instance *instance = (Instance *)component;

    if (count != STATES)
        return failed(instance, "fmi2GetContinuousStates: another number of states");
    memcpy(states, instance->machine.values, STATES * sizeof(double));
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component component, fmi2Real nominals[], size_t count)
{
    if (count != STATES)
        return unsupported(component, "fmi2GetNominalsOfContinuousStates: another number of states");
    memcpy(nominals, magnitudes, STATES * sizeof(double));
    return fmi2OK;
}

/* --- co-simulation ---------------------------------------------------------------------------------------------- */

EXPORTED fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                                size_t count, const fmi2Integer orders[], const fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return count == 0 ? fmi2OK : unsupported(component, "fmi2SetRealInputDerivatives: inputs are held over a step");
}

EXPORTED fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference references[],
                                                 size_t count, const fmi2Integer orders[], fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return count == 0 ? fmi2OK : unsupported(component, "fmi2GetRealOutputDerivatives: not provided");
}

EXPORTED fmi2Status fmi2DoStep(fmi2Component component, fmi2Real from, fmi2Real step, fmi2Boolean no_state_before)
{
    Instance *instance = (Instance *)component;

    (void)no_state_before;
    if (instance->machine.phase != RUNNING)
        return failed(instance, "fmi2DoStep: the machine has not been initialized, or is terminated");
    switch (machine_advance(&instance->machine, from + step)) {
    case ADVANCED:
        return fmi2OK;
    case STEP_TOO_SMALL:
        return failed(instance, "fmi2DoStep: the solver's step became too small");
    default:
        return failed(instance, "fmi2DoStep: the machine's numbers are beyond all bounds");
    }
}

EXPORTED fmi2Status fmi2CancelStep(fmi2Component component)
{
    return unsupported(component, "fmi2CancelStep: no step goes on behind its call");
}

EXPORTED fmi2Status fmi2GetStatus(fmi2Component component, fmi2StatusKind kind, fmi2Status *value)
{
    (void)component, (void)kind, (void)value; /* no step goes on behind its call */
    return fmi2Discard;
}

EXPORTED fmi2Status fmi2GetRealStatus(fmi2Component component, fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime)
        return fmi2Discard;
    *value = ((Instance *)component)->machine.time;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetIntegerStatus(fmi2Component component, fmi2StatusKind kind, fmi2Integer *value)
{
    (void)component, (void)kind, (void)value;
    return fmi2Discard;
}

EXPORTED fmi2Status fmi2GetBooleanStatus(fmi2Component component, fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)component;
    if (kind != fmi2Terminated)
        return fmi2Discard;
    *value = 0;
    return fmi2OK;
}

EXPORTED fmi2Status fmi2GetStringStatus(fmi2Component component, fmi2StatusKind kind, fmi2String *value)
{
    (void)component, (void)kind, (void)value;
    return fmi2Discard;
}
