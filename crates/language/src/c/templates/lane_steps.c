
// The larger one; NaN if either is.
static INLINE double larger(double x, double y)
{
    return x > y || isnan(x) ? x : y;
}

// One step of a lane, and the largest growth of rounding errors in it; the result is the estimated error.
static double step_lane(const struct scene *m, double t, double h, const struct scene_state *from, double tolerance,
                        struct scene_slopes *slopes, struct scene_step *step, double *growth)
{
    struct scene_position position;
    *growth = 0.0;
    set_slopes(from, 0, slopes);
    for (int stage = 1; stage < STAGES; stage++) {
        evaluate(m, t, h, from, stage, slopes, &position);
        *growth = larger(*growth, fabs(scene_growth_factor(m, &position)));
    }
    const double estimate = complete_step(m, t, h, tolerance, from, slopes, step);
    *growth = larger(*growth, fabs(scene_growth_factor(m, &step->position)));
    return estimate;
}

#if QRM_WATCHES_EVENT
// The largest value of the event at the end of a step and at the control points of the polynomial of degree 5 between
// both ends: a bound of an event that is a convex function of the coordinates.
static double largest_event(const struct scene *m, double t, double h, const struct scene_state *begin,
                            const struct scene_state *end)
{
    double largest = scene_event(m, t, end->q, end->qd, end->qdd, end->multipliers);
    for (int side = 0; side < 2; side++) {
        const struct scene_state *state = side ? end : begin;
        const double forward = side ? -h : h;
        for (int point = 1; point <= 2; point++) {
            const double first = 0.2 * point * forward, second = 0.05 * (point - 1) * h * h;
            double q[N];
            for (int i = 0; i < N; i++) {
                q[i] = state->q[i] + first * state->qd[i] + second * state->qdd[i];
            }
            const double value = scene_event(m, t, q, end->qd, end->qdd, end->multipliers);
            largest = larger(value, largest);
        }
    }
    return largest;
}
#endif

#if QRM_HAS_RANGES
// The coefficients of the dense output of order 7.
static const double DENSE[4][SLOPES] = NUMBERS_OF_DENSE;

// Derivatives 1, 2 and 3 of a polynomial of degree 4 at a distance from where they have these values.
static void move_along(const double *here, double d4, double s, double *there)
{
    there[0] = here[0] + s * (here[1] + 0.5 * s * (here[2] + s * d4 / 3.0));
    there[1] = here[1] + s * (here[2] + 0.5 * s * d4);
    there[2] = here[2] + s * d4;
}

// The smallest and the largest value over the span of five equidistant values, from the polynomial through them, and
// their error, by the rules of `crates/core/src/lane_steps/ranges.rs`.
static void find_range(const double *values, double *low, double *high, double *error)
{
    const double before = (values[0] - values[1]) + (values[2] - values[1]);
    const double at = (values[1] - values[2]) + (values[3] - values[2]);
    const double after = (values[2] - values[3]) + (values[4] - values[3]);
    // The derivatives in the middle by Stirling's formula.
    const double d4 = (before - at) + (after - at), d3 = 0.5 * (after - before), d2 = at - d4 / 12.0;
    const double middle[3] = {0.5 * (values[3] - values[1]) - d3 / 6.0, d2, d3};
    const double most = fmax(fmax(fabs(before), fabs(at)), fabs(after)), roughness = fabs(d4 / most);
    double lowest = values[0], highest = values[0];
    for (int k = 1; k <= PARTS; k++) {
        lowest = fmin(lowest, values[k]);
        highest = fmax(highest, values[k]);
    }
    *low = lowest;
    *high = highest;
    for (int k = 1; k < PARTS; k++) {
        double here[3], there[3];
        move_along(middle, d4, k - 2.0, here);
        // One step of Newton's method towards the place where the polynomial is stationary.
        const double near = -here[0] / here[1];
        move_along(here, d4, near, there);
        const double s = near - there[0] / there[1];
        // A quotient that is not a number is within no bound.
        if (fabs(s) <= 1.0 && roughness <= SMOOTH) {
            const double cubic = (here[2] + 0.25 * d4 * s) / 3.0;
            const double stationary = values[k] + s * (here[0] + 0.5 * s * (here[1] + s * cubic));
            *low = fmin(*low, stationary);
            *high = fmax(*high, stationary);
        }
    }
    const double ratio = d3 / most, square = fmax(roughness, ratio * ratio);
    // Zero where the values themselves are the extremes.
    const double beyond = (lowest - *low) + (*high - highest);
    *error = !(roughness <= SMOOTH) ? most : beyond == 0.0 ? 0.0 : FIFTH * most * square * sqrt(square);
}

// The first coefficients of the dense output, from the values `x` and derivatives `d` at both ends of a step.
static void set_cubic(double h, const double *x0, const double *d0, const double *x1, const double *d1,
                      double coefficients[8][N])
{
    for (int i = 0; i < N; i++) {
        const double change = x1[i] - x0[i], bend = h * d0[i] - change;
        coefficients[0][i] = x0[i];
        coefficients[1][i] = change;
        coefficients[2][i] = bend;
        coefficients[3][i] = change - h * d1[i] - bend;
    }
}

// The outputs at the ends of the inner parts of a step.
static void sample(const struct scene *m, double t, double h, const struct scene_state *from,
                   const struct scene_state *end, struct scene_slopes *slopes, double *growth, double *x)
{
    double q[8][N], qd[8][N];
    struct scene_position position;
    set_slopes(end, STAGES, slopes);
    for (int stage = STAGES + 1; stage < SLOPES; stage++) {
        evaluate(m, t, h, from, stage, slopes, &position);
        *growth = larger(*growth, fabs(scene_growth_factor(m, &position)));
    }
    for (int k = 0; k < 4; k++) {
        add_up(slopes, DENSE[k], SLOPES, q[4 + k], qd[4 + k]);
        for (int i = 0; i < N; i++) {
            q[4 + k][i] *= h;
            qd[4 + k][i] *= h;
        }
    }
    set_cubic(h, from->q, from->qd, end->q, end->qd, q);
    set_cubic(h, from->qd, from->qdd, end->qd, end->qdd, qd);
    for (int part = 1; part < PARTS; part++) {
        const double s = (double)part / PARTS, r = 1.0 - s;
        double at_q[N], at_qd[N], qdd[N], multipliers[SCENE_PLACES(M)];
        struct scene_angles angles;
        for (int i = 0; i < N; i++) {
            at_q[i] = q[7][i];
            at_qd[i] = qd[7][i];
            for (int k = 6; k >= 0; k--) {
                at_q[i] = q[k][i] + (k % 2 ? r : s) * at_q[i];
                at_qd[i] = qd[k][i] + (k % 2 ? r : s) * at_qd[i];
            }
        }
        compute_angles(at_q, &angles);
        scene_position(m, t + s * h, at_q, &angles, &position);
        scene_accelerations(m, &position, t + s * h, at_q, at_qd, &angles, qdd, multipliers);
        scene_outputs_at(m, &position, t + s * h, at_q, at_qd, qdd, multipliers, &angles, x + SAMPLE + part * OUTPUTS);
    }
}

// Merges the ranges of the previous step into those of the motion. They stay separate for one step, so that the step
// can be undone.
static void accept_ranges(double *x)
{
    for (int i = 0; i < OUTPUTS; i++) {
        x[LOWEST + i] = fmin(x[LOWEST + i], x[STEP_LOWEST + i]);
        x[LOWER_BOUND + i] = fmin(x[LOWER_BOUND + i], x[STEP_LOWER_BOUND + i]);
        x[HIGHEST + i] = fmax(x[HIGHEST + i], x[STEP_HIGHEST + i]);
        x[UPPER_BOUND + i] = fmax(x[UPPER_BOUND + i], x[STEP_UPPER_BOUND + i]);
    }
}

// Finds the ranges of outputs in a step whose error is accepted.
static void find_ranges(const struct scene *m, double t, double h, const struct scene_state *from,
                        const struct scene_step *step, int is_accepted, struct scene_slopes *slopes, double *growth,
                        double *x)
{
    const struct scene_state *end = &step->end;
    if (is_accepted) {
        scene_outputs_at(m, &step->position, t + h, end->q, end->qd, end->qdd, end->multipliers, &end->angles,
                         x + SAMPLE + PARTS * OUTPUTS);
        sample(m, t, h, from, end, slopes, growth, x);
    }
    for (int i = 0; i < OUTPUTS; i++) {
        double values[PARTS + 1], low, high, error;
        values[0] = x[AT_ROW + i];
        for (int part = 1; part <= PARTS; part++) {
            values[part] = is_accepted ? x[SAMPLE + part * OUTPUTS + i] : values[0];
            x[DEFINED] += 0.0 * values[part];
        }
        find_range(values, &low, &high, &error);
        x[STEP_LOWEST + i] = low;
        x[STEP_HIGHEST + i] = high;
        x[STEP_LOWER_BOUND + i] = low - error;
        x[STEP_UPPER_BOUND + i] = high + error;
        x[AT_ROW + i] = values[PARTS];
    }
}
#endif

#if QRM_HAS_CHECKPOINTS
// Stores the motion of a lane that has reached its next checkpoint.
static void store_checkpoint(double t, const struct scene_state *state, double *x)
{
    if (x[STEPS_MADE] != x[CHECKPOINT_STEP]) {
        return;
    }
    x[CHECKPOINT_STEP] *= 2.0;
    for (int i = 0; i <= 2 * N; i++) {
        x[CHECKPOINT_BEFORE + i] = x[CHECKPOINT + i];
    }
    x[CHECKPOINT] = t;
    for (int i = 0; i < N; i++) {
        x[CHECKPOINT + 1 + i] = state->q[i];
        x[CHECKPOINT + 1 + N + i] = state->qd[i];
    }
}
#endif

static void write_row(double t, const struct scene_state *state, double *row)
{
    row[0] = t;
    for (int i = 0; i < N; i++) {
        row[1 + i] = state->q[i];
        row[1 + N + i] = state->qd[i];
        row[1 + 2 * N + i] = state->qdd[i];
    }
    for (int k = 0; k < M; k++) {
        row[1 + 3 * N + k] = state->multipliers[k];
    }
}

static void read_row(const double *row, struct scene_state *state)
{
    for (int i = 0; i < N; i++) {
        state->q[i] = row[1 + i];
        state->qd[i] = row[1 + N + i];
        state->qdd[i] = row[1 + 2 * N + i];
    }
    for (int k = 0; k < M; k++) {
        state->multipliers[k] = row[1 + 3 * N + k];
    }
    compute_angles(state->q, &state->angles);
}

// Makes steps until the lane needs its caller: it has reached its end time or its event, its steps are too short, too
// many or unreliable, or the caller inspects each step. A lane that rests has an end time of minus infinity.
static void make_steps(double *numbers)
{
    double x[PLACES];
    struct scene m;
    struct scene_state before, state;
    struct scene_step step;
    struct scene_slopes slopes;
    for (int i = 0; i < PLACES; i++) {
        x[i] = numbers[i];
    }
    double t = x[ROW], t_before = t;
    if (!(t < x[END_TIME])) {
        return;
    }
    set_parameters(x, &m);
    read_row(x + ROW, &state);
    for (int k = 0, is_running = 1; is_running && k < MOST_STEPS; k++) {
        const double left = x[END_TIME] - t, h = fmin(fmin(x[STEP], x[LONGEST]), left);
        double growth;
        const double error = step_lane(&m, t, h, &state, x[TOLERANCE], &slopes, &step, &growth);
        const int is_accepted = fabs(error) <= REJECTED;
        const double change = fmax(fmin(SAFETY / sqrt(sqrt(sqrt(fmax(error, 1e-30)))), MOST_CHANGE), LEAST_CHANGE);
        x[STEP] = h * (isfinite(error) ? change : LEAST_CHANGE);
        before = state;
        t_before = t;
#if QRM_HAS_RANGES
        accept_ranges(x);
        find_ranges(&m, t, h, &state, &step, is_accepted, &slopes, &growth, x);
#endif
        x[EVENT] = -1.0;
        x[QUALITY] = x[QUALITY + 1] = x[QUALITY + 2] = 0.0;
        if (is_accepted) {
            state = step.end;
            t = h == left ? x[END_TIME] : t + h;
            x[STEPS_MADE] += 1.0;
            x[QUALITY] = growth;
            x[QUALITY + 1] = step.residual;
            x[QUALITY + 2] = is_finite(&state) ? 0.0 : NAN;
#if QRM_WATCHES_EVENT
            x[EVENT] = largest_event(&m, t, h, &before, &state);
#endif
#if QRM_HAS_CHECKPOINTS
            for (int i = 0; i < N; i++) {
                x[COORDINATE_RANGES + i] = fmin(x[COORDINATE_RANGES + i], state.q[i]);
                x[COORDINATE_RANGES + N + i] = fmax(x[COORDINATE_RANGES + N + i], state.q[i]);
            }
            store_checkpoint(t, &state, x);
#endif
        }
        is_running = !QRM_WAITS_EACH_STEP && t < x[END_TIME] && x[EVENT] < 0.0 && x[STEP] > SHORTEST * x[END_TIME]
            && x[STEPS_MADE] < x[MAX_STEPS] && x[QUALITY] <= MOST_GROWTH && x[QUALITY + 1] <= RESIDUAL
            && x[QUALITY + 2] == 0.0;
    }
    write_row(t_before, &before, x + ROW_BEFORE);
    write_row(t, &state, x + ROW);
    for (int i = 0; i < PARAMETERS; i++) {
        numbers[i] = x[i];
    }
}

#if defined(__CUDACC__) || defined(__CUDACC_RTC__)
// A thread for each lane.
extern "C" __global__ void advance(double *numbers, int lanes)
{
    const int lane = blockIdx.x * blockDim.x + threadIdx.x;
    if (lane < lanes) {
        make_steps(numbers + (long long)lane * PLACES);
    }
}
#else
// One lane after the other.
extern "C" void advance(double *numbers, int lanes)
{
    for (int lane = 0; lane < lanes; lane++) {
        make_steps(numbers + (long long)lane * PLACES);
    }
}
#endif
