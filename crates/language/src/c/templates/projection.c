
enum { MOST_CORRECTIONS = QRM_MAX_CORRECTIONS };

// Residuals up to this size, in the unit of a constraint, are rounding errors.
static const double CLOSED = QRM_RESIDUAL_ROUNDING;
// Corrections up to this size, in rad or m, are rounding errors.
static const double ROUNDING = QRM_CORRECTION_ROUNDING;

// The largest absolute value; not a number if one of them is none.
static INLINE double largest(const double *x, int count)
{
    double largest = 0.0, sum = 0.0;
    for (int i = 0; i < count; i++) {
        const double size = fabs(x[i]);
        largest = size > largest ? size : largest;
        sum += size;
    }
    return isnan(sum) ? sum : largest;
}

// Whether all numbers of a state are finite.
static INLINE int is_finite(const struct scene_state *state)
{
    double sum = 0.0;
    for (int i = 0; i < N; i++) {
        sum += state->q[i] + state->qd[i] + state->qdd[i];
    }
    for (int i = 0; i < M; i++) {
        sum += state->multipliers[i];
    }
    return isfinite(sum);
}

// Corrects the coordinates and returns 1, unless no correction is needed.
static INLINE int correct(const struct scene *m, int is_suited, double t, struct scene_step *step)
{
    struct scene_state *end = &step->end;
    double residuals[SCENE_PLACES(M)] = {0}, correction[N];
    if (M == 0 || step->corrections == MOST_CORRECTIONS) {
        return 0;
    }
    scene_residuals(m, &step->position, residuals);
    if (largest(residuals, M) <= CLOSED) {
        return 0;
    }
    compute_correction(m, is_suited, &step->position, t, end->q, residuals, correction);
    if (largest(correction, N) <= ROUNDING) {
        return 0;
    }
    for (int i = 0; i < N; i++) {
        end->q[i] += correction[i];
    }
    library_angles(end->q, &end->angles);
    step->corrections += 1;
    return 1;
}

// Projects the rates of a state onto the tangent space of the constraints.
static INLINE void project_rates(const struct scene *m, int is_suited, const struct scene_position *position,
                                 double t, struct scene_state *state)
{
    double residuals[SCENE_PLACES(M)] = {0}, correction[N];
    if (M == 0) {
        return;
    }
    scene_velocity_residual(m, position, state->qd, residuals);
    compute_correction(m, is_suited, position, t, state->q, residuals, correction);
    for (int i = 0; i < N; i++) {
        state->qd[i] += correction[i];
    }
}

// Corrects the coordinates at the end of a step, whose position is known, for the first time, by Jacobian and mass matrix
// at a position nearby; `increment` is their change in the step.
static INLINE void correct_first(const struct scene *m, int is_suited, double t, const struct scene_position *near,
                                 const double *from, const double *increment, struct scene_step *step)
{
    struct scene_state *end = &step->end;
    double residuals[SCENE_PLACES(M)] = {0}, correction[N];
    scene_residuals(m, &step->position, residuals);
    compute_correction(m, is_suited, near, t, end->q, residuals, correction);
    for (int i = 0; i < N; i++) {
        end->q[i] = from[i] + (increment[i] + correction[i]);
        // As the coordinates took it up, rounding included.
        correction[i] = (end->q[i] - from[i]) - increment[i];
    }
    correct_angles(correction, end->q, &end->angles);
    step->corrections = 1;
}

// Projects the state of a step, whose angles belong to its coordinates, and completes it.
static INLINE void finish(const struct scene *m, double t, struct scene_step *step)
{
    struct scene_state *end = &step->end;
    double residuals[SCENE_PLACES(M)] = {0};
    int is_suited;
    do {
        scene_position(m, t, end->q, &end->angles, &step->position);
        is_suited = suits(m, &step->position);
    } while (correct(m, is_suited, t, step));
    project_rates(m, is_suited, &step->position, t, end);
    accelerate(m, is_suited, &step->position, t, end->q, end->qd, &end->angles, end->qdd, end->multipliers);
    scene_residuals(m, &step->position, residuals);
    step->residual = largest(residuals, M);
    // Rounding errors of turns would add up.
    compute_angles(end->q, &end->angles);
}
