/* Force of a ball bearing in a timer of Zephyr, printed in the main thread. */
#include <ballrace.h>
#include <zephyr/kernel.h>

static const ballrace_element elements[4] = {
    { 1.0f, 0.0f, 0x0000000000000000 },
    { 0.0f, 1.0f, 0x4000000000000000 },
    { -1.0f, 0.0f, 0x8000000000000000 },
    { 0.0f, -1.0f, 0xc000000000000000 },
};
static const ballrace_lumped_radial bearing = {
    .head = { .model = &ballrace_lumped_radial_model, .elements = elements, .element_count = 4 },
    .stiffness = 8e9f,
    .play = 5e-6f,
};

/* Only the timer uses these after set-up. */
static ballrace_last_valid last_valid;
static uint64_t cage;

K_MSGQ_DEFINE(forces, sizeof(float[5]), 8, 4);

/* Stands for the interrupt of the converter. */
static void take_sample(struct k_timer *timer)
{
    ARG_UNUSED(timer);
    const float displacement[5] = { 8e-6f, -2e-6f, 0.0f, 0.0f, 0.0f };
    float wrench[5];
    cage = ballrace_phase_advance(cage, INT64_C(1) << 56);
    ballrace_sample(&bearing.head, &last_valid, displacement, cage, wrench);
    k_msgq_put(&forces, wrench, K_NO_WAIT);
}

K_TIMER_DEFINE(sampling, take_sample, NULL);

int main(void)
{
    ballrace_last_valid_init(&last_valid);
    k_timer_start(&sampling, K_MSEC(1), K_MSEC(1));
    for (int i = 0; i < 16; i++) {
        float wrench[5];
        k_msgq_get(&forces, wrench, K_FOREVER);
        printk("%d mN %d mN\n", (int)(1000.0f * wrench[0]), (int)(1000.0f * wrench[1]));
    }
    return 0;
}
