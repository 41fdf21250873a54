
// Adds to `x` the smallest change, of those places alone that are not given, by which `jacobian * x` changes by
// `-residuals`. Equations that depend on the others are left out.
static void solve_for_others(double jacobian[SCENE_PLACES(M)][N], const double *residuals, const int *is_given,
                             double *x)
{
    // The products of the rows, with the right sides in the last column; elimination by Gauss and Jordan.
    double a[SCENE_PLACES(M)][SCENE_PLACES(M) + 1], factors[SCENE_PLACES(M)];
    for (int k = 0; k < M; k++) {
        for (int l = 0; l < M; l++) {
            a[k][l] = 0.0;
            for (int i = 0; i < N; i++) {
                a[k][l] += is_given[i] ? 0.0 : jacobian[k][i] * jacobian[l][i];
            }
        }
        a[k][M] = -residuals[k];
        factors[k] = a[k][k];
    }
    for (int k = 0; k < M; k++) {
        const int is_dependent = !(a[k][k] > 1e-12 * factors[k]);
        factors[k] = is_dependent ? 0.0 : 1.0;
        for (int l = 0; l < M && !is_dependent; l++) {
            const double factor = l == k ? 0.0 : a[l][k] / a[k][k];
            for (int j = k; j <= M; j++) {
                a[l][j] -= factor * a[k][j];
            }
        }
    }
    for (int k = 0; k < M; k++) {
        for (int i = 0; i < N && factors[k] > 0.0; i++) {
            x[i] += is_given[i] ? 0.0 : jacobian[k][i] * (a[k][M] / a[k][k]);
        }
    }
}

int scene_initial_state(const struct scene *m, struct scene_state *state)
{
    enum { MOST_ITERATIONS = 50, REFINEMENTS = 2 };
    int is_given[N], is_given_rate[N];
    double residuals[SCENE_PLACES(M)] = {0}, jacobian[SCENE_PLACES(M)][N], rates[SCENE_PLACES(M)];
    scene_start(m, state->q, is_given, state->qd, is_given_rate);
    scene_loop_constraints(m, 0.0, state->q, residuals, jacobian, rates);
    for (int i = 0; i < MOST_ITERATIONS && largest(residuals, M) > CLOSED; i++) {
        solve_for_others(jacobian, residuals, is_given, state->q);
        scene_loop_constraints(m, 0.0, state->q, residuals, jacobian, rates);
    }
    for (int i = 0; i < REFINEMENTS; i++) {
        double velocity_residuals[SCENE_PLACES(M)];
        for (int k = 0; k < M; k++) {
            velocity_residuals[k] = rates[k];
            for (int j = 0; j < N; j++) {
                velocity_residuals[k] += jacobian[k][j] * state->qd[j];
            }
        }
        solve_for_others(jacobian, velocity_residuals, is_given_rate, state->qd);
    }
    scene_complete(m, 0.0, state);
    return largest(residuals, M) <= 1e-12 && is_finite(state);
}
