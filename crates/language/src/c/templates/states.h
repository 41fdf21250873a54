
// The places of an array of `count` numbers.
#define SCENE_PLACES(count) ((count) > 0 ? (count) : 1)

// A state, with what a step needs at its beginning.
struct scene_state {
    double q[SCENE_COORDINATES];
    double qd[SCENE_COORDINATES];
    double qdd[SCENE_COORDINATES];
    double multipliers[SCENE_PLACES(SCENE_CONSTRAINTS)];
    // Sines and cosines of `q`.
    struct scene_angles angles;
};

// The end of a step, with what is known of the way there.
struct scene_step {
    struct scene_state end;
    // What follows from the position there.
    struct scene_position position;
    // Largest residual of a constraint at the end, in its unit.
    double residual;
    // How often the coordinates were corrected, QRM_MAX_CORRECTIONS times at most.
    int corrections;
};
