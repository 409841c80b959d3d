/* Linear and time-varying plants: part of core.c. */

/* Of the table, matrix after matrix, each for all knots: A, B, C, D, u0, y0; D, u0 and y0 only where they are. */
#define N_OUT (N_Y - N_NOMINAL - N_ABSOLUTE)
#define OF_B (N_X * N_X)
#define OF_C (OF_B + N_X * N_U)
#define OF_D (OF_C + N_OUT * N_X)
#define OF_U0 (OF_D + (HAS_D ? N_OUT * N_U : 0))
#define OF_Y0 (OF_U0 + (N_NOMINAL ? N_U : 0))
#define N_MATRICES (OF_Y0 + (N_NOMINAL ? N_OUT : 0))
#define N_TABLE ((size_t)N_T * N_MATRICES)
#define N_AUGMENTED ((size_t)N_X + (N_T > 1 ? 1 : N_U))
#define N_ROOM (N_AUGMENTED * (8 * N_AUGMENTED + 1) + 3 * (size_t)N_MATRICES + 3 * N_U + N_T)
#define N_MOVED ((size_t)N_X * N_AUGMENTED)

static const double *table_of(const Unit *unit) {
#if SETTABLE
    return unit->kept + AT_P + (N_T > 1);
#else
    return unit->table;
#endif
}

#if N_T > 1
/* Where matrices begin in the table, of one knot. */
static const size_t FIRST[] = {0, OF_B, OF_C, OF_D, OF_U0, OF_Y0, N_MATRICES};

/* Slopes at the knots of the cubic spline through a table that has no knot at the second and the last but one time. */
static void spline(const double *table, double *slopes, double *diagonal) {
    size_t i, j, b;
    for (b = 0; b < 6; b++) {
        const size_t s = FIRST[b + 1] - FIRST[b];
        const double *v = table + N_T * FIRST[b];
        double *to = slopes + N_T * FIRST[b];
        for (j = 0; j < s; j++) {
#define H(i) (TIMES[(i) + 1] - TIMES[i])
#define CHORD(i) ((v[((i) + 1) * s + j] - v[(i) * s + j]) / H(i))
#if N_T == 2
            to[j] = to[s + j] = CHORD(0);
#elif N_T == 3
            const double middle = (H(1) * CHORD(0) + H(0) * CHORD(1)) / (H(0) + H(1));
            to[j] = 2 * CHORD(0) - middle, to[s + j] = middle, to[2 * s + j] = 2 * CHORD(1) - middle;
#else
            const size_t n = N_T;
            const double first = H(0) + H(1), last = H(n - 2) + H(n - 3);
            diagonal[0] = H(1);
            to[j] = ((H(0) + 2 * first) * H(1) * CHORD(0) + H(0) * H(0) * CHORD(1)) / first;
            for (i = 1; i < n; i++) {
                const double below = i + 1 < n ? H(i) : last, above = i == 1 ? first : H(i - 2);
                const double factor = below / diagonal[i - 1];
                if (i + 1 < n) {
                    diagonal[i] = 2 * (H(i - 1) + H(i)) - factor * above;
                    to[i * s + j] = 3 * (H(i) * CHORD(i - 1) + H(i - 1) * CHORD(i));
                } else {
                    diagonal[i] = H(n - 3) - factor * above;
                    to[i * s + j] =
                        (H(n - 2) * H(n - 2) * CHORD(n - 3) + (2 * last + H(n - 2)) * H(n - 3) * CHORD(n - 2)) / last;
                }
                to[i * s + j] -= factor * to[(i - 1) * s + j];
            }
            to[(n - 1) * s + j] /= diagonal[n - 1];
            for (i = n - 1; i-- > 0;)
                to[i * s + j] = (to[i * s + j] - (i ? H(i - 1) : first) * to[(i + 1) * s + j]) / diagonal[i];
#endif
#undef CHORD
#undef H
        }
    }
    (void)diagonal, (void)i;
}
#endif

/* The matrices at a time, one after the other: those of the table, or written into `at` (N_MATRICES). */
static const double *matrices(const double *table, const double *slopes, double t, double *at) {
#if N_T == 1
    (void)slopes, (void)t, (void)at;
    return table;
#else
    size_t low = 0, high = N_T - 1, b, j;
    double s, h;
    while (high - low > 1) {
        const size_t middle = (low + high) / 2;
        if (TIMES[middle] <= t) low = middle;
        else high = middle;
    }
    h = TIMES[high] - TIMES[low];
    s = (t - TIMES[low]) / h;
    if (s < 0) s = 0;
    if (s > 1) s = 1;
    for (b = 0; b < 6; b++) {
        const size_t size = FIRST[b + 1] - FIRST[b], place = N_T * FIRST[b] + low * size;
        for (j = 0; j < size; j++) {
            const double p = table[place + j], change = table[place + size + j] - p;
            const double v0 = h * slopes[place + j], v1 = h * slopes[place + size + j];
            at[FIRST[b] + j] = p + s * (v0 + s * (3 * change - 2 * v0 - v1 + s * (v0 + v1 - 2 * change)));
        }
    }
    return at;
#endif
}

/* Those of the unit. */
static const double *matrices_of(Unit *unit, double t, double *at) {
    const double *table = table_of(unit);
    if (unit->stale) {
#if N_T > 1
        spline(table, unit->slopes, unit->room + N_ROOM - N_T);
#endif
        unit->step = 0;
        unit->stale = 0;
    }
    return matrices(table, unit->slopes, t, at);
}

/* Adds A x + B u to the rates and C x + D u to the outputs. */
static void add_linear(const double *m, const double *x, const double *u, double *rates, double *y) {
    size_t i, j;
    for (i = 0; i < N_X; i++) {
        for (j = 0; j < N_X; j++) rates[i] += m[i * N_X + j] * x[j];
        for (j = 0; j < N_U; j++) rates[i] += m[OF_B + i * N_U + j] * u[j];
    }
    for (i = 0; i < N_OUT; i++) {
        for (j = 0; j < N_X; j++) y[i] += m[OF_C + i * N_X + j] * x[j];
#if HAS_D
        for (j = 0; j < N_U; j++) y[i] += m[OF_D + i * N_U + j] * u[j];
#endif
    }
}

/* The input beside the nominal one. */
static const double *beside_nominal(const double *m, const double *u, double *difference) {
#if N_NOMINAL
    size_t j;
    for (j = 0; j < N_U; j++) difference[j] = u[j] - m[OF_U0 + j];
    return difference;
#else
    (void)m, (void)difference;
    return u;
#endif
}

static int evaluate(Unit *unit) {
    double *rates = unit->rates, *y = rates + N_X, *room = unit->room;
    const double *m = matrices_of(unit, unit->kept[0], room);
    const double *u = beside_nominal(m, unit->kept + AT_U, room + N_MATRICES);
    memset(rates, 0, (N_X + N_Y) * sizeof *rates);
    add_linear(m, unit->kept + AT_X, u, rates, y);
#if N_NOMINAL
    {
        size_t j;
        for (j = 0; j < N_OUT; j++) y[j] += m[OF_Y0 + j];
        /* Nominal inputs and outputs are outputs too: what a controller adds to, and compares with. */
        for (j = 0; j < N_U; j++) y[N_OUT + j] = m[OF_U0 + j];
        for (j = 0; j < N_OUT; j++) y[N_OUT + N_U + j] = m[OF_Y0 + j];
    }
#endif
    return 0;
}

/* How rates and outputs change where time stays and inputs, states and parameters change by `seed` (as in `kept`). */
static int derivative(Unit *unit, const double *seed, double *by_seed) {
    double *room = unit->room, *y = by_seed + N_X;
    const double *m = matrices_of(unit, unit->kept[0], room);
    double *du = room + 2 * N_MATRICES + N_U;
    memset(by_seed, 0, (N_X + N_Y) * sizeof *by_seed);
    memcpy(du, seed + AT_U, N_U * sizeof *du);
#if SETTABLE
    {
        const double *table = seed + AT_P + (N_T > 1), *dm;
        double *slopes = NULL;
#if N_T > 1
        slopes = malloc(N_TABLE * sizeof *slopes);
        if (slopes == NULL) return 1;
        spline(table, slopes, room + N_ROOM - N_T);
#endif
        dm = matrices(table, slopes, unit->kept[0], room + N_MATRICES);
        free(slopes);
        {
            const double *u = beside_nominal(m, unit->kept + AT_U, room + 2 * N_MATRICES);
            add_linear(dm, unit->kept + AT_X, u, by_seed, y);
#if N_NOMINAL
            {
                size_t j;
                for (j = 0; j < N_U; j++) du[j] -= dm[OF_U0 + j], y[N_OUT + j] = dm[OF_U0 + j];
                for (j = 0; j < N_OUT; j++) y[j] += dm[OF_Y0 + j], y[N_OUT + N_U + j] = dm[OF_Y0 + j];
            }
#endif
        }
    }
#endif
    add_linear(m, seed + AT_X, du, by_seed, y);
    return 0;
}

#if N_T == 1
/* Inputs are held for the step: exp([A B; 0 0] h) moves the states, and is kept for steps of the same length. */
static int move(Unit *unit, double h) {
    const size_t n = N_X + N_U;
    double *x = unit->kept + AT_X, *room = unit->room;
    const double *m = matrices_of(unit, 0, room);
    size_t i, j;
    if (unit->step == 0 || !(fabs(h - unit->step) <= 8 * DBL_EPSILON * (fabs(unit->kept[0]) + h))) {
        double *all = room;
        memset(all, 0, n * n * sizeof *all);
        for (i = 0; i < N_X; i++) {
            for (j = 0; j < N_X; j++) all[i * n + j] = m[i * N_X + j] * h;
            for (j = 0; j < N_U; j++) all[i * n + N_X + j] = m[OF_B + i * N_U + j] * h;
        }
        exponential(n, all, room + n * n, unit->order);
        memcpy(unit->moved, all, N_X * n * sizeof *all);
        unit->step = h;
    }
    for (i = 0; i < N_X; i++) {
        room[i] = 0;
        for (j = 0; j < N_X; j++) room[i] += unit->moved[i * n + j] * x[j];
        for (j = 0; j < N_U; j++) room[i] += unit->moved[i * n + N_X + j] * unit->kept[AT_U + j];
    }
    memcpy(x, room, N_X * sizeof *x);
    return 0;
}
#else
/* [A(t) g; 0 0] h with g = B(t) (u - u0(t)), the rates of (x, 1). */
static void augmented(Unit *unit, double t, double h, double *all, double *at) {
    const size_t n = N_X + 1;
    const double *m = matrices_of(unit, t, at);
    const double *u = beside_nominal(m, unit->kept + AT_U, at + N_MATRICES);
    size_t i, j;
    memset(all, 0, n * n * sizeof *all);
    for (i = 0; i < N_X; i++) {
        for (j = 0; j < N_X; j++) all[i * n + j] = m[i * N_X + j] * h;
        for (j = 0; j < N_U; j++) all[i * n + N_X] += m[OF_B + i * N_U + j] * u[j] * h;
    }
}

/* One step of Magnus' series to fourth order, with two Gauss points (THEORY.md 14). */
static void magnus(Unit *unit, double t, double h) {
    static const double off = 0.28867513459481288; /* sqrt(3)/6 */
    const size_t n = N_X + 1, nn = n * n;
    double *one = unit->room, *two = one + nn, *there = two + nn, *back = there + nn, *at = back + nn;
    double *x = unit->kept + AT_X;
    size_t i, j;
    augmented(unit, t + (0.5 - off) * h, h, one, at);
    augmented(unit, t + (0.5 + off) * h, h, two, at);
    multiply(n, one, two, there);
    multiply(n, two, one, back);
    for (i = 0; i < nn; i++) one[i] = (one[i] + two[i]) / 2 - off / 2 * (there[i] - back[i]);
    exponential(n, one, two, unit->order);
    for (i = 0; i < N_X; i++) {
        two[i] = one[i * n + N_X];
        for (j = 0; j < N_X; j++) two[i] += one[i * n + j] * x[j];
    }
    memcpy(x, two, N_X * sizeof *x);
}

/* Equal substeps, none longer than the first parameter, and none across a knot, where the matrices have a kink. */
static int move(Unit *unit, double h) {
    const double end = unit->kept[0] + h, longest = unit->kept[AT_P];
    double t = unit->kept[0];
    size_t k = 0;
    if (!(longest > 0)) {
        complain(unit, "The longest substep must be above zero.");
        return 1;
    }
    while (t < end && !same_time(t, end)) {
        double stop = end, count, done;
        while (k < N_T && (TIMES[k] <= t || same_time(TIMES[k], t))) k++;
        if (k < N_T && TIMES[k] < end && !same_time(TIMES[k], end)) stop = TIMES[k];
        count = (stop - t) / longest * (1 - 1e-12);
        if (count > 1e9) {
            complain(unit, "The longest substep is too short for the step.");
            return 1;
        }
        count = 1 + (double)(long)count;
        for (done = 0; done < count; done++) magnus(unit, t + done * (stop - t) / count, (stop - t) / count);
        t = stop;
    }
    return 0;
}
#endif
