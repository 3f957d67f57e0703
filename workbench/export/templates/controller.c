{{ boxed(e.recorded.controller.name ~ ": " ~ controller.summary ~ ". " ~ e.title ~ ".") }}

#include "{{ name }}.h"

#include <math.h>

{% for helper in e.helpers %}
{{ helper }}
{% endfor %}
static {{ real }} saturated({{ real }} command, {{ real }} limit)
{
    if (command > limit) {
        return limit;
    }
    return command >= -limit ? command : command < -limit ? -limit : {{ number(0.0) }};
}

const {{ name }}_settings {{ name }}_study = {
    .gains = {
{% for line in e.values %}
{{ line }}
{% else %}
        .none = 0,
{% endfor %}
    },
    .sample_time = {{ number(e.sample_time) }},
    .command_limit = {{ number(e.limit) }},
    .command_offset = {{ number(e.offset) }},
};

void {{ name }}_init({{ name }}_state *state, const {{ name }}_settings *settings,
    const {{ name }}_measurement *measurement)
{
{% for line in e.body(e.recorded.start, "settings", "measurement") %}
{{ line }}
{% endfor %}
}

{{ real }} {{ name }}_command({{ name }}_state *state, const {{ name }}_settings *settings,
    const {{ name }}_reference *reference, const {{ name }}_measurement *measurement)
{
{% for line in e.body(e.recorded.step, "state", "settings", "reference", "measurement") %}
{{ line }}
{% endfor %}
}

void {{ name }}_commit({{ name }}_state *state, const {{ name }}_settings *settings, {{ real }} realised)
{
{% for line in e.body(e.recorded.commit, "state", "settings", "realised") %}
{{ line }}
{% endfor %}
}

{{ real }} {{ name }}_step({{ name }}_state *state, const {{ name }}_settings *settings,
    const {{ name }}_reference *reference, const {{ name }}_measurement *measurement)
{
    const {{ real }} command = {{ name }}_command(state, settings, reference, measurement);
    const {{ real }} offset = settings->command_offset;
    const {{ real }} realised = saturated(command + offset, settings->command_limit);

    {{ name }}_commit(state, settings, realised - offset);
    return realised;
}
