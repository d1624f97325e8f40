#include "board.h"

#define TIMER_CONTROL (*(volatile uint32_t *)0xe000e010)
#define TIMER_RELOAD (*(volatile uint32_t *)0xe000e014)
#define COPROCESSORS (*(volatile uint32_t *)0xe000ed88)

extern uint32_t stack_top, data_start, data_end, data_load, bss_start, bss_end;
void reset(void);
__attribute__((section(".vectors"), used)) static const void *const vectors[2] = { &stack_top, reset };

uint32_t counter_overhead;

static int semihosting(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

/* By a file: the emulator writes the console of the host to its own standard error. */
void print(const char *text)
{
    static int file;
    uint32_t length = 0;
    while (text[length]) length++;
    if (!file) {
        const uintptr_t open[3] = { (uintptr_t)":tt", 4, 3 };
        file = semihosting(0x01, open);
    }
    const uintptr_t write[3] = { (uintptr_t)file, (uintptr_t)text, length };
    semihosting(0x05, write);
}

void print_number(uint32_t number)
{
    char digits[11], *p = digits + 10;
    *p = 0;
    do {
        *--p = (char)('0' + number % 10);
        number /= 10;
    } while (number);
    print(p);
}

void print_hex(uint64_t number)
{
    char digits[17];
    for (int i = 15; i >= 0; i--, number >>= 4) digits[i] = "0123456789abcdef"[number & 15];
    digits[16] = 0;
    print(digits);
}

void counter_start(void)
{
    TIMER_RELOAD = 0xffffff;
    TIMER_VALUE = 0;
    TIMER_CONTROL = 5;
    counter_overhead = 0;
    counter_overhead = COUNT((void)0);
}

#define PATTERN 0xa5a5a5a5u

__attribute__((noinline)) void stack_paint(void)
{
    uint32_t *top = (uint32_t *)__builtin_frame_address(0) - 16;
    for (volatile uint32_t *word = &bss_end; word < top; word++) *word = PATTERN;
}

__attribute__((noinline)) uint32_t stack_used(void)
{
    const volatile uint32_t *word = &bss_end;
    while (*word == PATTERN) word++;
    uintptr_t here = (uintptr_t)__builtin_frame_address(0), deepest = (uintptr_t)word;
    return deepest < here ? (uint32_t)(here - deepest) : 0;
}

void reset(void)
{
#ifdef __ARM_FP
    COPROCESSORS |= 0xf << 20;
    __asm__ volatile("dsb\nisb");
#endif
    const uint32_t *from = &data_load;
    for (volatile uint32_t *to = &data_start; to < &data_end;) *to++ = *from++;
    for (volatile uint32_t *to = &bss_start; to < &bss_end;) *to++ = 0;
    run();
    semihosting(0x18, (const void *)0x20026);
    for (;;) { }
}
