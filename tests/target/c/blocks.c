#include "blocks.h"

ballrace_probe block_probes[2];
ballrace_last_valid block_last_valid;
ballrace_probed_bearing block_end;

static const float directions[10] = { 1.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f };

uint32_t block_start(const ballrace_bearing *bearing, uint32_t i)
{
    const ballrace_probe_params params = { -32.768e-3f, 1e-6f, { 400, 65000 }, 2 };
    uint32_t status = ballrace_last_valid_init(&block_last_valid);
    for (int k = 0; k < 2; k++) status |= ballrace_probe_init(&block_probes[k], &params, NULL);
    block_end = (ballrace_probed_bearing){
        .bearing = bearing,
        .last_valid = &block_last_valid,
        .probes = block_probes,
        .directions = directions,
        .channel_count = 2,
        .offset = { 0.0f, 0.0f, 20e-6f, 0.0f, 0.0f },
        .cage_ratio = ballrace_speed_ratio(0.3983),
        .shaft = (uint64_t)i << 48,
        .cage = (uint64_t)i << 40,
    };
    return status;
}

void block_fill(struct block_buffer *buffer, uint32_t i)
{
    for (uint32_t k = 0; k < 2 * BLOCK_SAMPLES; k++) {
        buffer->counts[k] = counts(i, k);
        buffer->signed_counts[k] = (int16_t)((int32_t)counts(i, k) - 0x8000);
        buffer->metres[k] = input(16 * i + k).displacement[k % 2];
    }
}
