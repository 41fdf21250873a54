
// Solves [mass, jacobian'; jacobian, 0] x = x, by elimination with the largest pivots.
static void solve_saddle_point(double mass[N][N], double jacobian[SCENE_PLACES(M)][N], double x[N + M])
{
    double a[N + M][N + M];
    for (int i = 0; i < N + M; i++) {
        for (int j = 0; j < N + M; j++) {
            a[i][j] = i < N && j < N ? mass[i][j] : i < N ? jacobian[j - N][i] : j < N ? jacobian[i - N][j] : 0.0;
        }
    }
    for (int k = 0; k < N + M; k++) {
        int pivot = k;
        for (int i = k + 1; i < N + M; i++) {
            pivot = fabs(a[i][k]) > fabs(a[pivot][k]) ? i : pivot;
        }
        for (int j = k; j < N + M; j++) {
            const double number = a[pivot][j];
            a[pivot][j] = a[k][j];
            a[k][j] = number;
        }
        const double right = x[pivot];
        x[pivot] = x[k];
        x[k] = right;
        for (int i = k + 1; i < N + M; i++) {
            const double factor = a[i][k] / a[k][k];
            for (int j = k; j < N + M; j++) {
                a[i][j] -= factor * a[k][j];
            }
            x[i] -= factor * x[k];
        }
    }
    for (int k = N + M - 1; k >= 0; k--) {
        for (int j = k + 1; j < N + M; j++) {
            x[k] -= a[k][j] * x[j];
        }
        x[k] /= a[k][k];
    }
}

// Whether no row is a combination of those before it, up to rounding errors of positions: Gram and Schmidt.
static int are_independent(double jacobian[SCENE_PLACES(M)][N])
{
    double directions[SCENE_PLACES(M)][N];
    for (int k = 0; k < M; k++) {
        double before = 0.0, left = 0.0;
        for (int i = 0; i < N; i++) {
            directions[k][i] = jacobian[k][i];
            before += jacobian[k][i] * jacobian[k][i];
        }
        for (int l = 0; l < k; l++) {
            double along = 0.0;
            for (int i = 0; i < N; i++) {
                along += directions[k][i] * directions[l][i];
            }
            for (int i = 0; i < N; i++) {
                directions[k][i] -= along * directions[l][i];
            }
        }
        for (int i = 0; i < N; i++) {
            left += directions[k][i] * directions[k][i];
        }
        if (!(left > 1e-16 * before)) {
            return 0;
        }
        for (int i = 0; i < N; i++) {
            directions[k][i] /= sqrt(left);
        }
    }
    return 1;
}

// Accelerations, then multipliers, by the equations of motion as a whole. The multipliers are not numbers where
// constraints repeat others: they are not determined there.
static void plain_accelerations(const struct scene *m, double t, const double *q, const double *qd, double x[N + M])
{
    double mass[N][N], forces[N], jacobian[SCENE_PLACES(M)][N], bias[SCENE_PLACES(M)];
    scene_dynamics(m, t, q, qd, mass, forces, jacobian, bias);
    for (int i = 0; i < N + M; i++) {
        x[i] = i < N ? forces[i] : -bias[i - N];
    }
    solve_saddle_point(mass, jacobian, x);
    if (!are_independent(jacobian)) {
        for (int i = N; i < N + M; i++) {
            x[i] = NAN;
        }
    }
}

// A correction, in the first places of `x`.
static void plain_correction(const struct scene *m, double t, const double *q, const double *residuals, double x[N + M])
{
    double mass[N][N], jacobian[SCENE_PLACES(M)][N], others[SCENE_PLACES(M)], rate[SCENE_PLACES(M)];
    scene_mass_matrix(m, q, mass);
    scene_loop_constraints(m, t, q, others, jacobian, rate);
    for (int i = 0; i < N + M; i++) {
        x[i] = i < N ? 0.0 : -residuals[i - N];
    }
    solve_saddle_point(mass, jacobian, x);
}

// Whether the kernel suits a position: where a coordinate cannot follow the others, rounding errors grow.
static INLINE int suits(const struct scene *m, const struct scene_position *position)
{
    return scene_growth_factor(m, position) <= QRM_MAX_GROWTH;
}

// Accelerations and multipliers, by the kernel where it suits.
static INLINE void accelerate(const struct scene *m, int is_suited, const struct scene_position *position, double t,
                              const double *q, const double *qd, const struct scene_angles *angles, double *qdd,
                              double *multipliers)
{
    scene_accelerations(m, position, t, q, qd, angles, qdd, multipliers);
    if (!is_suited) {
        double x[N + M], at[N], rates[N];
        for (int i = 0; i < N; i++) {
            at[i] = q[i];
            rates[i] = qd[i];
        }
        plain_accelerations(m, t, at, rates, x);
        for (int i = 0; i < N; i++) {
            qdd[i] = x[i];
        }
        for (int i = 0; i < M; i++) {
            multipliers[i] = x[N + i];
        }
    }
}

// The smallest change in the mass metric that takes residuals back, by the kernel where it suits.
static INLINE void compute_correction(const struct scene *m, int is_suited, const struct scene_position *position,
                                      double t, const double *q, const double *residuals, double *correction)
{
    scene_correction(m, position, residuals, correction);
    if (!is_suited) {
        double x[N + M], at[N], of[SCENE_PLACES(M)];
        for (int i = 0; i < N; i++) {
            at[i] = q[i];
        }
        for (int i = 0; i < M; i++) {
            of[i] = residuals[i];
        }
        plain_correction(m, t, at, of, x);
        for (int i = 0; i < N; i++) {
            correction[i] = x[i];
        }
    }
}
