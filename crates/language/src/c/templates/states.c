
void scene_complete(const struct scene *m, double t, struct scene_state *state)
{
    struct scene_position position;
    scene_angles(state->q, &state->angles);
    scene_position(m, t, state->q, &state->angles, &position);
    accelerate(m, suits(m, &position), &position, t, state->q, state->qd, &state->angles, state->qdd, state->multipliers);
}

int scene_project(const struct scene *m, double t, double tolerance, struct scene_state *state)
{
    struct scene_step step;
    step.end = *state;
    step.corrections = 0;
    scene_angles(state->q, &step.end.angles);
    finish(m, t, &step);
    if (!scene_is_good(&step, tolerance)) {
        return 0;
    }
    *state = step.end;
    return 1;
}

int scene_is_good(const struct scene_step *step, double tolerance)
{
    return step->residual <= tolerance && is_finite(&step->end);
}
