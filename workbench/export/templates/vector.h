{{ boxed("What the controller saw and gave in the study's run: " ~ e.title ~ ". " ~ rows|length ~ " samples of " ~ number(e.sample_time) ~ " s. Commands are those realised, in double precision.") }}

#ifndef {{ name|upper }}_VECTOR_H
#define {{ name|upper }}_VECTOR_H

#include "{{ name }}.h"

#include <math.h>

static const double vector_bound = {{ bound }}; /* {{ e.command_unit }} */

static const {{ name }}_measurement vector_start = {{ "{" }}{{ start }}{{ "}" }};

static const struct {
    {{ name }}_reference reference;
    {{ name }}_measurement measurement;
    double command;
} vector[] = {
{% for row in rows %}
    {{ row }},
{% endfor %}
};

#endif
