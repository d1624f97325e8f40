/* The yardstick of a single force: what an engineer writes in C, by hand for speed, for eight balls of the lumped model with radial play.
 *
 * The count of balls is fixed, so that the loop fills vector registers; sums are trees; the cage turns by a recurrence instead of a sine
 * and a cosine. Each displacement depends on the force before it, as in an integration: the time is that of the whole chain.
 *
 * Reads stiffness, play, the turn of the cage from state to state (revolutions), the number of states and, a line each, u v; then for
 * every line "runs" on its input it goes through all states that many times and prints the nanoseconds of processor time and a sum of the forces.
 * gcc -O3 -march=native -fno-math-errno lumped.c -lm
 */
#include <math.h>
#include <stdio.h>
#include <time.h>

enum { BALLS = 8, MOST = 4096 };

static const double FEEDBACK = 1e-15;
static double cosines[BALLS], sines[BALLS];

static double tree(const double *x) { return ((x[0] + x[4]) + (x[1] + x[5])) + ((x[2] + x[6]) + (x[3] + x[7])); }

static void force(double u, double v, double sine, double cosine, double stiffness, double play, double *fx, double *fy) {
    double x[BALLS], y[BALLS];
    double lu = cosine * u + sine * v, lv = cosine * v - sine * u;
    for (int j = 0; j < BALLS; j++) {
        double gap = lu * cosines[j] + lv * sines[j] - play;
        double deflection = gap > 0 ? gap : 0;
        double load = deflection * sqrt(deflection);
        x[j] = load * cosines[j];
        y[j] = load * sines[j];
    }
    double lx = -stiffness * tree(x), ly = -stiffness * tree(y);
    *fx = cosine * lx - sine * ly;
    *fy = cosine * ly + sine * lx;
}

int main(void) {
    static double states[MOST][2];
    double stiffness, play, turn;
    int count, runs;
    if (scanf("%lf %lf %lf %d", &stiffness, &play, &turn, &count) != 4 || count < 1 || count > MOST) return 1;
    for (int i = 0; i < count; i++)
        if (scanf("%lf %lf", &states[i][0], &states[i][1]) != 2) return 1;
    for (int j = 0; j < BALLS; j++) cosines[j] = cos(2 * M_PI * j / BALLS), sines[j] = sin(2 * M_PI * j / BALLS);
    double turn_cos = cos(2 * M_PI * turn), turn_sin = sin(2 * M_PI * turn);
    while (scanf("%d", &runs) == 1) {
        struct timespec a, b;
        double sum = 0, fx = 0, fy = 0, cosine = 1, sine = 0;
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &a);
        for (int r = 0; r < runs; r++)
            for (int i = 0; i < count; i++) {
                force(states[i][0] + FEEDBACK * fx, states[i][1] + FEEDBACK * fy, sine, cosine, stiffness, play, &fx, &fy);
                double next = turn_cos * cosine - turn_sin * sine;
                sine = turn_cos * sine + turn_sin * cosine, cosine = next;
                sum += fx + fy;
            }
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &b);
        printf("%.0f %g\n", (b.tv_sec - a.tv_sec) * 1e9 + (b.tv_nsec - a.tv_nsec), sum);
        fflush(stdout);
    }
    return 0;
}
