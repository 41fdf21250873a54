
double scene_dop853_step(const struct scene *m, double t, double h, double tolerance, const struct scene_state *from,
                         struct scene_step *step)
{
    struct scene_slopes slopes;
    struct scene_position position;
    struct scene_step next;
    for (int i = 0; i < N; i++) {
        slopes.v[0][i] = from->qd[i];
        slopes.a[0][i] = from->qdd[i];
    }
    for (int stage = 1; stage < STAGES; stage++) {
        evaluate(m, t, h, from, stage, &slopes, &position);
    }
    const double estimate = complete_step(m, t, h, tolerance, from, &slopes, &next);
    *step = next;
    return estimate;
}
