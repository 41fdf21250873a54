
// Which coordinates have sines and cosines in the equations.
static const int HAS_ANGLE[N] = NUMBERS_OF_ANGLES;

// Up to these turns, in rad, the polynomials below are exact to 5e-17.
static const double SHORT_TURN = 1.0 / 40.0, SMALL_TURN = 6e-6, TINY_TURN = 1e-8;
// Up to this angle, in rad, the quarter turns in it have 20 bits.
static const double FAR = 1e6;

// Sines and cosines by the library, which are seldom needed: copies let others stay in registers.
static INLINE void library_angles(const double *q, struct scene_angles *angles)
{
    double at[N];
    struct scene_angles fresh;
    for (int i = 0; i < N; i++) {
        at[i] = q[i];
    }
    scene_angles(at, &fresh);
    *angles = fresh;
}

// Sine and cosine of an angle up to `FAR`, with errors below 0.8 units in the last place. The angle is reduced by quarter
// turns in three parts (Cody and Waite, Software Manual for the Elementary Functions, 1980); the polynomials are those
// of fdlibm.
static INLINE void sine_cosine(double x, double *sine, double *cosine)
{
    // Added to a number below 2^51, this leaves a whole number.
    const double whole = 6755399441055744.0;
    const double n = (x * 0.63661977236758134308 + whole) - whole;
    const double rest = x - n * 1.57079632673412561417, part = n * 6.07710050630396597660e-11;
    const double high = rest - part, low = ((rest - high) - part) - n * 2.02226624879595063154e-21;
    const double y = high + low, tail = (high - y) + low;
    const double z = y * y, z2 = z * z, cube = z * y;
    const double s = (z * z2) * (z * 1.58969099521155010221e-10 - 2.50507602534068634195e-08)
        + (z * (z * 2.75573137070700676789e-06 - 1.98412698298579493134e-04) + 8.33333333332248946124e-03);
    const double sin_y = y - ((z * (0.5 * tail - cube * s) - tail) + cube * 1.66666666666666324348e-01);
    const double c = (z2 * z2)
            * (z * (2.08757232129817482790e-09 - z * 1.13596475577881948265e-11) - 2.75573143513906633035e-07)
        + z * (z * (z * 2.48015872894767294178e-05 - 1.38888888888741095749e-03) + 4.16666666666666019037e-02);
    const double half = 0.5 * z, most = 1.0 - half;
    const double cos_y = most + (((1.0 - most) - half) + (z * c - y * tail));
    const int quarter = (int)n;
    const double first = quarter & 1 ? cos_y : sin_y, second = quarter & 1 ? sin_y : cos_y;
    *sine = quarter & 2 ? -first : first;
    *cosine = (quarter + 1) & 2 ? -second : second;
}

// Sines and cosines of coordinates, faster than those of the library.
static INLINE void compute_angles(const double *q, struct scene_angles *angles)
{
    int is_near = 1;
    for (int i = 0; i < N; i++) {
        is_near = is_near && (!HAS_ANGLE[i] || fabs(q[i]) <= FAR);
    }
    if (!is_near) {
        library_angles(q, angles);
        return;
    }
    for (int i = 0; i < N; i++) {
        angles->sin[i] = angles->cos[i] = 0.0;
        if (HAS_ANGLE[i]) {
            sine_cosine(q[i], &angles->sin[i], &angles->cos[i]);
        }
    }
}

static INLINE double largest_turn(const double *turn)
{
    double largest = 0.0;
    for (int i = 0; i < N; i++) {
        if (HAS_ANGLE[i] && fabs(turn[i]) > largest) {
            largest = fabs(turn[i]);
        }
    }
    return largest;
}

// Sines and cosines of `q`, which lies a turn away from where those at the beginning belong.
static INLINE void turn_angles(const struct scene_angles *from, const double *turn, const double *q,
                               struct scene_angles *angles)
{
    if (!(largest_turn(turn) <= SHORT_TURN)) {
        library_angles(q, angles);
        return;
    }
    for (int i = 0; i < N; i++) {
        const double d = HAS_ANGLE[i] ? turn[i] : 0.0, z = d * d, sin = from->sin[i], cos = from->cos[i];
        const double sin_d = d * z * (z * 0.008333148724138672 - 0.16666666662676427) + d;
        const double cos_d_less_1 = z * z * (z * (-1.0 / 720.0) + 1.0 / 24.0) - 0.5 * z;
        angles->sin[i] = sin + (cos * sin_d + sin * cos_d_less_1);
        angles->cos[i] = cos + (cos * cos_d_less_1 - sin * sin_d);
    }
}

// The same for small turns.
static INLINE void nudge_angles(const struct scene_angles *from, const double *turn, const double *q,
                                struct scene_angles *angles)
{
    if (!(largest_turn(turn) <= SMALL_TURN)) {
        library_angles(q, angles);
        return;
    }
    for (int i = 0; i < N; i++) {
        const double d = HAS_ANGLE[i] ? turn[i] : 0.0, sin = from->sin[i], cos = from->cos[i];
        const double cos_d_less_1 = -0.5 * d * d;
        angles->sin[i] = sin + (cos * d + sin * cos_d_less_1);
        angles->cos[i] = cos + (cos * cos_d_less_1 - sin * d);
    }
}

// The same for turns by corrections.
static INLINE void correct_angles(const double *turn, const double *q, struct scene_angles *angles)
{
    if (!(largest_turn(turn) <= TINY_TURN)) {
        library_angles(q, angles);
        return;
    }
    for (int i = 0; i < N; i++) {
        const double d = HAS_ANGLE[i] ? turn[i] : 0.0, sin = angles->sin[i], cos = angles->cos[i];
        angles->sin[i] = sin + cos * d;
        angles->cos[i] = cos - sin * d;
    }
}
