/* Instructions and stack of every call over the inputs: `name;function;least;most;stack`. */
#include "blocks.h"
#include "board.h"
#include "inputs.h"
#include "machine.h"

static const ballrace_bearing *bearing;
static ballrace_last_valid last_valid;
static ballrace_kinematic_state at;
static struct input in;
static float wrench[5], stiffness[25], loads[32];

/* Instructions of one call; not inlined, so that all inputs take the same path to it. */
#define CALL(name, call) __attribute__((noinline)) static uint32_t name(void) { return COUNT(call); }

CALL(force, ballrace_force(bearing, in.displacement, in.cage, wrench))
CALL(force_at, ballrace_force_at(bearing, in.displacement, &at, wrench))
CALL(sample, ballrace_sample(bearing, &last_valid, in.displacement, in.cage, wrench))
CALL(sample_at, ballrace_sample_at(bearing, &last_valid, in.displacement, &at, wrench))
CALL(tangent, ballrace_force_and_stiffness(bearing, in.displacement, &at, wrench, stiffness))
CALL(element_loads, ballrace_element_loads(bearing, in.displacement, &at, loads))

static ballrace_rotor_state motion;
static ballrace_observer_state observed;
static ballrace_shaft shaft;
static ballrace_estimate estimate;
static ballrace_order_tracker tracker;
static ballrace_order_sums sums[LINES];
static ballrace_statistics statistics;
static ballrace_block_statistics block;
static ballrace_envelope envelope;
static ballrace_force_tracker force_tracker;
static uint64_t force_words[12 * ORDERS + 8];
static ballrace_force_line lines[3][ORDERS];
static float amplitudes[2 * LINES], amplitude;

CALL(rotor_step, ballrace_rotor_step(&rotor_on_2, &motion, &shaft))
CALL(rotor_step_of_4, ballrace_rotor_step(&rotor_on_4, &motion, &shaft))
CALL(observer_sample, ballrace_observer_sample(&observer, &observed, &shaft, in.displacement, &estimate))
CALL(observer_sample_of_5, ballrace_observer_sample(&observer_of_5, &observed, &shaft, in.displacement, &estimate))
CALL(order_add, ballrace_order_tracker_add(&tracker, in.displacement[0], at.inner, at.cage, at.ball))
CALL(statistics_add, ballrace_statistics_add(&statistics, in.displacement[0], &block))
CALL(envelope_add, ballrace_envelope_add(&envelope, in.displacement[0], &amplitude))
CALL(force_add, ballrace_force_tracker_add(&force_tracker, in.displacement[0], in.displacement[1], &at))
CALL(force_close, ballrace_force_tracker_close(&force_tracker, lines[0], lines[1], lines[2]))
CALL(advance_counts, in.cage = ballrace_phase_advance_counts(in.cage, (int32_t)(in.cage >> 40), at.inner))
CALL(ratio_apply, in.cage = (uint64_t)ballrace_speed_ratio_apply((int64_t)at.inner, (int64_t)in.cage))

static struct block_buffer buffer;
static float block_wrenches[5 * BLOCK_SAMPLES];
static uint32_t block_statuses[BLOCK_SAMPLES];

#define BLOCK(kind, readings)                                                                                           \
    ballrace_block_##kind(&block_end, readings, BLOCK_SAMPLES, BLOCK_TURNED, BLOCK_SPEED, block_wrenches, block_statuses)

CALL(block_u16, BLOCK(u16, buffer.counts))
CALL(block_i16, BLOCK(i16, buffer.signed_counts))
CALL(block_metres, BLOCK(metres, buffer.metres))
static uint8_t frame[4 * 6];

CALL(log_frame, ballrace_log_frame((uint32_t)in.cage, in.displacement, 4, frame))
CALL(probe_sample, ballrace_probe_sample(&block_probes[0], buffer.counts[2], &amplitude))

static ballrace_fixed_radial fixed;
static ballrace_fixed_radial_counts fixed_force;
static int32_t fixed_u, fixed_v;

static ballrace_fixed_axial fixed_thrust;
static ballrace_fixed_axial_counts fixed_axial_force;

CALL(fixed_axial, ballrace_fixed_axial_force(&fixed_thrust, fixed_v, fixed_u, fixed_v, in.cage, &fixed_axial_force))
CALL(fixed_radial, ballrace_fixed_radial_force(&fixed, fixed_u, fixed_v, in.cage, &fixed_force))

static ballrace_fixed_tabulated fixed_table;
static int32_t fixed_nodes[2 * 19 * 11], fixed_displacement[5], fixed_wrench[5];

CALL(fixed_tabulated, ballrace_fixed_tabulated_force(&fixed_table, fixed_displacement, in.cage, fixed_wrench))

static void measure(const char *name, const char *function, void (*prepare)(uint32_t), uint32_t (*call)(void))
{
    uint32_t least = UINT32_MAX, most = 0, stack = 0;
    for (uint32_t i = 1; i <= INPUT_COUNT; i++) {
        prepare(i);
        if (i <= 3) {
            stack_paint();
            call();
            uint32_t used = stack_used();
            stack = used > stack ? used : stack;
            prepare(i);
        }
        uint32_t count = call();
        least = count < least ? count : least;
        most = count > most ? count : most;
    }
    print(name);
    print(";");
    print(function);
    print(";");
    print_number(least);
    print(";");
    print_number(most);
    print(";");
    print_number(stack);
    print("\n");
}

static void take_input(uint32_t i)
{
    in = input(i);
    at = (ballrace_kinematic_state){ .cage = in.cage, .inner = 2 * in.cage, .inner_speed = 1256.0f };
}

/* Counts of all sizes, and those at which a branch would show. */
static void take_counts(uint32_t i)
{
    static const int32_t special[4] = { 0, INT32_MAX, INT32_MIN, -1 };
    take_input(i);
    fixed_u = i % 7 == 0 ? special[i / 7 % 4] : (int32_t)(i * 2654435761u) >> (i % 13);
    fixed_v = i % 11 == 0 ? special[i / 11 % 4] : (int32_t)(i * 2246822519u) >> (i % 17);
    const int32_t within[5] = { fixed_u >> 5, fixed_v >> 5, fixed_u >> 4, fixed_v >> 6, fixed_v >> 7 };
    for (int k = 0; k < 5; k++) fixed_displacement[k] = i % 4 ? within[k] : k % 2 ? fixed_u : fixed_v;
}

static void take_buffer(uint32_t i)
{
    block_start(bearing, i);
    block_fill(&buffer, i);
}

static void take_reading(uint32_t i)
{
    take_buffer(i);
    ballrace_probe_sample(&block_probes[0], buffer.counts[0], &amplitude);
}

static void measure_bearing(const struct subject *subject)
{
    bearing = subject->bearing;
    ballrace_last_valid_init(&last_valid);
    measure(subject->name, "force", take_input, force);
    measure(subject->name, "force at speed", take_input, force_at);
    measure(subject->name, "force, input checked", take_input, sample);
    measure(subject->name, "force at speed, input checked", take_input, sample_at);
    measure(subject->name, "force and tangent", take_input, tangent);
    measure(subject->name, "element loads", take_input, element_loads);
    measure(subject->name, "block of 16 samples, counts", take_buffer, block_u16);
}

/* The states and speeds of the Rust tests. */
static void take_motion(uint32_t i)
{
    take_input(i);
    const uint64_t cages[4] = { in.cage, 5 * in.cage, in.cage, in.cage };
    ballrace_rotor_state_init(&rotor_on_2, &motion, in.displacement, 3 * in.cage, cages);
    ballrace_observer_state_init(&observer, &observed, start_displacement, 3 * in.cage, cages);
    shaft.angle = 3 * in.cage;
    shaft.speed = i % 7 == 0 ? in.displacement[0] : in.displacement[2] * 1e7f;
}

static void take_motion_of_4(uint32_t i)
{
    take_motion(i);
    const uint64_t cages[4] = { in.cage, 5 * in.cage, in.cage, in.cage };
    ballrace_rotor_state_init(&rotor_on_4, &motion, in.displacement, 3 * in.cage, cages);
}

static void take_sample(uint32_t i)
{
    take_input(i);
    at = (ballrace_kinematic_state){ .cage = in.cage, .inner = 3 * in.cage, .ball = 7 * in.cage };
    const ballrace_kinematic_state start = { 0 };
    ballrace_order_tracker_init(&tracker, order_lines, sums, amplitudes, LINES, 8, at.inner);
    ballrace_statistics_init(&statistics, 64);
    ballrace_envelope_init(&envelope, 3000.0, 500.0, 12800.0);
    ballrace_force_tracker_init(&force_tracker, &ballrace_force_tracker_of_4_orders, force_words, 9, 1 + i % 2, &start);
}

static void take_block(uint32_t i)
{
    take_sample(i);
    if (i % 5) ballrace_force_tracker_add(&force_tracker, in.displacement[0], in.displacement[1], &at);
}

void run(void)
{
    counter_start();
    if (subjects_init() | machine_init()) {
        print("set-up failed\n");
        return;
    }
    for (int i = 0; i < SUBJECT_COUNT; i++) measure_bearing(&subjects[i]);
    bearing = &angular_9.head;
    measure("angular, 9", "block of 16 samples, signed counts", take_buffer, block_i16);
    measure("angular, 9", "block of 16 samples, metres", take_buffer, block_metres);
    const ballrace_fixed_radial_params params = { 8e9, 1.5, 5e-6, 100e-6, 0, 8 };
    double per_count[2];
    ballrace_fixed_radial_init(&fixed, &params, &per_count[0], &per_count[1], NULL);
    measure("radial 3/2, fixed-point, 8", "force", take_counts, fixed_radial);
    const ballrace_fixed_axial_params axial = { 1e9, 1.5, 5e-6, 20e-3, 100e-6, 0, 8 };
    ballrace_fixed_axial_init(&fixed_thrust, &axial, &per_count[0], &per_count[1], NULL);
    measure("axial 3/2, fixed-point, 8", "force", take_counts, fixed_axial);
    const ballrace_fixed_tabulated_params of_table = { 1256.0, 1e-3, fixed_nodes, 2 * 19 * 11 };
    ballrace_fixed_tabulated_init(&fixed_table, &tabulated_8, &of_table, &per_count[0], &per_count[1], NULL);
    measure("tabulated, fixed-point, 8", "force", take_counts, fixed_tabulated);
    measure("log", "frame of 4 readings", take_input, log_frame);
    measure("probe", "reading", take_reading, probe_sample);
    measure("rotor on two angular bearings, 9", "Verlet step", take_motion, rotor_step);
    measure("rotor on four angular bearings, 9", "Verlet step", take_motion_of_4, rotor_step_of_4);
    measure("observer of a rigid rotor, two angular bearings, 5 probes, 9", "sample, one Verlet step", take_motion,
            observer_sample_of_5);
    measure("observer of two bearings, four probes", "sample, two Verlet steps, two speeds", take_motion, observer_sample);
    measure("order tracking, 4 lines", "sample", take_sample, order_add);
    measure("statistics", "sample", take_sample, statistics_add);
    measure("envelope", "sample", take_sample, envelope_add);
    measure("force orders, 4 harmonics", "sample", take_sample, force_add);
    measure("force orders, 4 harmonics", "end of a block", take_block, force_close);
    measure("phase", "advance by encoder counts", take_sample, advance_counts);
    measure("phase", "apply a speed ratio", take_sample, ratio_apply);
}
