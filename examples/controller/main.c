/* A controller that keeps the crank of the quick-return mechanism at 75 turns a minute, and what its steps cost. */

#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct {
    double t, q[3], qd[3], qdd[3], lambda[2];
} Motion;

int quick_return_start(Motion *motion, double angle, double speed);
int quick_return_step(Motion *motion, double torque, double h);
double quick_return_torque(const Motion *motion);

#define STEPS 4000
#define REPEATS 200
#define ROUNDS 15

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A step from here, in ns: the quickest of several times, since whatever else the machine does only adds. */
static double cost(const Motion *from, double torque, double h) {
    double best = 1e300;
    for (int round = 0; round < ROUNDS; round++) {
        double begun = now();
        for (int i = 0; i < REPEATS; i++) {
            Motion motion = *from;
            if (quick_return_step(&motion, torque, h)) exit(1);
        }
        double took = (now() - begun) / REPEATS;
        if (took < best) best = took;
    }
    return best;
}

static const double wanted = 2.5 * 3.14159265358979323846, h = 1e-3, gain = 20000.0;
static double costs[STEPS];

/* A turn of the crank under the controller, after three turns to settle; returns how many of its steps were measured,
   which are those without the torque of inverse dynamics. */
static int turn(int feeds_forward, double *slowest, double *fastest) {
    Motion motion;
    int steps = 0;
    if (quick_return_start(&motion, 0.0, wanted)) exit(1);
    *slowest = *fastest = wanted;
    double begin = 6.0 * 3.14159265358979323846;
    while (motion.q[0] < begin + 2.0 * 3.14159265358979323846) {
        double torque = gain * (wanted - motion.qd[0]);
        if (feeds_forward) torque += quick_return_torque(&motion);
        if (motion.q[0] >= begin) {
            *slowest = fmin(*slowest, motion.qd[0]);
            *fastest = fmax(*fastest, motion.qd[0]);
            if (!feeds_forward && steps < STEPS) costs[steps++] = cost(&motion, torque, h);
        }
        if (quick_return_step(&motion, torque, h)) {
            fprintf(stderr, "no step from t = %g\n", motion.t);
            exit(1);
        }
    }
    return steps;
}

int main(void) {
    double slowest, fastest, least, most;
    int steps = turn(0, &slowest, &fastest);
    turn(1, &least, &most);
    qsort(costs, (size_t)steps, sizeof *costs, ascending);
    double median = costs[steps / 2], worst = costs[steps - 1];
    printf("crank between %.4f and %.4f rad/s by feedback, %.4f wanted\n", slowest, fastest, wanted);
    printf("crank between %.4f and %.4f rad/s with the torque of inverse dynamics too\n", least, most);
    printf("a step takes %.0f ns, at worst %.0f ns: %.2f times the median, over the %d steps of a turn\n", median, worst,
           worst / median, steps);
    /* Each step is at most five evaluations and four corrections, and nothing in it waits. */
    if (!(most - least < 0.1 * (fastest - slowest))) return 1;
    return worst < 3.0 * median ? 0 : 1;
}
