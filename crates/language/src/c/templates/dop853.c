
// The coefficients of E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
// Springer 1993, II.5.
enum { STAGES = 12 };

// The fraction of the step at which each stage is evaluated.
static const double NODES[STAGES] = NUMBERS_OF_NODES;

// The coefficients of each stage; the last row holds the weights of the end.
static const double ROWS[STAGES + 1][STAGES] = NUMBERS_OF_ROWS;

// The error estimates of order 5 and 3.
static const double ERRORS[2][STAGES] = NUMBERS_OF_ERRORS;

// Which coordinates are lengths, not angles.
static const int IS_LENGTH[N] = NUMBERS_OF_LENGTHS;

// The sum of the slopes at the first stages.
static void add_up(double slopes[STAGES][N], const double *weights, int count, double *sum)
{
    for (int i = 0; i < N; i++) {
        sum[i] = 0.0;
        for (int stage = 0; stage < count; stage++) {
            sum[i] += weights[stage] * slopes[stage][i];
        }
    }
}

// The estimated error of a step against the tolerance, as the code DOP853 measures it.
static double error(double v[STAGES][N], double a[STAGES][N], double h, double tolerance,
                    const struct scene_state *from, const struct scene_state *end)
{
    double squares[2] = {0.0, 0.0}, rate[N], acceleration[N];
    for (int order = 0; order < 2; order++) {
        add_up(v, ERRORS[order], STAGES, rate);
        add_up(a, ERRORS[order], STAGES, acceleration);
        for (int i = 0; i < N; i++) {
            const double size = IS_LENGTH[i] ? 1.0 + fmax(fabs(from->q[i]), fabs(end->q[i])) : 1.0;
            const double of_q = rate[i] / size;
            const double of_qd = acceleration[i] / (1.0 + fmax(fabs(from->qd[i]), fabs(end->qd[i])));
            squares[order] += of_q * of_q + of_qd * of_qd;
        }
    }
    const double denominator = fmax(squares[0] + 0.01 * squares[1], DBL_MIN) * (2.0 * N);
    return fabs(h) * squares[0] / (sqrt(denominator) * tolerance);
}

double scene_dop853_step(const struct scene *m, double t, double h, double tolerance, const struct scene_state *from,
                         struct scene_step *step)
{
    // Rates and accelerations at the stages.
    double v[STAGES][N], a[STAGES][N], multipliers[SCENE_PLACES(M)], q[N], increment[N], rate[N], acceleration[N];
    struct scene_angles angles;
    struct scene_position position;
    struct scene_step next;
    next.corrections = 0;
    for (int i = 0; i < N; i++) {
        v[0][i] = from->qd[i];
        a[0][i] = from->qdd[i];
    }
    for (int stage = 1; stage < STAGES; stage++) {
        const double at = t + NODES[stage] * h;
        add_up(v, ROWS[stage], stage, rate);
        add_up(a, ROWS[stage], stage, acceleration);
        for (int i = 0; i < N; i++) {
            q[i] = from->q[i] + h * rate[i];
            v[stage][i] = from->qd[i] + h * acceleration[i];
        }
        compute_angles(q, &angles);
        scene_position(m, at, q, &angles, &position);
        accelerate(m, suits(m, &position), &position, at, q, v[stage], &angles, a[stage], multipliers);
    }
    add_up(v, ROWS[STAGES], STAGES, rate);
    add_up(a, ROWS[STAGES], STAGES, acceleration);
    for (int i = 0; i < N; i++) {
        increment[i] = h * rate[i];
        next.end.q[i] = from->q[i] + increment[i];
        next.end.qd[i] = from->qd[i] + h * acceleration[i];
    }
    const double estimate = error(v, a, h, tolerance, from, &next.end);
    compute_angles(next.end.q, &next.end.angles);
    scene_position(m, t + h, next.end.q, &next.end.angles, &position);
    correct_first(m, suits(m, &position), t + h, &position, from->q, increment, &next);
    finish(m, t + h, &next);
    *step = next;
    return estimate;
}
