/* A DC motor that turns a load against Coulomb friction, as an FMU of another maker: FMI 2.0, co-simulation alone, angles
 * in degrees, steps of 0.1 ms by Euler's method. For tests it fails at a time that can be set, and crashes where it
 * sticks fast. */
#include <math.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { VOLTAGE, COULOMB, FAILS_AT, START_ANGLE, ANGLE, SPEED, CURRENT, VARIABLES };

typedef void (*Logger)(void *environment, const char *name, int status, const char *category, const char *message, ...);

typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*step_finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    double values[VARIABLES];
    double angle, speed; /* rad, rad/s */
    const Callbacks *callbacks;
} Motor;

static const double torque_per_ampere = 0.5, resistance = 2.0, inertia = 0.02, viscous = 0.05, slope = 0.01;
static const double degree = 3.14159265358979323846 / 180.0;

static int failed(Motor *motor, const char *message)
{
    motor->callbacks->logger(motor->callbacks->environment, "motor", 3, "error", message);
    return 3;
}

static void show(Motor *motor)
{
    motor->values[ANGLE] = motor->angle / degree;
    motor->values[SPEED] = motor->speed / degree;
    motor->values[CURRENT] = (motor->values[VOLTAGE] - torque_per_ampere * motor->speed) / resistance;
}

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks,
                      int visible, int logging)
{
    Motor *motor;

    (void)name, (void)type, (void)resources, (void)visible, (void)logging;
    if (strcmp(guid, "a motor of another maker") != 0)
        return NULL;
    motor = (Motor *)callbacks->allocate(1, sizeof(Motor));
    motor->callbacks = callbacks;
    motor->values[COULOMB] = 0.4;
    motor->values[FAILS_AT] = 1e9;
    return motor;
}

void fmi2FreeInstance(void *motor) { ((Motor *)motor)->callbacks->release(motor); }

int fmi2SetupExperiment(void *motor, int has_tolerance, double tolerance, double start, int has_stop, double stop)
{
    (void)motor, (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return 0;
}

int fmi2EnterInitializationMode(void *motor)
{
    (void)motor;
    return 0;
}

int fmi2ExitInitializationMode(void *any)
{
    Motor *motor = (Motor *)any;

    if (motor->values[COULOMB] < 0.0)
        return failed(motor, "coulomb is negative");
    motor->angle = motor->values[START_ANGLE] * degree;
    return 0;
}

int fmi2Terminate(void *motor)
{
    (void)motor;
    return 0;
}

int fmi2SetReal(void *any, const unsigned int references[], size_t count, const double values[])
{
    Motor *motor = (Motor *)any;
    size_t i;

    for (i = 0; i < count; i++) {
        if (references[i] > START_ANGLE)
            return failed(motor, "outputs cannot be set");
        motor->values[references[i]] = values[i];
    }
    return 0;
}

int fmi2GetReal(void *any, const unsigned int references[], size_t count, double values[])
{
    Motor *motor = (Motor *)any;
    size_t i;

    show(motor);
    for (i = 0; i < count; i++)
        values[i] = motor->values[references[i]];
    return 0;
}

int fmi2DoStep(void *any, double from, double step, int no_state_before)
{
    Motor *motor = (Motor *)any;
    int i, count = (int)ceil(step / 1e-4 - 1e-6);
    double h = step / count;

    (void)no_state_before;
    if (motor->values[COULOMB] > 100.0)
        raise(SIGKILL);
    if (from + step > motor->values[FAILS_AT])
        return failed(motor, "the winding has burnt through");
    for (i = 0; i < count; i++) {
        double current = (motor->values[VOLTAGE] - torque_per_ampere * motor->speed) / resistance;
        double friction = motor->values[COULOMB] * tanh(motor->speed / slope) + viscous * motor->speed;

        motor->speed += h * (torque_per_ampere * current - friction) / inertia;
        motor->angle += h * motor->speed;
    }
    return 0;
}
