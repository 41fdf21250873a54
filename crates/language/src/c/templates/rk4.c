
// Rates and accelerations at a stage, `part` of the step and a `way` from its beginning, along `v` and `a`; angles, and
// what follows from the position. The result is whether the kernel suits.
static INLINE int stage(const struct scene *m, double t, double part, const struct scene_state *from,
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
    const int is_suited = suits(m, position);
    accelerate(m, is_suited, position, t + part, q, qd, angles, qdd, multipliers);
    return is_suited;
}

void scene_rk4_step(const struct scene *m, double t, double h, const struct scene_state *from, struct scene_step *step)
{
    double v[4][N], a[4][N], way[N], begin[N], increment[N];
    struct scene_angles angles;
    struct scene_position position;
    stage(m, t, 0.5 * h, from, from->qd, from->qdd, way, &angles, &position, v[1], a[1]);
    stage(m, t, 0.5 * h, from, v[1], a[1], way, &angles, &position, v[2], a[2]);
    const int is_suited = stage(m, t, h, from, v[2], a[2], way, &angles, &position, v[3], a[3]);
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
    if (M > 0) {
        scene_position(m, t + h, step->end.q, &step->end.angles, &step->position);
        correct_first(m, is_suited, t + h, &position, begin, increment, step);
    }
    finish(m, t + h, step);
}
