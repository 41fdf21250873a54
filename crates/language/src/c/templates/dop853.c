
// The coefficients of E. Hairer, S. P. Norsett and G. Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
// Springer 1993, II.5 and II.6.
enum { STAGES = 12, SLOPES = COUNT_OF_SLOPES };

// The fraction of the step at which each stage is evaluated.
static const double NODES[SLOPES] = NUMBERS_OF_NODES;

// The coefficients of each stage; row 12 holds the weights of the end.
static const double ROWS[COUNT_OF_ROWS][SLOPES] = NUMBERS_OF_ROWS;

// The error estimates of order 5 and 3.
static const double ERRORS[2][SLOPES] = NUMBERS_OF_ERRORS;

// Which coordinates are lengths, not angles.
static const int IS_LENGTH[N] = NUMBERS_OF_LENGTHS;

// Rates and accelerations at the stages.
struct scene_slopes {
    double v[SLOPES][N], a[SLOPES][N];
};

// Sets the slopes of a stage to those of a state.
static INLINE void set_slopes(const struct scene_state *state, int stage, struct scene_slopes *slopes)
{
    for (int i = 0; i < N; i++) {
        slopes->v[stage][i] = state->qd[i];
        slopes->a[stage][i] = state->qdd[i];
    }
}

// The sums of rates and accelerations over the first stages.
static void add_up(const struct scene_slopes *slopes, const double *weights, int count, double *rate,
                   double *acceleration)
{
    for (int i = 0; i < N; i++) {
        rate[i] = acceleration[i] = 0.0;
        for (int stage = 0; stage < count; stage++) {
            rate[i] += weights[stage] * slopes->v[stage][i];
            acceleration[i] += weights[stage] * slopes->a[stage][i];
        }
    }
}

// The estimated error of a step against the tolerance, as the code DOP853 measures it.
static double error(const struct scene_slopes *slopes, double h, double tolerance, const struct scene_state *from,
                    const struct scene_state *end)
{
    double squares[2] = {0.0, 0.0}, rate[N], acceleration[N];
    for (int order = 0; order < 2; order++) {
        add_up(slopes, ERRORS[order], STAGES, rate, acceleration);
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

// Evaluates the slopes at a stage, and what follows from its position.
static INLINE void evaluate(const struct scene *m, double t, double h, const struct scene_state *from, int stage,
                            struct scene_slopes *slopes, struct scene_position *position)
{
    const double at = t + NODES[stage] * h;
    double rate[N], acceleration[N], q[N], multipliers[SCENE_PLACES(M)];
    struct scene_angles angles;
    add_up(slopes, ROWS[stage], stage, rate, acceleration);
    for (int i = 0; i < N; i++) {
        q[i] = from->q[i] + h * rate[i];
        slopes->v[stage][i] = from->qd[i] + h * acceleration[i];
    }
    compute_angles(q, &angles);
    scene_position(m, at, q, &angles, position);
    accelerate(m, suits(m, position), position, at, q, slopes->v[stage], &angles, slopes->a[stage], multipliers);
}

// Completes a step by its slopes; the result is the estimated error.
static INLINE double complete_step(const struct scene *m, double t, double h, double tolerance,
                                   const struct scene_state *from, const struct scene_slopes *slopes,
                                   struct scene_step *step)
{
    double increment[N], rate[N], acceleration[N];
    add_up(slopes, ROWS[STAGES], STAGES, rate, acceleration);
    step->corrections = 0;
    for (int i = 0; i < N; i++) {
        increment[i] = h * rate[i];
        step->end.q[i] = from->q[i] + increment[i];
        step->end.qd[i] = from->qd[i] + h * acceleration[i];
    }
    const double estimate = error(slopes, h, tolerance, from, &step->end);
    compute_angles(step->end.q, &step->end.angles);
    if (M > 0) {
        scene_position(m, t + h, step->end.q, &step->end.angles, &step->position);
        correct_first(m, suits(m, &step->position), t + h, &step->position, from->q, increment, step);
    }
    finish(m, t + h, step);
    return estimate;
}
