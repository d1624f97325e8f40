/* Checksums of the results of every call: `name;checksum`. */
#include "board.h"
#include "inputs.h"
#include "subjects.h"

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

void run(void)
{
    if (subjects_init() != BALLRACE_OK) {
        print("set-up failed\n");
        return;
    }
    for (int i = 0; i < SUBJECT_COUNT; i++) bearing(&subjects[i]);
    phases();
}
