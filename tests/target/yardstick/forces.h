#pragma once

struct radial {
    float cos[8], sin[8];
    int count;
    float play, stiffness;
};

struct angular {
    float cos[8], sin[8];
    float radial, axial, distance, excess, arm, stiffness;
};

void radial_any(const struct radial *b, float u, float v, float *restrict fx, float *restrict fy);
void radial_pairs(const struct radial *b, float u, float v, float *restrict fx, float *restrict fy);
void radial_pairs_of_8(const struct radial *b, float u, float v, float *restrict fx, float *restrict fy);
void angular_of_8(const struct angular *b, const float u[5], float f[5]);
