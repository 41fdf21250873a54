
// The mass matrix, whose columns are the momenta for unit rates.
static void scene_mass_matrix(const struct scene *m, const double *q, double mass[N][N])
{
    double rates[N] = {0.0}, column[N];
    for (int j = 0; j < N; j++) {
        rates[j] = 1.0;
        scene_momenta(m, q, rates, column);
        rates[j] = 0.0;
        for (int i = j; i < N; i++) {
            mass[i][j] = mass[j][i] = column[i];
        }
    }
}

// Mass matrix and generalized forces.
static void scene_dynamics(const struct scene *m, double t, const double *q, const double *qd, double mass[N][N],
                           double *forces, double (*jacobian)[N], double *bias)
{
    (void)jacobian;
    (void)bias;
    scene_mass_matrix(m, q, mass);
    scene_generalized_forces(m, t, q, qd, forces);
}
