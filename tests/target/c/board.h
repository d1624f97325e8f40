/* Start-up, console, timer and stack of the emulated MPS2 board with a Cortex-M4F. */
#pragma once

#include <stdint.h>

void print(const char *text);
void print_number(uint32_t number);
void print_hex(uint64_t number);

/* Starts the timer. Call once. */
void counter_start(void);

/* Instructions of two readings of the timer around nothing. */
extern uint32_t counter_overhead;

#define TIMER_VALUE (*(volatile uint32_t *)0xe000e018)

/* Instructions between two readings: under -icount shift=8 an instruction takes 256 ns, and a tick 40 ns. */
static inline uint32_t counter_instructions(uint32_t before, uint32_t after)
{
    return (((before - after) & 0xffffff) * 40 + 128) / 256;
}

#define COUNT(call) __extension__({                              \
    uint32_t before_ = TIMER_VALUE;                              \
    call;                                                        \
    uint32_t after_ = TIMER_VALUE;                               \
    counter_instructions(before_, after_) - counter_overhead;    \
})

/* Fills the free stack with a pattern. */
void stack_paint(void);

/* Greatest number of bytes in use below the caller since `stack_paint`. */
uint32_t stack_used(void);

/* The program; the emulator ends after it. */
void run(void);
