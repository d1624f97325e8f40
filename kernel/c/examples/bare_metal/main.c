/*
 * Force of a ball bearing in an interrupt, statistics of it in the main loop.
 *
 * The constants are in flash and need no set-up. The system timer stands for the interrupt of the converter that samples
 * the displacement probes and the shaft encoder.
 */
#include <ballrace.h>

#define COUNTS_PER_REVOLUTION 1024
#define COUNTS_PER_SAMPLE 16
#define CAGE_RATIO 0.4
#define SAMPLES 256

/* Constants as `ballrace bake --language c` writes them: eight balls, 8e9 N/m^1.5, 5 um of radial play. */
static const ballrace_element elements[8] = {
    { 1.0f, 0.0f, 0x0000000000000000 },         { 0.70710677f, 0.70710677f, 0x2000000000000000 },
    { 0.0f, 1.0f, 0x4000000000000000 },         { -0.70710677f, 0.70710677f, 0x6000000000000000 },
    { -1.0f, 0.0f, 0x8000000000000000 },        { -0.70710677f, -0.70710677f, 0xa000000000000000 },
    { 0.0f, -1.0f, 0xc000000000000000 },        { 0.70710677f, -0.70710677f, 0xe000000000000000 },
};
static const ballrace_lumped_radial bearing = {
    .head = { .model = &ballrace_lumped_radial_model, .elements = elements, .element_count = 8 },
    .stiffness = 8e9f,
    .play = 5e-6f,
};

/* Only the interrupt uses these after set-up. */
static ballrace_last_valid last_valid;
static uint64_t shaft, cage, phase_per_count;
static int64_t cage_ratio;

/* Mailbox between the interrupt and the main loop. */
static volatile float force_along_y;
static volatile uint32_t sample_count;

/* Stands for the converter: 8 um of run-out, and a sample that is not a number. */
static void read_probes(uint32_t sample, float displacement[5])
{
    static const float run_out[4] = { 8e-6f, 0.0f, -8e-6f, 0.0f };
    for (int i = 0; i < 5; i++) displacement[i] = 0.0f;
    displacement[0] = run_out[sample / 16 % 4];
    displacement[1] = sample == 100 ? 0.0f / displacement[2] : run_out[(sample / 16 + 3) % 4] - 2e-6f;
}

void sample_interrupt(void)
{
    if (sample_count >= SAMPLES) return;
    float displacement[5], wrench[5];
    read_probes(sample_count, displacement);
    uint64_t next = ballrace_phase_advance_counts(shaft, COUNTS_PER_SAMPLE, phase_per_count);
    cage = ballrace_phase_advance(cage, ballrace_speed_ratio_apply(cage_ratio, ballrace_phase_since(next, shaft)));
    shaft = next;
    ballrace_sample(&bearing.head, &last_valid, displacement, cage, wrench);
    force_along_y = wrench[1];
    sample_count = sample_count + 1;
}

static void print(const char *text)
{
    register int r0 __asm__("r0") = 4;
    register const void *r1 __asm__("r1") = text;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

static void finish(void)
{
    register int r0 __asm__("r0") = 0x18;
    register const void *r1 __asm__("r1") = (const void *)0x20026;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

int main(void)
{
    /* Set-up. */
    phase_per_count = ballrace_phase_per_count(COUNTS_PER_REVOLUTION);
    cage_ratio = ballrace_speed_ratio(CAGE_RATIO);
    ballrace_last_valid_init(&last_valid);
    ballrace_statistics statistics;
    ballrace_statistics_init(&statistics, SAMPLES);

    /* 1000 samples per second of the clock of 25 MHz. */
    *(volatile uint32_t *)0xe000e014 = 25000 - 1;
    *(volatile uint32_t *)0xe000e018 = 0;
    *(volatile uint32_t *)0xe000e010 = 7;

    /* Main loop. */
    uint32_t taken = 0;
    ballrace_block_statistics block;
    for (;;) {
        if (taken == sample_count) continue;
        taken++;
        if (ballrace_statistics_add(&statistics, force_along_y, &block) != BALLRACE_BLOCK_COMPLETE) continue;
        /* The load has a mean towards +Y, and one sample was not a number. */
        int ok = block.mean > 0.0f && block.rms > 0.0f && ballrace_held_count(&last_valid) == 1;
        print(ok ? "bare metal: passed\n" : "bare metal: failed\n");
        finish();
    }
}
