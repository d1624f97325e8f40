/* The yardstick: the same forces written by hand in C, the directions of all elements ready in tables. */
#include "forces.h"

/* Twice the positive part; what the factor does to the load is in the stiffness. */
static inline float positive(float x) { return x + __builtin_fabsf(x); }

/* Radial elements, any number, any play. */
void radial_any(const struct radial *b, float u, float v, float *restrict fx, float *restrict fy)
{
    float x = 0.0f, y = 0.0f;
    for (int j = 0; j < b->count; j++) {
        float d = positive(u * b->cos[j] + v * b->sin[j] - b->play);
        float load = d * __builtin_sqrtf(d);
        x -= load * b->cos[j];
        y -= load * b->sin[j];
    }
    *fx = b->stiffness * x;
    *fy = b->stiffness * y;
}

static inline float pair_load(float radial, float play)
{
    float d = positive(__builtin_fabsf(radial) - play);
    float load = d * __builtin_sqrtf(d);
    return radial < 0.0f ? -load : load;
}

/* An even number, no preload: of two opposite elements at most one is loaded, and they share a root. */
void radial_pairs(const struct radial *b, float u, float v, float *restrict fx, float *restrict fy)
{
    float x = 0.0f, y = 0.0f;
    for (int j = 0; j < b->count / 2; j++) {
        float load = pair_load(u * b->cos[j] + v * b->sin[j], b->play);
        x -= load * b->cos[j];
        y -= load * b->sin[j];
    }
    *fx = b->stiffness * x;
    *fy = b->stiffness * y;
}

/* The same for eight elements, written out. */
void radial_pairs_of_8(const struct radial *b, float u, float v, float *restrict fx, float *restrict fy)
{
    const float *c = b->cos, *s = b->sin, play = b->play;
    float l0 = pair_load(u * c[0] + v * s[0], play);
    float l1 = pair_load(u * c[1] + v * s[1], play);
    float l2 = pair_load(u * c[2] + v * s[2], play);
    float l3 = pair_load(u * c[3] + v * s[3], play);
    *fx = -b->stiffness * (l0 * c[0] + l1 * c[1] + l2 * c[2] + l3 * c[3]);
    *fy = -b->stiffness * (l0 * s[0] + l1 * s[1] + l2 * s[2] + l3 * s[3]);
}

/* Balls whose contact angle follows the displacement, eight of them. */
void angular_of_8(const struct angular *b, const float u[5], float f[5])
{
    float x = 0.0f, y = 0.0f, z = 0.0f, zs = 0.0f, zc = 0.0f;
    float tu = b->arm * u[3], tv = b->arm * u[4];
    for (int j = 0; j < 8; j++) {
        float c = b->cos[j], s = b->sin[j];
        float radial = u[0] * c + u[1] * s;
        float axial = u[2] + tu * s - tv * c;
        float r = b->radial + radial, a = b->axial + axial;
        float excess = (b->radial + r) * radial + (b->axial + a) * axial + b->excess;
        float length = __builtin_sqrtf(b->distance * b->distance + excess);
        float d = positive(excess / (length + b->distance));
        float load = d * __builtin_sqrtf(d) / length;
        float fr = load * r, fz = load * a;
        x -= fr * c;
        y -= fr * s;
        z -= fz;
        zs -= fz * s;
        zc += fz * c;
    }
    f[0] = b->stiffness * x;
    f[1] = b->stiffness * y;
    f[2] = b->stiffness * z;
    f[3] = b->stiffness * b->arm * zs;
    f[4] = b->stiffness * b->arm * zc;
}
