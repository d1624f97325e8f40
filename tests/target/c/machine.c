#include "machine.h"

#define STEP 2e-5f

const float start_displacement[5] = { 0.0f, 0.0f, 60e-6f, 0.0f, 0.0f };

const ballrace_order_line order_lines[LINES] = { { 1, 0, 0 }, { 0, 9, 0 }, { 9, -9, 0 }, { 0, 0, 2 } };

static const ballrace_unbalance unbalance = { .moment = 120e-6, .angle = 0.3, .station = 0.02 };

/* 6 kg with an axial load. */
static const ballrace_rotor_params params = {
    .mass = 6.0,
    .diametral_inertia = 0.030,
    .polar_inertia = 0.006,
    .damping = { [0] = 400.0, [6] = 400.0, [12] = 400.0, [18] = 0.4, [24] = 0.4 },
    .gravity = { 0.0, -9.80665, 0.0 },
    .load = { 0.0, 0.0, 60.0, 0.0, 0.0 },
    .unbalances = &unbalance,
    .unbalance_count = 1,
};

static const ballrace_rotor_bearing bearings[4] = {
    { .bearing = &angular_9.head, .cage_ratio = 0.3983, .station = -0.1f },
    { .bearing = &angular_9.head, .cage_ratio = 0.3983, .station = 0.1f },
    { .bearing = &angular_9.head, .cage_ratio = 0.41, .ball_ratio = -2.3, .outer_ratio = 0.1, .station = -0.05f },
    { .bearing = &angular_9.head, .cage_ratio = 0.39, .station = 0.05f },
};

ballrace_rotor rotor_on_2, rotor_on_4;
ballrace_observer observer;

#define GAINS (20 * PROBES + PROBES * PROBES)

static float gains[2 * GAINS], probes[5 * PROBES];

/* Numbers without pattern that are exact in both languages. */
static float exact(int i, int n) { return (float)(i * 37 % n - n / 2); }

uint32_t machine_init(void)
{
    for (int i = 0; i < 2 * GAINS; i++) {
        int part = i % GAINS / (5 * PROBES);
        const float scale[5] = { 0x1p-12f, 0x1p-2f, 0x1p+8f, 0x1p+7f, 0x1p+10f };
        gains[i] = exact(i, 101) * scale[part];
    }
    for (int i = 0; i < 5 * PROBES; i++) probes[i] = exact(i, 19) * 0x1p-4f;
    const ballrace_observer_params observer_params = {
        .probes = probes,
        .gains = gains,
        .gain_count = 2,
        .substeps = 2,
        .step = STEP,
        .first_speed = 100.0f,
        .speed_density = 0x1p-7f,
        .load_retention = 0.875f,
        .gate = 50.0f,
    };
    return ballrace_rotor_init(&rotor_on_2, &ballrace_rotor_on_2_bearings, &params, bearings, STEP, NULL)
        | ballrace_rotor_init(&rotor_on_4, &ballrace_rotor_on_4_bearings, &params, bearings, STEP, NULL)
        | ballrace_observer_init(&observer, &ballrace_observer_of_2_bearings_4_probes, &params, bearings, &observer_params, NULL);
}
