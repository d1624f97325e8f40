#include "subjects.h"
#include "tables.h"

#define FIRST 0x0123456789abcdefu

static ballrace_element elements_3[3], elements_4[4], elements_8[8], elements_9[9], elements_16[16], elements_32[32];
static ballrace_element mirrored_9[9];

#define HEAD(model_, n) { &ballrace_##model_##_model, elements_##n, n }
#define RADIAL(model_, n) { HEAD(model_, n), 8e9f, 1.4f, 5e-6f }
#define ROLLER(model_, n) { HEAD(model_, n), 3e8f, 1.4f, 5e-6f }

/* Designated initialisers, as firmware of C writes them. */
static const ballrace_lumped_radial radial_8 = {
    .head = { .model = &ballrace_lumped_radial_model, .elements = elements_8, .element_count = 8 },
    .stiffness = 8e9f,
    .play = 5e-6f,
};
static const ballrace_lumped_radial radial_3 = RADIAL(lumped_radial, 3), radial_4 = RADIAL(lumped_radial, 4);
static const ballrace_lumped_radial radial_9 = RADIAL(lumped_radial, 9), radial_16 = RADIAL(lumped_radial, 16);
static const ballrace_lumped_radial radial_32 = RADIAL(lumped_radial, 32);
static const ballrace_lumped_radial roller_8 = ROLLER(lumped_radial_line, 8), roller_9 = ROLLER(lumped_radial_line, 9);
static const ballrace_lumped_radial power_8 = { HEAD(lumped_radial_power, 8), 2e9f, 1.4f, 5e-6f };
static const ballrace_lumped_radial power_9 = { HEAD(lumped_radial_power, 9), 2e9f, 1.4f, 5e-6f };

#define BOTH(model_, n) { HEAD(model_, n), 8e9f, 1.5f, 5e-6f, 8e9f, 1.5f, 5e-6f, 0.02f }
static const ballrace_lumped_radial_axial both_8 = BOTH(lumped_radial_axial, 8), both_9 = BOTH(lumped_radial_axial, 9);
static const ballrace_lumped_radial_axial both_mirrored_9 = BOTH(lumped_radial_axial_mirrored, 9);
static const ballrace_lumped_radial_axial both_line_9 = {
    HEAD(lumped_radial_axial_line, 9), 3e8f, 0.0f, 5e-6f, 2e8f, 0.0f, -1e-6f, 0.02f,
};
static const ballrace_lumped_radial_axial both_power_9 = {
    HEAD(lumped_radial_axial_power, 9), 2e9f, 1.4f, -1e-6f, 1e9f, 1.2f, 5e-6f, 0.02f,
};

static ballrace_angular angular_4, angular_8, angular_16, angular_32, angular_mirrored_9;
ballrace_angular angular_9;
static ballrace_linear linear = { .head = { .model = &ballrace_linear_model } };

const ballrace_tabulated tabulated_8 = TABULATED_DE(&ballrace_tabulated_model);
const ballrace_tabulated friction_9 = TABULATED_NDE(&ballrace_tabulated_friction_model);
const ballrace_tabulated friction_mirrored_9 = TABULATED_NDE(&ballrace_tabulated_friction_mirrored_model);

struct subject subjects[SUBJECT_COUNT] = {
    { "linear", &linear.head },
    { "radial 3/2, 3", &radial_3.head },
    { "radial 3/2, 4", &radial_4.head },
    { "radial 3/2, 8", &radial_8.head },
    { "radial 3/2, 9", &radial_9.head },
    { "radial 3/2, 16", &radial_16.head },
    { "radial 3/2, 32", &radial_32.head },
    { "radial 10/9, 8", &roller_8.head },
    { "radial 10/9, 9", &roller_9.head },
    { "radial, any power, 8", &power_8.head },
    { "radial, any power, 9", &power_9.head },
    { "radial and axial 3/2, 8", &both_8.head },
    { "radial and axial 3/2, 9", &both_9.head },
    { "radial and axial 3/2, mirrored, 9", &both_mirrored_9.head },
    { "radial and axial 10/9, 9", &both_line_9.head },
    { "radial and axial, any power, 9", &both_power_9.head },
    { "angular, 4", &angular_4.head },
    { "angular, 8", &angular_8.head },
    { "angular, 9", &angular_9.head },
    { "angular, 16", &angular_16.head },
    { "angular, mirrored, 9", &angular_mirrored_9.head },
    { "tabulated, 8", &tabulated_8.head },
    { "tabulated, friction, 9", &friction_9.head },
    { "tabulated, friction, mirrored, 9", &friction_mirrored_9.head },
};

uint32_t subjects_init(void)
{
    ballrace_geometry geometry = {
        .ball_diameter = 7.94e-3,
        .pitch_diameter = 39.04e-3,
        .inner_conformity = 0.52,
        .outer_conformity = 0.52,
        .contact_angle = 0.0,
        .ball = { 206e9, 0.3 },
        .race = { 206e9, 0.3 },
    };
    uint32_t status = ballrace_geometry_set_clearance(&geometry, 10e-6, NULL);

#define SPACED(n) status |= ballrace_elements_evenly_spaced(elements_##n, n, FIRST)
    SPACED(3);
    SPACED(4);
    SPACED(8);
    SPACED(9);
    SPACED(16);
    SPACED(32);
    status |= ballrace_elements_evenly_spaced(mirrored_9, 9, FIRST);
    status |= ballrace_elements_mirror(mirrored_9, 9);

#define ANGULAR(n) \
    status |= ballrace_angular_init(&angular_##n, &geometry, BALLRACE_DATUM_CENTRED, elements_##n, n, NULL)
    ANGULAR(4);
    ANGULAR(8);
    ANGULAR(9);
    ANGULAR(16);
    ANGULAR(32);
    status |= ballrace_angular_init(&angular_mirrored_9, &geometry, BALLRACE_DATUM_CENTRED, mirrored_9, 9, NULL);
    angular_mirrored_9.head.model = &ballrace_angular_mirrored_model;

    for (int i = 0; i < 25; i++) linear.stiffness[i] = (float)(i + 1) * 1e6f;
    for (int i = 0; i < 5; i++) {
        linear.reference[i] = (float)i * 0x1p-20f;
        linear.force[i] = (float)(i - 2);
    }
    return status;
}
