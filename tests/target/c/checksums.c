/* Checksums of the results of every call: `name;checksum`. */
#include "blocks.h"
#include "board.h"
#include "inputs.h"
#include "machine.h"

static uint64_t checksum;

static void start(void) { checksum = 0xcbf29ce484222325u; }

static void add_bits(uint32_t bits)
{
    for (int i = 0; i < 4; i++, bits >>= 8) checksum = (checksum ^ (bits & 0xff)) * 0x100000001b3u;
}

static void add(const float *values, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        union { float value; uint32_t bits; } number = { values[i] };
        add_bits(number.bits);
    }
}

static void add_phase(uint64_t phase)
{
    add_bits((uint32_t)phase);
    add_bits((uint32_t)(phase >> 32));
}

static void end(const char *name)
{
    print(name);
    print(";");
    print_hex(checksum);
    print("\n");
}

static ballrace_kinematic_state at_speed(const struct input *in)
{
    return (ballrace_kinematic_state){ .cage = in->cage, .inner = 2 * in->cage, .inner_speed = 1256.0f };
}

static void bearing(const struct subject *subject)
{
    const ballrace_bearing *b = subject->bearing;
    float wrench[5], stiffness[25], loads[32];
    ballrace_last_valid held, held_at;
    uint32_t status = ballrace_last_valid_init(&held) | ballrace_last_valid_init(&held_at);
    start();
    add_bits(status);
    for (uint32_t i = 1; i <= INPUT_COUNT; i++) {
        struct input in = finite_input(i);
        ballrace_kinematic_state at = at_speed(&in);
        add_bits(ballrace_force(b, in.displacement, in.cage, wrench));
        add(wrench, 5);
        add_bits(ballrace_force_at(b, in.displacement, &at, wrench));
        add(wrench, 5);
        add_bits(ballrace_force_and_stiffness(b, in.displacement, &at, wrench, stiffness));
        add(wrench, 5);
        add(stiffness, 25);
        add_bits(ballrace_element_loads(b, in.displacement, &at, loads));
        add(loads, b->element_count);
        in = input(i);
        at = at_speed(&in);
        add_bits(ballrace_sample(b, &held, in.displacement, in.cage, wrench));
        add(wrench, 5);
        add_bits(ballrace_sample_at(b, &held_at, in.displacement, &at, wrench));
        add(wrench, 5);
    }
    add_bits(ballrace_held_count(&held));
    add_bits(ballrace_held_count(&held_at));
    end(subject->name);
}

/* Buffers of all kinds, one after the other through the same probes. */
static void blocks(void)
{
    struct block_buffer buffer;
    float wrenches[5 * BLOCK_SAMPLES], there;
    uint32_t statuses[BLOCK_SAMPLES];
    start();
    for (int s = 0; s < SUBJECT_COUNT; s++) {
        add_bits(block_start(subjects[s].bearing, 1));
        for (uint32_t i = 1; i <= 12; i++) {
            block_fill(&buffer, i);
            const uint32_t n = BLOCK_SAMPLES;
            const int64_t turned = BLOCK_TURNED;
            const float speed = BLOCK_SPEED;
            uint32_t all = i % 3 == 0   ? ballrace_block_u16(&block_end, buffer.counts, n, turned, speed, wrenches, statuses)
                           : i % 3 == 1 ? ballrace_block_i16(&block_end, buffer.signed_counts, n, turned, speed, wrenches, statuses)
                                        : ballrace_block_metres(&block_end, buffer.metres, n, turned, speed, wrenches, statuses);
            add_bits(all);
            add(wrenches, 5 * n);
            for (uint32_t k = 0; k < n; k++) add_bits(statuses[k]);
        }
        add_phase(block_end.shaft);
        add_phase(block_end.cage);
        add_bits(ballrace_held_count(&block_last_valid));
        for (int k = 0; k < 2; k++) {
            add_bits(ballrace_probe_held_in_a_row(&block_probes[k]));
            add_bits(ballrace_probe_held_count(&block_probes[k]));
            add_bits(ballrace_probe_sample(&block_probes[k], 40000, &there));
            add(&there, 1);
        }
    }
    for (uint32_t i = 1; i <= INPUT_COUNT; i++) {
        const struct input in = finite_input(i);
        uint8_t frame[4 * 6];
        add_bits(ballrace_log_frame((uint32_t)in.cage, in.displacement, 4, frame));
        for (uint32_t k = 0; k < sizeof frame; k++) add_bits(frame[k]);
    }
    add_bits(ballrace_probe_reset(&block_probes[0]));
    add_bits(ballrace_probe_held_count(&block_probes[0]));
    end("blocks");
}

/* Some micrometres in five counts, and those at which a branch would show. */
static void fixed_displacement(uint32_t i, int32_t displacement[5])
{
    static const int32_t special[4] = { 0, INT32_MAX, INT32_MIN, -1 };
    static const uint32_t factors[5] = { 2654435761u, 2246822519u, 3266489917u, 668265263u, 374761393u };
    for (uint32_t k = 0; k < 5; k++) {
        const int32_t motion = (int32_t)(i * factors[k]) >> (5 + i % 11);
        displacement[k] = (i + k) % 9 == 0 ? special[i / 9 % 4] : motion;
    }
}

/* Counts of all sizes, and those at which a branch would show. */
static void fixed_point(void)
{
    static const int32_t special[4] = { 0, INT32_MAX, INT32_MIN, -1 };
    ballrace_fixed_radial bearing = { { 0 } };
    ballrace_fixed_radial_counts force = { 0, 0, 0 };
    double per_count[2];
    start();
    add_bits(ballrace_fixed_radial_force(&bearing, 0, 0, 0, &force));
    for (uint32_t n = 7; n <= 9; n += 2) {
        const ballrace_fixed_radial_params params = { 8e9, n == 7 ? 1.5 : 1.1, 5e-6, 100e-6, (uint64_t)1 << 60, n };
        add_bits(ballrace_fixed_radial_init(&bearing, &params, &per_count[0], &per_count[1], NULL));
        for (uint32_t i = 1; i <= INPUT_COUNT; i++) {
            const int32_t u = i % 7 == 0 ? special[i / 7 % 4] : (int32_t)(i * 2654435761u) >> (i % 13);
            const int32_t v = i % 11 == 0 ? special[i / 11 % 4] : (int32_t)(i * 2246822519u) >> (i % 17);
            add_bits(ballrace_fixed_radial_force(&bearing, u, v, (uint64_t)i * 0x123456789abcdefu, &force));
            add_bits((uint32_t)force.fx);
            add_bits((uint32_t)force.fy);
            add_bits((uint32_t)force.load);
        }
    }
    ballrace_fixed_axial axial = { { 0 } };
    ballrace_fixed_axial_counts thrust = { 0, 0, 0 };
    const ballrace_fixed_axial_params params = { 1e9, 1.5, 5e-6, 20e-3, 100e-6, (uint64_t)1 << 60, 9 };
    add_bits(ballrace_fixed_axial_init(&axial, &params, &per_count[0], &per_count[1], NULL));
    for (uint32_t i = 1; i <= INPUT_COUNT; i++) {
        const int32_t w = i % 5 == 0 ? special[i / 5 % 4] : (int32_t)(i * 3266489917u) >> (i % 19);
        const int32_t x = i % 7 == 0 ? special[i / 7 % 4] : (int32_t)(i * 2654435761u) >> (i % 13);
        const int32_t y = i % 11 == 0 ? special[i / 11 % 4] : (int32_t)(i * 2246822519u) >> (i % 17);
        add_bits(ballrace_fixed_axial_force(&axial, w, x, y, (uint64_t)i * 0x123456789abcdefu, &thrust));
        add_bits((uint32_t)thrust.fz);
        add_bits((uint32_t)thrust.mx);
        add_bits((uint32_t)thrust.my);
    }
    static int32_t nodes[3 * 19 * 11];
    ballrace_fixed_tabulated table = { { 0 } };
    for (int k = 0; k < 3; k++) {
        const ballrace_tabulated *const of = k == 0 ? &tabulated_8 : k == 1 ? &friction_9 : &friction_mirrored_9;
        const ballrace_fixed_tabulated_params of_table = { 1256.0, 1e-3, nodes, (k == 0 ? 2 : 3) * 19 * 11 };
        add_bits(ballrace_fixed_tabulated_init(&table, of, &of_table, &per_count[0], &per_count[1], NULL));
        for (uint32_t i = 1; i <= INPUT_COUNT; i++) {
            int32_t wrench[5], displacement[5];
            fixed_displacement(i, displacement);
            add_bits(ballrace_fixed_tabulated_force(&table, displacement, (uint64_t)i * 0x123456789abcdefu, wrench));
            for (int j = 0; j < 5; j++) add_bits((uint32_t)wrench[j]);
        }
    }
    end("fixed point");
}

static void phases(void)
{
    start();
    add_phase(ballrace_phase_from_revolutions(-3.3));
    uint64_t per_count = ballrace_phase_per_count(1000), shaft = 0, cage = 0;
    add_phase(per_count);
    add_phase(ballrace_phase_per_count(0));
    int64_t ratio = ballrace_speed_ratio(0.3983);
    add_phase((uint64_t)ratio);
    for (int32_t i = -50; i < 200; i++) {
        uint64_t next = ballrace_phase_advance_counts(shaft, i, per_count);
        cage = ballrace_phase_advance(cage, ballrace_speed_ratio_apply(ratio, ballrace_phase_since(next, shaft)));
        shaft = next;
        add_phase(shaft);
        add_phase(cage);
        add_phase(ballrace_phase_multiple(cage, -i));
    }
    double turns = ballrace_phase_to_revolutions(cage);
    float single = (float)turns;
    add(&single, 1);
    end("phases");
}

static ballrace_shaft shaft_at(uint32_t i)
{
    /* 2^-8 revolution in two steps of 20 us: 613.6 rad/s. */
    return (ballrace_shaft){ .angle = (uint64_t)i << 55, .speed = 613.5923f, .acceleration = 1000.0f };
}

static void rotor(const ballrace_rotor *rotor, const char *name)
{
    const uint64_t cages[4] = { 0, 1ull << 62, 1ull << 61, 3 };
    ballrace_rotor_state state;
    float displacement[5], velocity[5];
    start();
    add_bits(ballrace_rotor_state_init(rotor, &state, start_displacement, 0, cages));
    for (uint32_t i = 0; i < 400; i++) {
        ballrace_shaft shaft = shaft_at(i);
        if (i % 50 == 17) shaft.speed = __builtin_nanf("");
        add_bits(ballrace_rotor_step(rotor, &state, &shaft));
        add_bits(ballrace_rotor_motion(rotor, &state, displacement, velocity));
        add(displacement, 5);
        add(velocity, 5);
    }
    end(name);
}

static void observe(void)
{
    const uint64_t cages[2] = { 0, 1ull << 62 };
    ballrace_observer_state state;
    ballrace_estimate estimate;
    float displacement[5], velocity[5], load[5], rotating_load[5];
    start();
    add_bits(ballrace_observer_state_init(&observer, &state, start_displacement, 0, cages));
    for (uint32_t i = 1; i <= 200; i++) {
        ballrace_shaft shaft = shaft_at(2 * i);
        struct input in = finite_input(i);
        if (i % 20 == 7) in.displacement[i / 20 % PROBES] = __builtin_nanf("");
        for (int k = 0; k < PROBES; k++) in.displacement[k] *= 0x1p-4f;
        add_bits(ballrace_observer_sample(&observer, &state, &shaft, in.displacement, &estimate));
        add_bits(ballrace_observer_motion(&observer, &state, displacement, velocity, load, rotating_load));
        add(estimate.innovation, PROBES);
        add(&estimate.nis, 1);
        add(displacement, 5);
        add(velocity, 5);
        add(load, 5);
        add(rotating_load, 5);
    }
    end("observer");
}

static void indicators(void)
{
    ballrace_order_tracker tracker;
    ballrace_order_sums sums[LINES];
    float amplitudes[2 * LINES], amplitude;
    ballrace_statistics statistics;
    ballrace_block_statistics block;
    ballrace_envelope envelope;
    ballrace_force_tracker force;
    uint64_t words[12 * ORDERS + 8];
    ballrace_force_line outer[ORDERS], inner[ORDERS], element[ORDERS];
    ballrace_kinematic_state at = { 0 };
    start();
    add_bits(ballrace_order_tracker_init(&tracker, order_lines, sums, amplitudes, LINES, 2, 0));
    add_bits(ballrace_statistics_init(&statistics, 64));
    add_bits(ballrace_envelope_init(&envelope, 3000.0, 500.0, 12800.0));
    add_bits(ballrace_envelope_init(&envelope, 6200.0, 500.0, 12800.0));
    add_bits(ballrace_force_tracker_init(&force, &ballrace_force_tracker_of_4_orders, words, 9, 2, &at));
    for (uint32_t i = 1; i <= INPUT_COUNT; i++) {
        struct input in = finite_input(i);
        at.inner = (uint64_t)i << 57;
        at.cage = (uint64_t)i * 0x3333333333333333u >> 5;
        at.ball = (uint64_t)i * 0x123456789abcdefu;
        float x = in.displacement[0] * 0x1p+16f, y = in.displacement[1] * 0x1p+16f;
        uint32_t status = ballrace_order_tracker_add(&tracker, x, at.inner, at.cage, at.ball);
        add_bits(status);
        if (status == BALLRACE_BLOCK_COMPLETE) add(amplitudes, 2 * LINES);
        status = ballrace_statistics_add(&statistics, x, &block);
        add_bits(status);
        if (status == BALLRACE_BLOCK_COMPLETE) add(&block.mean, 5);
        add_bits(ballrace_envelope_add(&envelope, x, &amplitude));
        add(&amplitude, 1);
        status = ballrace_force_tracker_add(&force, x, y, &at);
        add_bits(status);
        if (status == BALLRACE_BLOCK_COMPLETE) {
            add_bits(ballrace_force_tracker_close(&force, outer, inner, element));
            add(outer[0].forward, 4 * ORDERS);
            add(inner[0].forward, 4 * ORDERS);
            add(element[0].forward, 4 * ORDERS);
        }
    }
    end("indicators");
}

/* States of another type, and set-up with parameters outside their range, are rejected. */
static void misuse(void)
{
    ballrace_last_valid held = { { 0 } };
    ballrace_rotor rotor = { 0 };
    ballrace_rotor_state state = { { 0 } };
    ballrace_shaft shaft = { 0 };
    ballrace_angular angular;
    ballrace_geometry geometry = { .ball_diameter = 7.94e-3, .pitch_diameter = 1e-3 };
    ballrace_invalid_parameter invalid;
    float wrench[5];
    start();
    add_bits(ballrace_sample(subjects[0].bearing, &held, start_displacement, 0, wrench));
    add_bits(ballrace_held_count(&held));
    add_bits(ballrace_rotor_step(&rotor, &state, &shaft));
    add_bits(ballrace_rotor_step(&rotor_on_2, &state, &shaft));
    add_bits(ballrace_rotor_state_init(&rotor_on_4, &state, start_displacement, 0, (uint64_t[4]){ 0 }));
    add_bits(ballrace_rotor_step(&rotor_on_2, &state, &shaft));
    add_bits(ballrace_angular_init(&angular, &geometry, BALLRACE_DATUM_CENTRED, angular_9.head.elements, 9, &invalid));
    for (uint32_t i = 0; i < invalid.name_length; i++) add_bits((uint32_t)invalid.name[i]);
    const ballrace_probe_params no_range = { 0.0f, 1e-6f, { 7, 7 }, 0 };
    ballrace_probe probe = { { 0 } };
    add_bits(ballrace_probe_sample(&probe, 0, wrench));
    add_bits(ballrace_probe_init(&probe, &no_range, &invalid));
    for (uint32_t i = 0; i < invalid.name_length; i++) add_bits((uint32_t)invalid.name[i]);
    block_start(subjects[0].bearing, 1);
    block_end.probes = &probe;
    block_end.channel_count = 1;
    add_bits(ballrace_block_u16(&block_end, (const uint16_t[1]){ 7 }, 1, 0, 0.0f, wrench, (uint32_t[1]){ 0 }));
    add_bits(ballrace_angular_init(&angular, &geometry, 2, angular_9.head.elements, 9, NULL));
    end("misuse");
}

void run(void)
{
    if (subjects_init() | machine_init()) {
        print("set-up failed\n");
        return;
    }
    for (int i = 0; i < SUBJECT_COUNT; i++) bearing(&subjects[i]);
    blocks();
    fixed_point();
    phases();
    rotor(&rotor_on_2, "rotor on 2 bearings");
    rotor(&rotor_on_4, "rotor on 4 bearings");
    observe();
    indicators();
    misuse();
}
