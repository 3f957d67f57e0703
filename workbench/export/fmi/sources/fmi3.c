/* The machine as FMI 3.0 wants it, for model exchange and co-simulation. */
#include "fmi3.h"

#include <stdlib.h>
#include <string.h>

#include "machine.h"

typedef struct {
    Machine machine;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
} Instance;

static fmi3Status failed(fmi3Instance any, const char *message)
{
    const Instance *instance = (const Instance *)any;

    if (instance->log != NULL)
        instance->log(instance->environment, fmi3Error, "logStatusError", message);
    return fmi3Error;
}

/* --- what it is ------------------------------------------------------------------------------------------------- */

EXPORTED const char *fmi3GetVersion(void) { return "3.0"; }

EXPORTED fmi3Status fmi3SetDebugLogging(fmi3Instance any, fmi3Boolean on, size_t count, const fmi3String names[])
{
    (void)any, (void)on, (void)count, (void)names; /* errors are all that is logged */
    return fmi3OK;
}

static fmi3Instance made(fmi3String token, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    Instance *instance;

    if (token == NULL || strcmp(token, TOKEN) != 0)
        return NULL;
    instance = (Instance *)calloc(1, sizeof(Instance));
    if (instance == NULL)
        return NULL;
    instance->environment = environment;
    instance->log = log;
    machine_start(&instance->machine);
    return instance;
}

EXPORTED fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                                   fmi3Boolean visible, fmi3Boolean logging,
                                                   fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    return made(token, environment, log);
}

EXPORTED fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                                  fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean event_mode,
                                                  fmi3Boolean early_return, const fmi3ValueReference intermediate[],
                                                  size_t count, fmi3InstanceEnvironment environment,
                                                  fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)event_mode, (void)early_return;
    (void)intermediate, (void)count, (void)update;
    return made(token, environment, log);
}

EXPORTED fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                                        fmi3Boolean visible, fmi3Boolean logging,
                                                        fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                                        fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                                        fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
    (void)clock, (void)lock, (void)unlock;
    return NULL;
}

EXPORTED void fmi3FreeInstance(fmi3Instance any) { free(any); }

/* --- its phases ------------------------------------------------------------------------------------------------- */

EXPORTED fmi3Status fmi3EnterInitializationMode(fmi3Instance any, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                                fmi3Float64 start, fmi3Boolean stop_defined, fmi3Float64 stop)
{
    Instance *instance = (Instance *)any;

    (void)stop_defined, (void)stop;
    if (tolerance_defined && tolerance > 0.0)
        instance->machine.tolerance = tolerance;
    instance->machine.time = start;
    instance->machine.known = 0;
    instance->machine.phase = INITIALIZING;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3ExitInitializationMode(fmi3Instance any)
{
    ((Instance *)any)->machine.phase = RUNNING;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3Terminate(fmi3Instance any)
{
    ((Instance *)any)->machine.phase = TERMINATED;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3Reset(fmi3Instance any)
{
    machine_start(&((Instance *)any)->machine);
    return fmi3OK;
}

#define NO_OTHER_MODE(name)                                                                                            \
    EXPORTED fmi3Status fmi3##name(fmi3Instance any)                                                                   \
    {                                                                                                                  \
        (void)any; /* nothing in it is discrete, or structural */                                                      \
        return fmi3OK;                                                                                                 \
    }

NO_OTHER_MODE(EnterEventMode)
NO_OTHER_MODE(EnterContinuousTimeMode)
NO_OTHER_MODE(EnterStepMode)
NO_OTHER_MODE(EnterConfigurationMode)
NO_OTHER_MODE(ExitConfigurationMode)
NO_OTHER_MODE(EvaluateDiscreteStates)

EXPORTED fmi3Status fmi3UpdateDiscreteStates(fmi3Instance any, fmi3Boolean *needed, fmi3Boolean *terminate,
                                             fmi3Boolean *nominals_changed, fmi3Boolean *states_changed,
                                             fmi3Boolean *next_event_defined, fmi3Float64 *next_event)
{
    (void)any, (void)next_event;
    *needed = *terminate = *nominals_changed = *states_changed = *next_event_defined = false;
    return fmi3OK;
}

/* --- its numbers ------------------------------------------------------------------------------------------------ */

EXPORTED fmi3Status fmi3GetFloat64(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                   fmi3Float64 values[], size_t value_count)
{
    Instance *instance = (Instance *)any;
    size_t i;

    if (count != value_count)
        return failed(any, "fmi3GetFloat64: expected one value for each reference");
    for (i = 0; i < count; i++)
        if (!machine_get(&instance->machine, references[i], &values[i]))
            return failed(any, "fmi3GetFloat64: there is no variable with this reference");
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SetFloat64(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                   const fmi3Float64 values[], size_t value_count)
{
    Instance *instance = (Instance *)any;
    size_t i;

    if (count != value_count)
        return failed(any, "fmi3SetFloat64: expected one value for each reference");
    for (i = 0; i < count; i++)
        if (!machine_set(&instance->machine, references[i], values[i]))
            return failed(any, "fmi3SetFloat64: states, inputs and parameters can be set, no other variables");
    return fmi3OK;
}

#define NO_VARIABLES(name)                                                                                             \
    EXPORTED fmi3Status fmi3Get##name(fmi3Instance any, const fmi3ValueReference references[], size_t count,           \
                                      fmi3##name values[], size_t value_count)                                         \
    {                                                                                                                  \
        (void)references, (void)values, (void)value_count;                                                             \
        return count == 0 ? fmi3OK : failed(any, "fmi3Get" #name ": all variables are of type Float64");               \
    }                                                                                                                  \
    EXPORTED fmi3Status fmi3Set##name(fmi3Instance any, const fmi3ValueReference references[], size_t count,           \
                                      const fmi3##name values[], size_t value_count)                                   \
    {                                                                                                                  \
        (void)references, (void)values, (void)value_count;                                                             \
        return count == 0 ? fmi3OK : failed(any, "fmi3Set" #name ": all variables are of type Float64");               \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

EXPORTED fmi3Status fmi3GetBinary(fmi3Instance any, const fmi3ValueReference references[], size_t count, size_t sizes[],
                                  fmi3Binary values[], size_t value_count)
{
    (void)references, (void)sizes, (void)values, (void)value_count;
    return count == 0 ? fmi3OK : failed(any, "fmi3GetBinary: all variables are of type Float64");
}

EXPORTED fmi3Status fmi3SetBinary(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                  const size_t sizes[], const fmi3Binary values[], size_t value_count)
{
    (void)references, (void)sizes, (void)values, (void)value_count;
    return count == 0 ? fmi3OK : failed(any, "fmi3SetBinary: all variables are of type Float64");
}

EXPORTED fmi3Status fmi3GetClock(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                 fmi3Clock values[])
{
    (void)references, (void)values;
    return count == 0 ? fmi3OK : failed(any, "fmi3GetClock: there are no clocks");
}

EXPORTED fmi3Status fmi3SetClock(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                 const fmi3Clock values[])
{
    (void)references, (void)values;
    return count == 0 ? fmi3OK : failed(any, "fmi3SetClock: there are no clocks");
}

/* --- its state, saved and restored ------------------------------------------------------------------------------ */

EXPORTED fmi3Status fmi3GetFMUState(fmi3Instance any, fmi3FMUState *state)
{
    if (*state == NULL)
        *state = malloc(sizeof(Machine));
    if (*state == NULL)
        return failed(any, "fmi3GetFMUState: out of memory");
    memcpy(*state, &((Instance *)any)->machine, sizeof(Machine));
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SetFMUState(fmi3Instance any, fmi3FMUState state)
{
    memcpy(&((Instance *)any)->machine, state, sizeof(Machine));
    return fmi3OK;
}

EXPORTED fmi3Status fmi3FreeFMUState(fmi3Instance any, fmi3FMUState *state)
{
    (void)any;
    free(*state);
    *state = NULL;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SerializedFMUStateSize(fmi3Instance any, fmi3FMUState state, size_t *size)
{
    (void)any, (void)state;
    *size = sizeof(Machine);
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SerializeFMUState(fmi3Instance any, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (size < sizeof(Machine))
        return failed(any, "fmi3SerializeFMUState: fewer bytes than a state takes");
    memcpy(bytes, state, sizeof(Machine));
    return fmi3OK;
}

EXPORTED fmi3Status fmi3DeserializeFMUState(fmi3Instance any, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    if (size != sizeof(Machine))
        return failed(any, "fmi3DeserializeFMUState: these bytes are no state of this machine");
    if (*state == NULL)
        *state = malloc(sizeof(Machine));
    if (*state == NULL)
        return failed(any, "fmi3DeserializeFMUState: out of memory");
    memcpy(*state, bytes, sizeof(Machine));
    return fmi3OK;
}

/* --- model exchange --------------------------------------------------------------------------------------------- */

EXPORTED fmi3Status fmi3CompletedIntegratorStep(fmi3Instance any, fmi3Boolean no_state_before,
                                                fmi3Boolean *enter_event_mode, fmi3Boolean *terminate)
{
    (void)any, (void)no_state_before;
    *enter_event_mode = *terminate = false;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SetTime(fmi3Instance any, fmi3Float64 time)
{
    Machine *machine = &((Instance *)any)->machine;

    machine->time = time;
    machine->known = 0;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3SetContinuousStates(fmi3Instance any, const fmi3Float64 states[], size_t count)
{
    Machine *machine = &((Instance *)any)->machine;

    if (count != STATES)
        return failed(any, "fmi3SetContinuousStates: another number of states");
    memcpy(machine->values, states, STATES * sizeof(double));
    machine->known = 0;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance any, fmi3Float64 derivatives[], size_t count)
{
    if (count != STATES)
        return failed(any, "fmi3GetContinuousStateDerivatives: another number of states");
    memcpy(derivatives, machine_rates(&((Instance *)any)->machine), STATES * sizeof(double));
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetEventIndicators(fmi3Instance any, fmi3Float64 indicators[], size_t count)
{
    (void)indicators;
    return count == 0 ? fmi3OK : failed(any, "fmi3GetEventIndicators: there are none");
}

EXPORTED fmi3Status fmi3GetContinuousStates(fmi3Instance any, fmi3Float64 states[], size_t count)
{
    if (count != STATES)
        return failed(any, "fmi3GetContinuousStates: another number of states");
    memcpy(states, ((Instance *)any)->machine.values, STATES * sizeof(double));
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance any, fmi3Float64 nominals[], size_t count)
{
    if (count != STATES)
        return failed(any, "fmi3GetNominalsOfContinuousStates: another number of states");
    memcpy(nominals, magnitudes, STATES * sizeof(double));
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance any, size_t *count)
{
    (void)any;
    *count = 0;
    return fmi3OK;
}

EXPORTED fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance any, size_t *count)
{
    (void)any;
    *count = STATES;
    return fmi3OK;
}

/* --- co-simulation ---------------------------------------------------------------------------------------------- */

EXPORTED fmi3Status fmi3DoStep(fmi3Instance any, fmi3Float64 from, fmi3Float64 step, fmi3Boolean no_state_before,
                               fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                               fmi3Float64 *reached)
{
    Instance *instance = (Instance *)any;
    int ended;

    (void)no_state_before;
    *event_needed = *terminate = *early_return = false;
    if (instance->machine.phase != RUNNING)
        return failed(any, "fmi3DoStep: the machine has not been initialized, or is terminated");
    ended = machine_advance(&instance->machine, from + step);
    *reached = instance->machine.time;
    if (ended == ADVANCED)
        return fmi3OK;
    return failed(any, ended == STEP_TOO_SMALL ? "fmi3DoStep: the solver's step became too small"
                                               : "fmi3DoStep: the machine's numbers are beyond all bounds");
}

/* --- what it does not provide ----------------------------------------------------------------------------------- */

EXPORTED fmi3Status fmi3GetOutputDerivatives(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                             const int32_t orders[], fmi3Float64 values[], size_t value_count)
{
    (void)references, (void)count, (void)orders, (void)values, (void)value_count;
    return failed(any, "fmi3GetOutputDerivatives: not provided");
}

EXPORTED fmi3Status fmi3GetDirectionalDerivative(fmi3Instance any, const fmi3ValueReference unknowns[],
                                                 size_t unknown_count, const fmi3ValueReference knowns[],
                                                 size_t known_count, const fmi3Float64 seed[], size_t seed_count,
                                                 fmi3Float64 sensitivity[], size_t sensitivity_count)
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)seed_count;
    (void)sensitivity, (void)sensitivity_count;
    return failed(any, "fmi3GetDirectionalDerivative: not provided");
}

EXPORTED fmi3Status fmi3GetAdjointDerivative(fmi3Instance any, const fmi3ValueReference unknowns[],
                                             size_t unknown_count, const fmi3ValueReference knowns[],
                                             size_t known_count, const fmi3Float64 seed[], size_t seed_count,
                                             fmi3Float64 sensitivity[], size_t sensitivity_count)
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)seed, (void)seed_count;
    (void)sensitivity, (void)sensitivity_count;
    return failed(any, "fmi3GetAdjointDerivative: not provided");
}

EXPORTED fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance any, fmi3ValueReference reference, size_t *count)
{
    (void)reference, (void)count;
    return failed(any, "fmi3GetNumberOfVariableDependencies: they stand in modelDescription.xml");
}

EXPORTED fmi3Status fmi3GetVariableDependencies(fmi3Instance any, fmi3ValueReference dependent, size_t elements[],
                                                fmi3ValueReference independents[], size_t their_elements[],
                                                fmi3DependencyKind kinds[], size_t count)
{
    (void)dependent, (void)elements, (void)independents, (void)their_elements, (void)kinds, (void)count;
    return failed(any, "fmi3GetVariableDependencies: they stand in modelDescription.xml");
}

EXPORTED fmi3Status fmi3GetIntervalDecimal(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                           fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
{
    (void)references, (void)count, (void)intervals, (void)qualifiers;
    return failed(any, "fmi3GetIntervalDecimal: there are no clocks");
}

EXPORTED fmi3Status fmi3GetIntervalFraction(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                            uint64_t counters[], uint64_t resolutions[],
                                            fmi3IntervalQualifier qualifiers[])
{
    (void)references, (void)count, (void)counters, (void)resolutions, (void)qualifiers;
    return failed(any, "fmi3GetIntervalFraction: there are no clocks");
}

EXPORTED fmi3Status fmi3GetShiftDecimal(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                        fmi3Float64 shifts[])
{
    (void)references, (void)count, (void)shifts;
    return failed(any, "fmi3GetShiftDecimal: there are no clocks");
}

EXPORTED fmi3Status fmi3GetShiftFraction(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                         uint64_t counters[], uint64_t resolutions[])
{
    (void)references, (void)count, (void)counters, (void)resolutions;
    return failed(any, "fmi3GetShiftFraction: there are no clocks");
}

EXPORTED fmi3Status fmi3SetIntervalDecimal(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                           const fmi3Float64 intervals[])
{
    (void)references, (void)count, (void)intervals;
    return failed(any, "fmi3SetIntervalDecimal: there are no clocks");
}

EXPORTED fmi3Status fmi3SetIntervalFraction(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                            const uint64_t counters[], const uint64_t resolutions[])
{
    (void)references, (void)count, (void)counters, (void)resolutions;
    return failed(any, "fmi3SetIntervalFraction: there are no clocks");
}

EXPORTED fmi3Status fmi3SetShiftDecimal(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                        const fmi3Float64 shifts[])
{
    (void)references, (void)count, (void)shifts;
    return failed(any, "fmi3SetShiftDecimal: there are no clocks");
}

EXPORTED fmi3Status fmi3SetShiftFraction(fmi3Instance any, const fmi3ValueReference references[], size_t count,
                                         const uint64_t counters[], const uint64_t resolutions[])
{
    (void)references, (void)count, (void)counters, (void)resolutions;
    return failed(any, "fmi3SetShiftFraction: there are no clocks");
}

EXPORTED fmi3Status fmi3ActivateModelPartition(fmi3Instance any, fmi3ValueReference clock, fmi3Float64 time)
{
    (void)clock, (void)time;
    return failed(any, "fmi3ActivateModelPartition: there are no partitions");
}
