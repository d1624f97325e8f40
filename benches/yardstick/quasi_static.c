/* The yardstick of the quasi-static rung: what an engineer writes in C for sixteen balls of Harris' 218 bearing.
 *
 * Six plain Newton steps a ball on the two components of its centre, with the stiffness of both contacts as the matrix
 * and the inertia loads at the current angles; no safeguard. Outer race control, friction at the outer race.
 *
 * Reads the number of states and, a line each, u v w thu thv; then for every line "runs" on its input it goes through all
 * states that many times and prints the nanoseconds of processor time and a sum of the forces.
 * gcc -O3 -fno-math-errno quasi_static.c -lm
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { BALLS = 16, STEPS = 6, MOST = 4096 };

static const double D = 22.23e-3, PITCH = 125.26e-3, GROOVE = 11.63e-3, K_I = 1293554.65 * 31622.776601683792,
                    K_O = 1345533.20 * 31622.776601683792, MASS = 0.04486541, SPEED = 10000.0 * 2 * M_PI / 60;
static double cosines[BALLS], sines[BALLS], alpha0_cos, alpha0_sin, arm, distance;

static void ball(double a_r, double a_z, double *radial, double *axial) {
    const double length = GROOVE - 0.5 * D, ratio = D / PITCH, inertia = MASS * D * D / 10;
    double s = sqrt(a_r * a_r + a_z * a_z);
    double x = 0.5 * s * a_r / s, z = 0.5 * s * a_z / s;
    double q_i = 0, c_i = 1, s_i = 0;
    for (int k = 0; k < STEPS; k++) {
        double l_o = sqrt(x * x + z * z), y_r = a_r - x, y_z = a_z - z, l_i = sqrt(y_r * y_r + y_z * y_z);
        double c_o = x / l_o, s_o = z / l_o;
        c_i = y_r / l_i, s_i = y_z / l_i;
        double d_o = l_o - length, d_i = l_i - length;
        d_o = d_o > 0 ? d_o : 0, d_i = d_i > 0 ? d_i : 0;
        double r_o = K_O * sqrt(d_o), r_i = K_I * sqrt(d_i), q_o = r_o * d_o;
        q_i = r_i * d_i;
        double tan_b = s_o / (c_o + ratio);
        double p_i = (1 - ratio * c_i) * (c_o + tan_b * s_o), p_o = (1 + ratio * c_o) * (c_i + tan_b * s_i);
        double w_c = SPEED * p_i / (p_i + p_o), cos_b = 1 / sqrt(1 + tan_b * tan_b);
        double w_s = -(SPEED - w_c) * (1 - ratio * c_i) / (ratio * cos_b * (c_i + tan_b * s_i));
        double f_c = MASS * 0.5 * PITCH * w_c * w_c, m_g = inertia * w_s * w_c * tan_b * cos_b;
        double res_r = q_i * c_i - q_o * c_o - 2 * m_g / D * s_o + f_c, res_z = q_i * s_i - q_o * s_o + 2 * m_g / D * c_o;
        double k_o = 1.5 * r_o, k_i = 1.5 * r_i, t_o = q_o / l_o, t_i = q_i / l_i;
        double m_rr = k_o * c_o * c_o + t_o * s_o * s_o + k_i * c_i * c_i + t_i * s_i * s_i;
        double m_rz = (k_o - t_o) * c_o * s_o + (k_i - t_i) * c_i * s_i;
        double m_zz = k_o * s_o * s_o + t_o * c_o * c_o + k_i * s_i * s_i + t_i * c_i * c_i;
        double det = m_rr * m_zz - m_rz * m_rz;
        x += (res_r * m_zz - res_z * m_rz) / det;
        z += (res_z * m_rr - res_r * m_rz) / det;
    }
    *radial = q_i * c_i;
    *axial = q_i * s_i;
}

static double bearing(const double *u) {
    double f[5] = {0};
    for (int j = 0; j < BALLS; j++) {
        double c = cosines[j], s = sines[j], radial, axial;
        ball(distance * alpha0_cos + u[0] * c + u[1] * s, distance * alpha0_sin + u[2] + arm * (u[3] * s - u[4] * c),
             &radial, &axial);
        f[0] -= radial * c, f[1] -= radial * s, f[2] -= axial, f[3] -= arm * axial * s, f[4] += arm * axial * c;
    }
    return f[0] + f[1] + f[2] + f[3] + f[4];
}

int main(void) {
    static double states[MOST][5];
    int count, runs;
    if (scanf("%d", &count) != 1 || count < 1 || count > MOST) return 1;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 5; k++)
            if (scanf("%lf", &states[i][k]) != 1) return 1;
    alpha0_cos = cos(40 * M_PI / 180), alpha0_sin = sin(40 * M_PI / 180);
    distance = 2 * GROOVE - D, arm = 0.5 * PITCH + (GROOVE - 0.5 * D) * alpha0_cos;
    for (int j = 0; j < BALLS; j++) cosines[j] = cos(2 * M_PI * j / BALLS), sines[j] = sin(2 * M_PI * j / BALLS);
    while (scanf("%d", &runs) == 1) {
        struct timespec a, b;
        double sum = 0;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &a);
        for (int r = 0; r < runs; r++)
            for (int i = 0; i < count; i++) sum += bearing(states[i]);
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &b);
        printf("%.0f %g\n", (b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec), sum);
        fflush(stdout);
    }
    return 0;
}
