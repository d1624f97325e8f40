/* The inputs of the Rust tests: special values, motion with contact on all, some or no elements, all cage angles. */
#pragma once

#include <stdint.h>

#define INPUT_COUNT 700

struct input {
    float displacement[5];
    uint64_t cage;
};

/* Input number `i`. */
struct input input(uint32_t i);

/* Input number `i` without special values. */
struct input finite_input(uint32_t i);

/* Count of reading `k` in the buffer number `i`: rails, counts that stand still, else some micrometres at 1 um a count. */
uint16_t counts(uint32_t i, uint32_t k);
