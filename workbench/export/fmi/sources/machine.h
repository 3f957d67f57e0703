/* A machine: its numbers, its equations, and the solver that takes it through time. It knows nothing of FMI. */
#ifndef MACHINE_H
#define MACHINE_H

#include "model.h"

/* How far a simulation has come. */
typedef enum { INSTANTIATED, INITIALIZING, RUNNING, TERMINATED } Phase;

/* Everything that a machine is at an instant; without pointers, so that a copy of it is a saved state. */
typedef struct {
    double time;
    double tolerance; /* of a step's error, relative to a state and its typical magnitude */
    double step;      /* s: the solver begins with it */
    double values[VALUES];
    double rates[STATES];
    double outputs[OUTPUTS];
    int known; /* whether rates and outputs belong to the values */
    Phase phase;
} Machine;

/* Numbers have references: 0 is time, then come states, inputs, parameters (what can be set), rates and outputs. */
enum {
    FIRST_VALUE = 1,
    FIRST_RATE = FIRST_VALUE + VALUES,
    FIRST_OUTPUT = FIRST_RATE + STATES,
    REFERENCES = FIRST_OUTPUT + OUTPUTS
};

enum { ADVANCED, STEP_TOO_SMALL, NOT_FINITE };

void machine_start(Machine *machine);
int machine_get(Machine *machine, unsigned int reference, double *value);
int machine_set(Machine *machine, unsigned int reference, double value);
const double *machine_rates(Machine *machine);
int machine_advance(Machine *machine, double end);

#endif
