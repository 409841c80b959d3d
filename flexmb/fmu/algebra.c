/* Linear equations and the exponential of a matrix: part of core.c. Matrices stand row by row. */

/* a (n x n) becomes its factors, by elimination with row exchanges, which are kept in `order`. */
static void factorise(size_t n, double *a, size_t *order) {
    size_t i, j, k;
    for (k = 0; k < n; k++) {
        size_t pivot = k;
        for (i = k + 1; i < n; i++)
            if (fabs(a[i * n + k]) > fabs(a[pivot * n + k])) pivot = i;
        order[k] = pivot;
        if (pivot != k)
            for (j = 0; j < n; j++) {
                const double kept = a[k * n + j];
                a[k * n + j] = a[pivot * n + j], a[pivot * n + j] = kept;
            }
        for (i = k + 1; i < n; i++) {
            const double factor = a[i * n + k] /= a[k * n + k];
            if (factor == 0) continue;
            for (j = k + 1; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
        }
    }
}

/* b (n x m) := a^-1 b, with the factors of a. */
static void solve(size_t n, const double *a, const size_t *order, size_t m, double *b) {
    size_t i, j, k;
    for (k = 0; k < n; k++)
        if (order[k] != k)
            for (j = 0; j < m; j++) {
                const double kept = b[k * m + j];
                b[k * m + j] = b[order[k] * m + j], b[order[k] * m + j] = kept;
            }
    for (i = 0; i < n; i++)
        for (k = 0; k < i; k++)
            for (j = 0; j < m; j++) b[i * m + j] -= a[i * n + k] * b[k * m + j];
    for (i = n; i-- > 0;) {
        for (k = i + 1; k < n; k++)
            for (j = 0; j < m; j++) b[i * m + j] -= a[i * n + k] * b[k * m + j];
        for (j = 0; j < m; j++) b[i * m + j] /= a[i * n + i];
    }
}

#if N_T > 0
/* c := a b, of n x n matrices, row by row. */
static void multiply(size_t n, const double *a, const double *b, double *c) {
    size_t i, j, k;
    memset(c, 0, n * n * sizeof *c);
    for (i = 0; i < n; i++)
        for (k = 0; k < n; k++) {
            const double factor = a[i * n + k];
            if (factor == 0) continue;
            for (j = 0; j < n; j++) c[i * n + j] += factor * b[k * n + j];
        }
}

/* Scales d^-1 a d by powers of two until rows and columns are alike: a vibration of frequency w has entries of 1 and
 * w^2, which as they are would cost digits and squarings. */
static void balance(size_t n, double *a, double *d) {
    size_t i, j;
    int sweep, changed = 1;
    for (i = 0; i < n; i++) d[i] = 1;
    for (sweep = 0; sweep < 100 && changed; sweep++) {
        changed = 0;
        for (i = 0; i < n; i++) {
            double row = 0, column = 0, factor = 1, sum;
            for (j = 0; j < n; j++)
                if (j != i) row += fabs(a[i * n + j]), column += fabs(a[j * n + i]);
            /* A row or column of zeros alone, such as those of inputs, asks for no scale. */
            if (row == 0 || column == 0) continue;
            sum = row + column;
            while (column < row / 2 && factor < 1e100) factor *= 2, column *= 4;
            while (column >= row * 2 && factor > 1e-100) factor /= 2, column /= 4;
            if ((column + row) / factor >= 0.95 * sum) continue;
            changed = 1;
            d[i] *= factor;
            for (j = 0; j < n; j++) a[i * n + j] /= factor;
            for (j = 0; j < n; j++) a[j * n + i] *= factor;
        }
    }
}

/* a := exp(a), n x n, by scaling and squaring with the Pade approximant of degree 13 (Higham 2005). room: n (6 n + 1). */
static void exponential(size_t n, double *a, double *room, size_t *order) {
    static const double b[] = {64764752532480000., 32382376266240000., 7771770303897600., 1187353796428800.,
                               129060195264000.,   10559470521600.,    670442572800.,     33522128640.,
                               1323241920.,        40840800.,          960960.,           16380.,
                               182.,               1.};
    const size_t nn = n * n;
    double *a2 = room, *a4 = room + nn, *a6 = room + 2 * nn, *u = room + 3 * nn, *v = room + 4 * nn;
    double *w = room + 5 * nn, *d = room + 6 * nn, norm = 0, scale = 1;
    size_t i, j;
    int squarings = 0;
    balance(n, a, d);
    for (j = 0; j < n; j++) {
        double sum = 0;
        for (i = 0; i < n; i++) sum += fabs(a[i * n + j]);
        if (sum > norm) norm = sum;
    }
    while (norm * scale > 5.37 && squarings < 1000) scale /= 2, squarings++;
    for (i = 0; i < nn; i++) a[i] *= scale;
    multiply(n, a, a, a2);
    multiply(n, a2, a2, a4);
    multiply(n, a4, a2, a6);
    for (i = 0; i < nn; i++) v[i] = b[13] * a6[i] + b[11] * a4[i] + b[9] * a2[i];
    multiply(n, a6, v, w);
    for (i = 0; i < nn; i++) w[i] += b[7] * a6[i] + b[5] * a4[i] + b[3] * a2[i];
    for (i = 0; i < n; i++) w[i * n + i] += b[1];
    multiply(n, a, w, u);
    for (i = 0; i < nn; i++) w[i] = b[12] * a6[i] + b[10] * a4[i] + b[8] * a2[i];
    multiply(n, a6, w, v);
    for (i = 0; i < nn; i++) v[i] += b[6] * a6[i] + b[4] * a4[i] + b[2] * a2[i];
    for (i = 0; i < n; i++) v[i * n + i] += b[0];
    for (i = 0; i < nn; i++) w[i] = v[i] - u[i], a[i] = v[i] + u[i];
    factorise(n, w, order);
    solve(n, w, order, n, a);
    for (; squarings > 0; squarings--) {
        multiply(n, a, a, w);
        memcpy(a, w, nn * sizeof *a);
    }
    for (i = 0; i < n; i++)
        for (j = 0; j < n; j++) a[i * n + j] *= d[i] / d[j];
}
#endif
