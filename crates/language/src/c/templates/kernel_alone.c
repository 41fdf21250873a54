
// A lane leaves where the kernel does not suit: there is nothing in its place.
static INLINE int suits(const struct scene *m, const struct scene_position *position)
{
    (void)m;
    (void)position;
    return 1;
}

static INLINE void accelerate(const struct scene *m, int is_suited, const struct scene_position *position, double t,
                              const double *q, const double *qd, const struct scene_angles *angles, double *qdd,
                              double *multipliers)
{
    (void)is_suited;
    scene_accelerations(m, position, t, q, qd, angles, qdd, multipliers);
}

static INLINE void compute_correction(const struct scene *m, int is_suited, const struct scene_position *position,
                                      double t, const double *q, const double *residuals, double *correction)
{
    (void)is_suited;
    (void)t;
    (void)q;
    scene_correction(m, position, residuals, correction);
}
