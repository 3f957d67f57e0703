{{ boxed("Replays the study's run: the same readings have to give the same commands. The second turn shows that " ~ name ~ "_init forgets the first.") }}

#include "{{ name }}.h"
#include "vector.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>

int main(void)
{
    const size_t steps = sizeof vector / sizeof vector[0];
    {{ name }}_state state;
    double greatest = 0.0;
    unsigned long failed = 0;
    size_t i;
    int turn;

    for (turn = 0; turn < 2; ++turn) {
        {{ name }}_init(&state, &{{ name }}_study, &vector_start);
        for (i = 0; i < steps; ++i) {
            const double command = (double){{ name }}_step(&state, &{{ name }}_study, &vector[i].reference,
                &vector[i].measurement);
            const double difference = fabs(command - vector[i].command);

            if (difference > greatest) {
                greatest = difference;
            }
            if (!(difference <= vector_bound)) {
                ++failed;
            }
        }
    }
    printf("{{ name }}: %lu steps, twice: greatest difference %.2g {{ e.command_unit }}, bound %.2g {{ e.command_unit }}: %s\n",
        (unsigned long)steps, greatest, vector_bound, failed ? "DIFFERENT" : "equal");
    return failed ? 1 : 0;
}
