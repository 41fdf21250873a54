
void scene_rk4_step(const struct scene *m, double t, double h, const struct scene_state *from, struct scene_step *step)
{
    // Rates and accelerations at the four stages.
    double v[4][N], a[4][N], multipliers[SCENE_PLACES(M)], q[N], increment[N];
    struct scene_angles angles;
    struct scene_position last, here;
    struct scene_step next = {.end = *from};
    for (int i = 0; i < N; i++) {
        v[0][i] = from->qd[i];
        a[0][i] = from->qdd[i];
    }
    for (int stage = 1; stage < 4; stage++) {
        const double part = stage == 3 ? h : 0.5 * h;
        for (int i = 0; i < N; i++) {
            q[i] = from->q[i] + part * v[stage - 1][i];
            v[stage][i] = from->qd[i] + part * a[stage - 1][i];
        }
        locate(m, t + part, q, &angles, &last);
        scene_accelerations(m, &last, t + part, q, v[stage], &angles, a[stage], multipliers);
        next.growth_factor = fmax(next.growth_factor, scene_growth_factor(m, &last));
    }
    for (int i = 0; i < N; i++) {
        increment[i] = h / 6.0 * (2.0 * (v[1][i] + v[2][i]) + v[0][i] + v[3][i]);
        next.end.q[i] = from->q[i] + increment[i];
        next.end.qd[i] = from->qd[i] + h / 6.0 * (2.0 * (a[1][i] + a[2][i]) + a[0][i] + a[3][i]);
    }
    // The last stage lies near enough.
    locate(m, t + h, next.end.q, &angles, &here);
    correct_first(m, &last, &here, from->q, increment, &next);
    finish(m, t + h, &next);
    *step = next;
}
