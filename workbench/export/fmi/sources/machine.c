#include "machine.h"

#include <float.h>
#include <math.h>
#include <stddef.h>

#define SMALLEST_STEP 1e-9 /* s: an error control that asks for less has met a rate that jumps, or an infinite slope */
#define MOST_JUMPS 100     /* such steps of an interval, after which it is the latter */
#define LONGEST 5.0        /* by what a step is at most and at least longer than the one before */
#define SHORTEST 0.1

static const double *inputs_of(const Machine *machine) { return machine->values + STATES; }

static const double *parameters_of(const Machine *machine) { return machine->values + STATES + INPUTS; }

/* dx/dt = f(t, x, u, p) into `rates`. */
static void rates_at(const Machine *machine, double time, const double *states, double *rates)
{
    plant_rates(time, states, inputs_of(machine), parameters_of(machine), rates);
}

/* y = g(t, x, u, p) into the machine's outputs. */
static void read_outputs(Machine *machine)
{
    plant_outputs(machine->time, machine->values, inputs_of(machine), parameters_of(machine), machine->outputs);
}

static void evaluate(Machine *machine)
{
    if (machine->known)
        return;
    rates_at(machine, machine->time, machine->values, machine->rates);
    read_outputs(machine);
    machine->known = 1;
}

void machine_start(Machine *machine)
{
    int i;

    machine->time = 0.0;
    machine->tolerance = TOLERANCE;
    machine->step = FIRST_STEP;
    for (i = 0; i < VALUES; i++)
        machine->values[i] = start_values[i];
    machine->known = 0;
    machine->phase = INSTANTIATED;
}

/* Whether there is such a number; it goes into `value`. */
int machine_get(Machine *machine, unsigned int reference, double *value)
{
    if (reference >= REFERENCES)
        return 0;
    if (reference >= FIRST_RATE)
        evaluate(machine);
    if (reference >= FIRST_OUTPUT)
        *value = machine->outputs[reference - FIRST_OUTPUT];
    else if (reference >= FIRST_RATE)
        *value = machine->rates[reference - FIRST_RATE];
    else
        *value = reference >= FIRST_VALUE ? machine->values[reference - FIRST_VALUE] : machine->time;
    return 1;
}

/* Whether there is such a number, one that can be set. */
int machine_set(Machine *machine, unsigned int reference, double value)
{
    if (reference < FIRST_VALUE || reference >= FIRST_RATE)
        return 0;
    machine->values[reference - FIRST_VALUE] = value;
    machine->known = 0;
    return 1;
}

const double *machine_rates(Machine *machine)
{
    evaluate(machine);
    return machine->rates;
}

/* The slopes of a step of `h` behind the first, which is there; `trial` becomes the states at its end. */
static void further_slopes(const Machine *machine, double time, double h, double slopes[STAGES][STATES],
                           double trial[STATES])
{
    int i, j, k;

    for (i = 1; i < STAGES; i++) {
        for (k = 0; k < STATES; k++) {
            double sum = 0.0;
            for (j = 0; j < i; j++)
                sum += stages[i][j] * slopes[j][k];
            trial[k] = machine->values[k] + h * sum;
        }
        rates_at(machine, time + nodes[i] * h, trial, slopes[i]);
    }
}

/* The estimated error of a step over what is allowed, the largest of all states; negative if it is no number. */
static double error_of(const Machine *machine, double h, double slopes[STAGES][STATES], const double *trial)
{
    double worst = 0.0;
    int i, k;

    for (k = 0; k < STATES; k++) {
        double sum = 0.0, ratio;
        for (i = 0; i < STAGES; i++)
            sum += errors[i] * slopes[i][k];
        ratio = fabs(h * sum) / (machine->tolerance * (magnitudes[k] + fmax(fabs(machine->values[k]), fabs(trial[k]))));
        if (!(ratio <= DBL_MAX))
            return -1.0;
        worst = fmax(worst, ratio);
    }
    return worst;
}

static double factor_of(double worst)
{
    if (worst < 0.0)
        return SHORTEST;
    return worst < 1e-4 ? LONGEST : fmin(LONGEST, fmax(SHORTEST, 0.9 * pow(worst, -1.0 / ORDER)));
}

/* Advance to the time `end` with the inputs held, by steps of a Runge-Kutta pair whose error is controlled. */
int machine_advance(Machine *machine, double end)
{
    double slopes[STAGES][STATES], trial[STATES], time = machine->time, step = machine->step;
    int k, jumps = 0;

    machine->known = 0;
    rates_at(machine, time, machine->values, slopes[0]);
    while (time < end) {
        double left = end - time, h, worst, next;
        int last = step >= left * (1.0 - 1e-9);

        h = last ? left : fmin(step, 0.5 * left);
        further_slopes(machine, time, h, slopes, trial);
        worst = error_of(machine, h, slopes, trial);
        next = h * factor_of(worst);
        if (worst < 0.0 || worst > 1.0) {
            if (h > SMALLEST_STEP) {
                step = fmax(next, SMALLEST_STEP);
                continue;
            }
            if (worst < 0.0 || ++jumps > MOST_JUMPS)
                return worst < 0.0 ? NOT_FINITE : STEP_TOO_SMALL;
            step = h;
        } else if (!last)
            step = next;
        else if (step < LONGEST * h) /* the last step of an interval shortens none */
            step = fmax(step, next);
        time = last ? end : time + h;
        for (k = 0; k < STATES; k++) {
            machine->values[k] = trial[k];
            slopes[0][k] = slopes[STAGES - 1][k];
        }
        machine->time = time;
    }
    machine->step = step;
    return ADVANCED;
}
