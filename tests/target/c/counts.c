/* Instructions and stack of every call over the inputs: `name;function;least;most;stack`. */
#include "board.h"
#include "inputs.h"
#include "subjects.h"

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
}

void run(void)
{
    counter_start();
    if (subjects_init() != BALLRACE_OK) {
        print("set-up failed\n");
        return;
    }
    for (int i = 0; i < SUBJECT_COUNT; i++) measure_bearing(&subjects[i]);
}
