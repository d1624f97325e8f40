/* Start-up of the board: vectors, FPU, values in RAM. */
#include <stdint.h>

extern uint32_t stack_top, data_start, data_end, data_load, bss_start, bss_end;

int main(void);
void sample_interrupt(void);
void reset(void);
static void stop(void);

/* Vectors of the core up to the system timer, which stands for the interrupt of the converter here. */
__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &stack_top, (const void *)reset, (const void *)stop, (const void *)stop, (const void *)stop, (const void *)stop,
    (const void *)stop, 0, 0, 0, 0, (const void *)stop, (const void *)stop, 0, (const void *)stop,
    (const void *)sample_interrupt,
};

static void stop(void)
{
    for (;;) { }
}

void reset(void)
{
    const uint32_t *from = &data_load;
    for (volatile uint32_t *to = &data_start; to < &data_end;) *to++ = *from++;
    for (volatile uint32_t *to = &bss_start; to < &bss_end;) *to++ = 0;
#ifdef __ARM_FP
    *(volatile uint32_t *)0xe000ed88 |= 0xf << 20;
    __asm__ volatile("dsb\nisb");
#endif
    main();
    stop();
}
