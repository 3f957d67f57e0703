{{ boxed("The controller as the program's own loop calls it, which hands over reference, readings, state and gains as rows of numbers.") }}

#include "{{ name }}.h"

void lockstep_init(const double *measurement, double *state, const double *gains);
double lockstep_command(const double *reference, const double *measurement, double *state, const double *gains,
    double sample_time);
void lockstep_commit(double realised, double *state, const double *gains, double sample_time);

static {{ name }}_settings settings_of(const double *gains, double sample_time)
{
    {{ name }}_settings settings = {{ name }}_study;

    settings.sample_time = sample_time;
{% for path, place in gains %}
    settings.gains.{{ path }} = gains[{{ place }}];
{% else %}
    (void)gains;
{% endfor %}
    return settings;
}

static {{ name }}_measurement measurement_of(const double *readings)
{
    {{ name }}_measurement measurement = {{ "{0}" }};

{% for path, place in measurement %}
    measurement.{{ path }} = readings[{{ place }}];
{% else %}
    (void)readings;
{% endfor %}
    return measurement;
}

static {{ name }}_state state_of(const double *numbers)
{
    {{ name }}_state state = {{ "{0}" }};

{% for path, place in state %}
    state.{{ path }} = numbers[{{ place }}];
{% else %}
    (void)numbers;
{% endfor %}
    return state;
}

static void keep(const {{ name }}_state *state, double *numbers)
{
{% for path, place in state %}
    numbers[{{ place }}] = state->{{ path }};
{% else %}
    (void)state;
    (void)numbers;
{% endfor %}
}

void lockstep_init(const double *measurement, double *state, const double *gains)
{
    const {{ name }}_settings settings = settings_of(gains, {{ name }}_study.sample_time);
    const {{ name }}_measurement readings = measurement_of(measurement);
    {{ name }}_state own;

    {{ name }}_init(&own, &settings, &readings);
    keep(&own, state);
}

double lockstep_command(const double *reference, const double *measurement, double *state, const double *gains,
    double sample_time)
{
    const {{ name }}_settings settings = settings_of(gains, sample_time);
    const {{ name }}_measurement readings = measurement_of(measurement);
    {{ name }}_reference wanted = {{ "{0}" }};
    {{ name }}_state own = state_of(state);
    double command;

{% for path, place in reference %}
    wanted.{{ path }} = reference[{{ place }}];
{% else %}
    (void)reference;
{% endfor %}
    command = {{ name }}_command(&own, &settings, &wanted, &readings);
    keep(&own, state);
    return command;
}

void lockstep_commit(double realised, double *state, const double *gains, double sample_time)
{
    const {{ name }}_settings settings = settings_of(gains, sample_time);
    {{ name }}_state own = state_of(state);

    {{ name }}_commit(&own, &settings, realised);
    keep(&own, state);
}
