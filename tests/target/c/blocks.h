/* Buffers of two interleaved channels. */
#pragma once

#include "ballrace.h"
#include "inputs.h"

#define BLOCK_SAMPLES 16
#define BLOCK_TURNED INT64_C(0x0123456789abcdef)
#define BLOCK_SPEED 1256.0f

/* Readings of a buffer as the converter, and as something before the program, deliver them. */
struct block_buffer {
    uint16_t counts[2 * BLOCK_SAMPLES];
    int16_t signed_counts[2 * BLOCK_SAMPLES];
    float metres[2 * BLOCK_SAMPLES];
};

extern ballrace_probe block_probes[2];
extern ballrace_last_valid block_last_valid;
extern ballrace_probed_bearing block_end;

/* Begins anew with buffer number `i` at a bearing; returns the status bits of all calls. */
uint32_t block_start(const ballrace_bearing *bearing, uint32_t i);

/* Fills the buffer number `i`. */
void block_fill(struct block_buffer *buffer, uint32_t i);
