/* The nonlinear plant: part of core.c. */

#define N_TABLE ((size_t)0)
#define N_AUGMENTED ((size_t)N_X)
#define N_MOVED ((size_t)N_X * N_X)
#define N_STAGES 8
/* Whether laws may have kinks: plant.c says so. */
#ifndef BENDS
#define BENDS 0
#endif
#define N_PLACES 17
#define N_ROOM \
    ((size_t)N_WORK + (N_STAGES + 6 + BENDS * (N_PLACES + 1)) * (size_t)(N_X + N_Y) + N_U + (1 + BENDS) * N_MEMORY)
#define MEMORY_OF(unit) ((unit)->kept + AT_RATES)

static int evaluate(Unit *unit) {
    double *kept = unit->kept;
    return plant(kept + AT_P, kept[0], kept + AT_X, kept + AT_U, unit->rates, unit->rates + N_X, MEMORY_OF(unit),
                 unit->room);
}

/* Rates alone at another time and state. */
static int rates_at(Unit *unit, double t, const double *x, double *rates) {
    double *kept = unit->kept;
    return plant(kept + AT_P, t, x, kept + AT_U, rates, unit->room + N_WORK, MEMORY_OF(unit), unit->room);
}

/* By central differences along the seed, as far as round-off in the values allows. */
static int derivative(Unit *unit, const double *seed, double *by_seed) {
    double *kept = unit->kept, *low = unit->room + N_WORK, size = 0, most = 0, h;
    double *from = malloc(N_KEPT * sizeof *from);
    size_t i;
    int failed;
    if (from == NULL) return 1;
    memcpy(from, kept, N_KEPT * sizeof *from);
    for (i = AT_U; i < AT_RATES; i++) {
        if (fabs(seed[i]) > size) size = fabs(seed[i]);
        if (seed[i] != 0 && fabs(kept[i]) > most) most = fabs(kept[i]);
    }
    h = size > 0 ? 6e-6 * (most > 1e-3 ? most : 1e-3) / size : 1;
    for (i = AT_U; i < AT_RATES; i++) kept[i] = from[i] + h * seed[i];
    failed = plant(kept + AT_P, kept[0], kept + AT_X, kept + AT_U, by_seed, by_seed + N_X, MEMORY_OF(unit), unit->room);
    for (i = AT_U; i < AT_RATES; i++) kept[i] = from[i] - h * seed[i];
    failed |= plant(kept + AT_P, kept[0], kept + AT_X, kept + AT_U, low, low + N_X, MEMORY_OF(unit), unit->room);
    for (i = 0; i < N_X + N_Y; i++) by_seed[i] = (by_seed[i] - low[i]) / (2 * h);
    memcpy(kept, from, N_KEPT * sizeof *from);
    free(from);
    return failed;
}

/* Rosenbrock's method of order five with eight stages, stiffly accurate: Rodas5P, Steinebach (2023). The Jacobian is taken
 * by differences, once a step: leaf springs are stiff, and an explicit method would follow their fastest vibration. */
static const double GAMMA = 0.21193756319429014;
static const double STAGE_A[N_STAGES][N_STAGES] = {
    {0},
    {3.0},
    {2.849394379747939, 0.45842242204463923},
    {-6.954028509809101, 2.489845061869568, -10.358996098473584},
    {2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946, 1.0},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946, 1.0, 1.0}};
static const double STAGE_C[N_STAGES][N_STAGES] = {
    {0},
    {-14.155112264123755},
    {-17.97296035885952, -2.859693295451294},
    {147.12150275711716, -1.41221402718213, 71.68940251302358},
    {165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306},
    {24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471},
    {30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
     -28.087943162872662},
    {37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002,
     -54.66780262877968, -9.48861652309627}};
static const double STAGE_T[N_STAGES] = {
    0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1, 1, 1};
static const double STAGE_BY_T[N_STAGES] = {
    0.21193756319429014, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734, 2.325825639765069, 0, 0, 0};

/* How large a state is, of which errors are shares. */
static double size_of(size_t i, double x) { return fabs(x) > NOMINAL[i] ? fabs(x) : NOMINAL[i]; }

/* One step; its error in tolerances, or -1 where the plant cannot be evaluated. `to` is the state after it. */
static double step_of(Unit *unit, double t, double h, const double *x, double *to) {
    double *rates = unit->room + N_WORK + N_Y, *by_t = rates + N_X, *at = by_t + N_X, *k = at + N_X, *j = unit->moved;
    const double dt = 1e-3 * h;
    double error = 0;
    size_t i, n, s, r;
    if (rates_at(unit, t - dt, x, k) || rates_at(unit, t + dt, x, by_t) || rates_at(unit, t, x, rates)) return -1;
    for (n = 0; n < N_X; n++) by_t[n] = (by_t[n] - k[n]) / (2 * dt);
    memcpy(at, x, N_X * sizeof *at);
    for (n = 0; n < N_X; n++) {
        const double d = 1.5e-8 * size_of(n, x[n]);
        at[n] = x[n] + d;
        if (rates_at(unit, t, at, k)) return -1;
        for (i = 0; i < N_X; i++) j[i * N_X + n] = (rates[i] - k[i]) / (at[n] - x[n]);
        j[n * N_X + n] += 1 / (h * GAMMA);
        at[n] = x[n];
    }
    factorise(N_X, j, unit->order);
    for (s = 0; s < N_STAGES; s++) {
        double *own = k + s * N_X;
        for (n = 0; n < N_X; n++) {
            at[n] = x[n];
            for (r = 0; r < s; r++) at[n] += STAGE_A[s][r] * k[r * N_X + n];
        }
        if (rates_at(unit, t + STAGE_T[s] * h, at, own)) return -1;
        for (n = 0; n < N_X; n++) {
            own[n] += STAGE_BY_T[s] * h * by_t[n];
            for (r = 0; r < s; r++) own[n] += STAGE_C[s][r] / h * k[r * N_X + n];
        }
        solve(N_X, j, unit->order, 1, own);
    }
    for (n = 0; n < N_X; n++) {
        const double last = k[(N_STAGES - 1) * N_X + n], share = last / size_of(n, x[n]);
        to[n] = at[n] + last;
        error += share * share;
        if (!(fabs(to[n]) <= DBL_MAX)) return -1;
    }
    return sqrt(error / N_X) / unit->tolerance;
}

#if BENDS
static int by_size(const void *a, const void *b) {
    const double one = *(const double *)a, other = *(const double *)b;
    return (one > other) - (one < other);
}

/* By how much a function leaves the straight line between its values at the ends of a step, where it has a kink within
 * and that is more than these are apart, or zero; see flexmb/motion/kinks.py. Accelerations are sums, whose round-off and
 * vibrations bend too: a kink bends more than thirty times as much as they do in the middle of the places. */
static double acts_within(const double *value, size_t stride) {
    double second[N_PLACES - 2], steep = 0, most = fabs(value[0]), bend = 0, away = 0;
    const double change = value[(N_PLACES - 1) * stride] - value[0];
    size_t k;
    for (k = 1; k < N_PLACES; k++) {
        const double v = value[k * stride], before = value[(k - 1) * stride];
        const double off = fabs(v - value[0] - change * (double)k / (N_PLACES - 1));
        if (fabs(v - before) > steep) steep = fabs(v - before);
        if (fabs(v) > most) most = fabs(v);
        if (off > away) away = off;
        if (k + 1 < N_PLACES) second[k - 1] = fabs(value[(k + 1) * stride] - 2 * v + before);
    }
    for (k = 1; k < N_PLACES - 2; k++)
        if (second[k] + second[k - 1] > bend) bend = second[k] + second[k - 1];
    qsort(second, N_PLACES - 2, sizeof *second, by_size);
    if (!(steep > 1e-9 * most && bend > 1e-3 * steep && bend > 30 * second[(N_PLACES - 2) / 2])) return 0;
    return away > fabs(change) ? away : 0;
}

/* Whether something acts within a step alone, such as a stop that is met and left again, which its error does not tell:
 * of a free flight any step is exact. Looked at along the cubic through both ends, from the end on, where the memory is;
 * at the begin rates are those of the step. What would move nothing by its tolerance, were it there all the time, counts
 * for nothing. */
static int passes_over(Unit *unit, double t, double h, const double *x, const double *to) {
    const double *begin = unit->room + N_WORK + N_Y;
    double *rates = unit->room + N_WORK + N_Y + (N_STAGES + 3) * (size_t)N_X, *at = rates + N_PLACES * (size_t)N_X;
    double *last = at - N_X, *memory = at + N_X;
    const size_t half = N_X / 2;
    size_t k, n;
    int found;
    memcpy(memory, MEMORY_OF(unit), N_MEMORY * sizeof *memory);
    memcpy(rates, begin, N_X * sizeof *rates);
    found = rates_at(unit, t + h, to, last);
    for (k = N_PLACES - 2; k > 0 && !found; k--) {
        const double s = (double)k / (N_PLACES - 1);
        for (n = 0; n < N_X; n++) {
            const double moved = to[n] - x[n];
            at[n] = x[n] + s * moved + s * (1 - s) * ((1 - s) * (h * rates[n] - moved) + s * (moved - h * last[n]));
        }
        found = rates_at(unit, t + s * h, at, rates + k * (size_t)N_X);
    }
    memcpy(MEMORY_OF(unit), memory, N_MEMORY * sizeof *memory);
    if (found) return 1;
    /* Accelerations; the other rates are velocities. */
    for (n = half; n < N_X; n++) {
        const double away = acts_within(rates + n, N_X);
        found |= away * h > unit->tolerance * size_of(n, x[n]);
        found |= away * h * h > unit->tolerance * size_of(n - half, x[n - half]);
    }
    return found;
}
#endif

/* Steps of adapted length; inputs are held. */
static int move(Unit *unit, double h) {
    const double end = unit->kept[0] + h;
    double t = unit->kept[0], step = unit->step > 0 && unit->step < h ? unit->step : h;
    double *x = unit->kept + AT_X, *to = unit->room + N_ROOM - N_X - N_MEMORY, *memory = to + N_X;
    long steps = 0;
#if BENDS
    const double shortest = 1e-6 * h + 4e-14 * (fabs(t) + h);
#endif
    while (t < end && !same_time(t, end)) {
        const double left = end - t;
        double error, factor;
        int last = step >= left * (1 - 1e-9);
        if (last) step = left;
        memcpy(memory, MEMORY_OF(unit), N_MEMORY * sizeof *memory);
        error = step_of(unit, t, step, x, to);
        factor = error < 0 ? 0.25 : error == 0 ? 6 : 0.9 * pow(error, -0.2);
        factor = factor < 0.2 ? 0.2 : factor > 6 ? 6 : factor;
#if BENDS
        if (error >= 0 && error <= 1 && step > shortest && passes_over(unit, t, step, x, to)) error = -1, factor = 0.5;
#endif
        if (error >= 0 && error <= 1) {
            memcpy(x, to, N_X * sizeof *x);
            t = last ? end : t + step;
            /* The last step was cut to fit: what comes next may be as long as it was meant to be. */
            if (!last || step * factor > unit->step) unit->step = step * factor;
        } else {
            memcpy(MEMORY_OF(unit), memory, N_MEMORY * sizeof *memory);
            unit->step = step * factor;
        }
        step = unit->step;
        if (step < 1e-14 * (fabs(t) + h) || ++steps > 1000000) {
            complain(unit, "The nonlinear plant cannot be integrated here: steps become too short, or too many.");
            return 1;
        }
    }
    return 0;
}
