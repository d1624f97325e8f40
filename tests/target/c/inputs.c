#include "inputs.h"

#define SPECIAL_COUNT 14

static const uint32_t special_bits[SPECIAL_COUNT] = {
    0x00000000, 0x80000000, 0x00000001, 0x800116c2, 0x006ce3ee, 0x360637bd, 0xb716feb5,
    0x3827c5ac, 0x3f800000, 0x7149f2ca, 0x7f7fffff, 0x7fc00000, 0x7f800000, 0xff800000,
};

static float special(uint32_t k)
{
    union { uint32_t bits; float value; } number = { special_bits[k % SPECIAL_COUNT] };
    return number.value;
}

static float random_number(uint64_t *seed)
{
    *seed ^= *seed << 13;
    *seed ^= *seed >> 7;
    *seed ^= *seed << 17;
    return (float)(uint32_t)(*seed >> 40) / 16777216.0f - 0.5f;
}

struct input finite_input(uint32_t i)
{
    uint64_t seed = (uint64_t)i * 0x9e3779b97f4a7c15u + 0x123456789abcdef1u;
    struct input in;
    const float range[5] = { 60e-6f, 60e-6f, 120e-6f, 1e-3f, 1e-3f };
    for (int k = 0; k < 5; k++) in.displacement[k] = random_number(&seed) * range[k];
    in.cage = (uint64_t)i * 0x6a09e667f3bcc908u;
    return in;
}

struct input input(uint32_t i)
{
    struct input in = finite_input(i);
    if (i % 3 == 0) {
        uint32_t k = i / 3;
        in.displacement[k % 5] = special(k / 5);
        in.displacement[(k + 1) % 5] = special(k / 5 + k);
    }
    return in;
}

uint16_t counts(uint32_t i, uint32_t k)
{
    uint32_t hash = (i * 32 + k) * 2654435761u >> 16;
    switch (hash & 7) {
    case 0: return 0;
    case 1: return 0xffff;
    case 2:
    case 3: return 0x8000;
    default: return (uint16_t)(0x8000 + (hash >> 3) % 128 - 64);
    }
}
