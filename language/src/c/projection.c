
enum { N = SCENE_COORDINATES, M = SCENE_CONSTRAINTS, MOST_CORRECTIONS = 4 };

// Residuals up to this size, in the unit of a constraint, are rounding errors.
static const double CLOSED = 4e-16;
// Corrections up to this size, in rad or m, are rounding errors.
static const double ROUNDING = 1e-15;
// The growth of rounding errors beyond which the kernel does not suit a position.
static const double MOST_GROWTH = 1e3;

static double largest(const double *x, int count)
{
    double largest = 0.0;
    for (int i = 0; i < count; i++) {
        if (fabs(x[i]) > largest) {
            largest = fabs(x[i]);
        }
    }
    return largest;
}

// Whether all numbers of a state are finite: accelerations and multipliers depend on all the others.
static int is_finite(const struct scene_state *state)
{
    double sum = 0.0;
    for (int i = 0; i < N; i++) {
        sum += state->qdd[i];
    }
    for (int i = 0; i < M; i++) {
        sum += state->multipliers[i];
    }
    return isfinite(sum);
}

// What follows from the coordinates of a state.
static void locate(const struct scene *m, double t, const double *q, struct scene_angles *angles,
                   struct scene_position *position)
{
    scene_angles(q, angles);
    scene_position(m, t, q, angles, position);
}

// The largest residual at a position.
static double residual(const struct scene *m, const struct scene_position *position)
{
    double residuals[SCENE_PLACES(M)];
    scene_residuals(m, position, residuals);
    return largest(residuals, M);
}

// Corrects the coordinates and returns 1, unless no correction is needed.
static int correct(const struct scene *m, const struct scene_position *position, double *q, int *corrections)
{
    double residuals[SCENE_PLACES(M)], correction[N];
    if (M == 0 || *corrections == MOST_CORRECTIONS) {
        return 0;
    }
    scene_residuals(m, position, residuals);
    if (largest(residuals, M) <= CLOSED) {
        return 0;
    }
    scene_correction(m, position, residuals, correction);
    if (largest(correction, N) <= ROUNDING) {
        return 0;
    }
    for (int i = 0; i < N; i++) {
        q[i] += correction[i];
    }
    *corrections += 1;
    return 1;
}

// Projects the rates onto the tangent space of the constraints.
static void project_rates(const struct scene *m, const struct scene_position *position, double *qd)
{
    double residuals[SCENE_PLACES(M)], correction[N];
    if (M == 0) {
        return;
    }
    scene_velocity_residual(m, position, qd, residuals);
    scene_correction(m, position, residuals, correction);
    for (int i = 0; i < N; i++) {
        qd[i] += correction[i];
    }
}

void scene_complete(const struct scene *m, double t, struct scene_state *state)
{
    struct scene_angles angles;
    struct scene_position position;
    locate(m, t, state->q, &angles, &position);
    scene_accelerations(m, &position, t, state->q, state->qd, &angles, state->qdd, state->multipliers);
}

// Projects the state of a step, and completes it.
static void finish(const struct scene *m, double t, struct scene_step *step)
{
    struct scene_state *end = &step->end;
    struct scene_angles angles;
    do {
        locate(m, t, end->q, &angles, &step->position);
    } while (correct(m, &step->position, end->q, &step->corrections));
    project_rates(m, &step->position, end->qd);
    scene_accelerations(m, &step->position, t, end->q, end->qd, &angles, end->qdd, end->multipliers);
    step->residual = residual(m, &step->position);
    step->growth_factor = fmax(step->growth_factor, scene_growth_factor(m, &step->position));
}

// Corrects the coordinates at the end of a step for the first time, by Jacobian and mass matrix at a position nearby;
// `increment` is their change in the step.
static void correct_first(const struct scene *m, const struct scene_position *near, const struct scene_position *here,
                          const double *from, const double *increment, struct scene_step *step)
{
    double residuals[SCENE_PLACES(M)], correction[N];
    if (M == 0) {
        return;
    }
    scene_residuals(m, here, residuals);
    scene_correction(m, near, residuals, correction);
    for (int i = 0; i < N; i++) {
        step->end.q[i] = from[i] + (increment[i] + correction[i]);
    }
    step->corrections = 1;
}

int scene_project(const struct scene *m, double t, double tolerance, struct scene_state *state)
{
    struct scene_step step = {.end = *state};
    finish(m, t, &step);
    if (!scene_is_good(&step, tolerance)) {
        return 0;
    }
    *state = step.end;
    return 1;
}

int scene_is_good(const struct scene_step *step, double tolerance)
{
    return step->growth_factor <= MOST_GROWTH && step->residual <= tolerance && is_finite(&step->end);
}
