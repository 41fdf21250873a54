
double scene_dop853_step(const struct scene *m, double t, double h, double tolerance, const struct scene_state *from,
                         struct scene_step *step)
{
    struct scene_slopes slopes;
    struct scene_position position;
    struct scene_step next;
    set_slopes(from, 0, &slopes);
    for (int stage = 1; stage < STAGES; stage++) {
        evaluate(m, t, h, from, stage, &slopes, &position);
    }
    const double estimate = complete_step(m, t, h, tolerance, from, &slopes, &next);
    *step = next;
    return estimate;
}
