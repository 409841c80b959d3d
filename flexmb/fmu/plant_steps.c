/* Rates and outputs; not 0 where the dependent coordinates are not found, or nothing finite comes out. */
static int plant(const double *p, double t, const double *x, const double *u, double *xdot, double *y, double *memory,
                 double *work)
{
    double *w = work, *from = w + PLANT_WORK, *next = from + PLANT_MEMORY, *at = next + PLANT_MEMORY, gap = 1, far = 0;
    int64_t *n = (int64_t *)(at + PLANT_X);
    (void)p;
    /* In steps from where the degrees of freedom were, such that turns are counted; in more where that is not found. */
    for (int i = 0; i < PLANT_Q; i++) {
        from[i] = memory[DOF_AT[i]] - DOF_FROM[i];
        double own = fabs(x[i] - from[i]) / DOF_SIZE[i];
        if (!(own <= PLANT_FARTHEST * PLANT_STEP)) return 1;
        if (own > far) far = own;
    }
    int64_t steps = far > PLANT_STEP ? (int64_t)ceil(far / PLANT_STEP) : 1;
    for (int tries = 0; !(gap < PLANT_FOUND) && tries <= PLANT_FINER && steps <= PLANT_FARTHEST; tries++, steps *= 4) {
        memcpy(next, memory, PLANT_MEMORY * sizeof *next);
        for (int64_t k = 1; k <= steps; k++) {
            for (int i = 0; i < PLANT_Q; i++) {
                at[i] = from[i] + (x[i] - from[i]) * (double)k / (double)steps;
                at[PLANT_Q + i] = 0;
            }
            plant_rates(&t, k < steps ? at : x, u, next, xdot, y, next, &gap, w, n);
            if (!(gap < PLANT_FOUND)) break;
        }
    }
    if (!(gap < PLANT_FOUND)) return 1;
    for (int i = 0; i < PLANT_X; i++)
        if (!isfinite(xdot[i])) return 1;
    memcpy(memory, next, PLANT_MEMORY * sizeof *next);
    return 0;
}
