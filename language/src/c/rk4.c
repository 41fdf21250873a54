
// Coordinates and angles at a stage, `part` of the step away from its beginning along `v` and `a`, then rates,
// accelerations, and what follows from the position. The result is the growth of rounding errors.
static INLINE double stage(const struct scene *m, double t, double part, const struct scene_state *from,
                           const double *v, const double *a, double *way, struct scene_angles *angles,
                           struct scene_position *position, double *qd, double *qdd)
{
    double q[N], multipliers[SCENE_PLACES(M)];
    for (int i = 0; i < N; i++) {
        way[i] = part * v[i];
        q[i] = from->q[i] + way[i];
        qd[i] = from->qd[i] + part * a[i];
    }
    turn_angles(&from->angles, way, q, angles);
    scene_position(m, t + part, q, angles, position);
    scene_accelerations(m, position, t + part, q, qd, angles, qdd, multipliers);
    return scene_growth_factor(m, position);
}

void scene_rk4_step(const struct scene *m, double t, double h, const struct scene_state *from, struct scene_step *step)
{
    double v[4][N], a[4][N], way[N], begin[N], increment[N];
    struct scene_angles angles;
    struct scene_position position;
    const double first = stage(m, t, 0.5 * h, from, from->qd, from->qdd, way, &angles, &position, v[1], a[1]);
    const double second = stage(m, t, 0.5 * h, from, v[1], a[1], way, &angles, &position, v[2], a[2]);
    const double last = stage(m, t, h, from, v[2], a[2], way, &angles, &position, v[3], a[3]);
    step->growth_factor = larger(last, larger(second, first));
    step->corrections = 0;
    for (int i = 0; i < N; i++) {
        begin[i] = from->q[i];
        increment[i] = h / 6.0 * (2.0 * (v[1][i] + v[2][i]) + from->qd[i] + v[3][i]);
        way[i] = increment[i] - way[i];
        step->end.qd[i] = from->qd[i] + h / 6.0 * (2.0 * (a[1][i] + a[2][i]) + from->qdd[i] + a[3][i]);
        step->end.q[i] = begin[i] + increment[i];
    }
    // The last stage lies near enough.
    nudge_angles(&angles, way, step->end.q, &step->end.angles);
    correct_first(m, t + h, &position, begin, increment, step);
    finish(m, t + h, step);
}
