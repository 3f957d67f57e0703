{{ boxed(e.recorded.controller.name ~ ": " ~ controller.summary ~ ". " ~ e.title ~ ".") }}
/* Sample time: {{ number(e.sample_time) }} s; the gains are made for it. All numbers are in SI units.
   A call of {{ name }}_step takes, whatever the readings, at most:
   {{ e.operations }}. */

#ifndef {{ guard }}
#define {{ guard }}

{% for struct in structs %}
{% if struct.summary %}
{{ boxed(struct.summary) }}
{% endif %}
typedef struct {
{% for member in struct.members %}
    {{ member.type }} {{ member.name }};{{ " /* " ~ member.note ~ " */" if member.note else "" }}
{% endfor %}
} {{ struct.type }};

{% endfor %}
/* What stays as it is while the controller runs. */
typedef struct {
    {{ name }}_gains gains;
    {{ real }} sample_time;    /* s */
    {{ real }} command_limit;  /* {{ e.command_unit }}: of the amplifier, to either side */
    {{ real }} command_offset; /* {{ e.command_unit }}: added to the command, what holds the machine at rest */
} {{ name }}_settings;

/* Gains and limit of the study. */
extern const {{ name }}_settings {{ name }}_study;

/* The state for a machine at rest with this reading. Call it once before the first step, and whenever
   the controller takes over again. */
void {{ name }}_init({{ name }}_state *state, const {{ name }}_settings *settings,
    const {{ name }}_measurement *measurement);

/* Once every sample time: the command ({{ e.command_unit }}) to give now, within the limit. 0 where the readings
   make it no number: the state then is none either, and stays so until init is called again. */
{{ real }} {{ name }}_step({{ name }}_state *state, const {{ name }}_settings *settings,
    const {{ name }}_reference *reference, const {{ name }}_measurement *measurement);

/* The two halves of a step, for an amplifier that itself says what it gave: the command without offset
   and limit, then what became of it (without the offset), from which an anti-windup learns. */
{{ real }} {{ name }}_command({{ name }}_state *state, const {{ name }}_settings *settings,
    const {{ name }}_reference *reference, const {{ name }}_measurement *measurement);
void {{ name }}_commit({{ name }}_state *state, const {{ name }}_settings *settings, {{ real }} realised);

#endif
