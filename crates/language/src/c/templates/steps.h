
// Finds the state at time 0 from which the scene starts: what it gives stays, the other coordinates and rates close the
// loops. The result is 0 if they cannot be closed from the scene's guesses, or constraints repeat others.
int scene_initial_state(const struct scene *m, struct scene_state *state);

// Completes a state at time `t`, whose coordinates and rates fulfil the constraints, by all that follows from them.
void scene_complete(const struct scene *m, double t, struct scene_state *state);

// Projects coordinates and rates onto the constraints, in the mass metric, and completes the state. The state stays as
// it is, and the result is 0, if a residual is larger than `tolerance` or a number is not finite.
int scene_project(const struct scene *m, double t, double tolerance, struct scene_state *state);

// One step of length `h` from time `t`: the classical Runge-Kutta formula of order 4, then the projection. `from` may
// be the end in `step`.
//
// The work is bounded: at most five evaluations of the accelerations and four corrections of the coordinates.
void scene_rk4_step(const struct scene *m, double t, double h, const struct scene_state *from, struct scene_step *step);

// One step of length `h` from time `t` by the pair of Dormand and Prince of order 8, then the projection. `from` may be
// the end in `step`.
//
// The result is the estimated error: 1 if it is as large as `tolerance`, which is the largest error of an angle itself,
// of a length or a rate `x` relative to `1 + |x|`.
double scene_dop853_step(const struct scene *m, double t, double h, double tolerance, const struct scene_state *from,
                         struct scene_step *step);

// Whether a step can be relied on: all numbers are finite, and no residual is larger than `tolerance`. Where
// constraints repeat others, multipliers are not determined, and NAN.
int scene_is_good(const struct scene_step *step, double tolerance);
