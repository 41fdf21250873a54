// Two revolutions of the quick-return by generated steps, as `hand_written.c` makes them: coordinates, rates, accelerations
// and multipliers of each step are stored. Prints the best and the median ns per step over ROUNDS whole runs.
//
// Run: ./motion [ROUNDS]
#define _POSIX_C_SOURCE 200112L

#include "quick_return.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MOST_STEPS = 4096, NUMBERS = 11 };

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return time.tv_sec * 1e9 + time.tv_nsec;
}

static int compare(const void *a, const void *b)
{
    const double difference = *(const double *)a - *(const double *)b;
    return (difference > 0.0) - (difference < 0.0);
}

static void store(const struct quick_return_state *state, double *row)
{
    memcpy(row, state->q, sizeof state->q);
    memcpy(row + 3, state->qd, sizeof state->qd);
    memcpy(row + 6, state->qdd, sizeof state->qdd);
    memcpy(row + 9, state->multipliers, sizeof state->multipliers);
}

// The steps that were made; 0 if one of them cannot be relied on.
static int run(const struct quick_return *m, const struct quick_return_state *start, double h, double *rows)
{
    struct quick_return_step step = {.end = *start};
    int steps = 0;
    store(&step.end, rows);
    while (fabs(step.end.q[0]) < 12.566370614359172 && steps < MOST_STEPS - 1) {
        quick_return_rk4_step(m, steps * h, h, &step.end, &step);
        if (!quick_return_is_good(&step, 1e-12)) {
            return 0;
        }
        steps++;
        store(&step.end, rows + NUMBERS * steps);
    }
    return steps;
}

int main(int count, char **arguments)
{
    const int rounds = count > 1 ? atoi(arguments[1]) : 200;
    struct quick_return_parameters parameters;
    struct quick_return mechanism;
    struct quick_return_state start;
    double *rows = malloc(sizeof(double) * NUMBERS * MOST_STEPS), *times = malloc(sizeof(double) * (rounds + 1));
    int steps = 0;
    quick_return_default_parameters(&parameters);
    quick_return_new(&parameters, &mechanism);
    if (!rows || !times || !quick_return_initial_state(&mechanism, &start)) {
        return 1;
    }
    for (int round = 0; round < rounds; round++) {
        const double begun = now();
        steps = run(&mechanism, &start, 1e-3, rows);
        if (steps == 0) {
            return 1;
        }
        times[round] = (now() - begun) / steps;
    }
    qsort(times, rounds, sizeof *times, compare);
    printf("ns_per_step best %.1f median %.1f steps %d\n", times[0], times[rounds / 2], steps);
    const double *end = rows + NUMBERS * steps;
    printf("end %.17g %.17g %.17g %.17g %.17g %.17g\n", end[0], end[1], end[2], end[3], end[4], end[5]);
    free(rows);
    free(times);
    return 0;
}
