/* Force of a deep-groove ball bearing on the desktop: prints status, force and moment of a few displacements. */
#include <ballrace.h>
#include <stdio.h>

#define COUNT 9

int main(void)
{
    ballrace_geometry geometry = {
        .ball_diameter = 7.94e-3,
        .pitch_diameter = 39.04e-3,
        .inner_conformity = 0.52,
        .outer_conformity = 0.52,
        .ball = { .youngs_modulus = 206e9, .poissons_ratio = 0.3 },
        .race = { .youngs_modulus = 206e9, .poissons_ratio = 0.3 },
    };
    ballrace_element elements[COUNT];
    ballrace_angular bearing;
    ballrace_invalid_parameter invalid;

    /* Set-up: checks the parameters once. */
    ballrace_elements_evenly_spaced(elements, COUNT, 0);
    if (ballrace_geometry_set_clearance(&geometry, 10e-6, &invalid) != BALLRACE_OK
        || ballrace_angular_init(&bearing, &geometry, BALLRACE_DATUM_CENTRED, elements, COUNT, &invalid) != BALLRACE_OK) {
        fprintf(stderr, "error: %.*s: value out of range: %g\nexpected %.*s\n", (int)invalid.name_length, invalid.name, invalid.found,
                (int)invalid.expected_length, invalid.expected);
        return 1;
    }

    /* Every sample: invalid input is flagged and replaced by the last valid force. */
    ballrace_last_valid last_valid;
    ballrace_last_valid_init(&last_valid);
    for (int i = 0; i < 4; i++) {
        const float displacement[5] = { 8e-6f * (float)i, -2e-6f, 30e-6f, 0.0f, 0.0f };
        float wrench[5];
        uint64_t cage = ballrace_phase_from_revolutions(0.1 * i);
        uint32_t status = ballrace_sample(&bearing.head, &last_valid, displacement, cage, wrench);
        printf("%u %.9g %.9g %.9g %.9g %.9g\n", (unsigned)status, wrench[0], wrench[1], wrench[2], wrench[3], wrench[4]);
    }
    return 0;
}
