/* Counts the yardstick's instructions as the Rust images do: the system timer under -icount shift=8. */
#include "forces.h"
#include <stdint.h>

#define TIMER_CONTROL (*(volatile uint32_t *)0xe000e010)
#define TIMER_RELOAD (*(volatile uint32_t *)0xe000e014)
#define TIMER_VALUE (*(volatile uint32_t *)0xe000e018)
#define COPROCESSORS (*(volatile uint32_t *)0xe000ed88)

extern uint32_t stack_top;
void reset(void);
__attribute__((section(".vectors"), used)) static const void *vectors[2] = { &stack_top, reset };

static int semihosting(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void print(const char *text) { semihosting(0x04, text); }

static void print_number(uint32_t n)
{
    char digits[11], *p = digits + 10;
    for (*p = 0; n || !p[0]; n /= 10) {
        *--p = (char)('0' + n % 10);
        if (n < 10) break;
    }
    print(p);
}

static uint32_t bracket;

#define COUNT(call) __extension__({                                  \
    uint32_t before = TIMER_VALUE;                                   \
    call;                                                            \
    uint32_t after = TIMER_VALUE;                                    \
    (((before - after) & 0xffffff) * 40 + 128) / 256 - bracket;      \
})

static void report(const char *name, uint32_t count)
{
    print(name);
    print(";");
    print_number(count);
    print("\n");
}

#define H 0.70710678f
static struct radial radial = {
    { 1, H, 0, -H, -1, -H, 0, H }, { 0, H, 1, H, 0, -H, -1, -H }, 8, 5e-6f, 8e9f,
};
static struct angular angular = {
    { 1, H, 0, -H, -1, -H, 0, H }, { 0, H, 1, H, 0, -H, -1, -H },
    3.12e-4f, 0.0f, 3.17e-4f, -3e-9f, 19.7e-3f, 8e9f,
};

static void measure(void)
{
    float fx, fy, f[5];
    const float u[5] = { 12e-6f, -7e-6f, 20e-6f, 1e-4f, -2e-4f };
    bracket = COUNT((void)0);
    report("radial 3/2, plain loop", COUNT(radial_any(&radial, u[0], u[1], &fx, &fy)));
    report("radial 3/2, opposite elements share a root", COUNT(radial_pairs(&radial, u[0], u[1], &fx, &fy)));
    report("radial 3/2, the same written out for 8", COUNT(radial_pairs_of_8(&radial, u[0], u[1], &fx, &fy)));
    report("angular", COUNT(angular_of_8(&angular, u, f)));
}

void reset(void)
{
    COPROCESSORS |= 0xf << 20;
    __asm__ volatile("dsb\nisb");
    TIMER_RELOAD = 0xffffff;
    TIMER_VALUE = 0;
    TIMER_CONTROL = 5;
    measure();
    semihosting(0x18, (const void *)0x20026);
    for (;;) { }
}
