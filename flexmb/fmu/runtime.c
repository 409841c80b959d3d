/* Functions that translated programs call; a file holds those that it needs. Each is told by the empty line before it. */

#include <math.h>
#include <stdint.h>
#include <string.h>
#define F(i, n) for (int i = 0; i < (n); i++)
#ifdef __GNUC__
#define PART __attribute__((noinline))
#else
#define PART
#endif

static double fx_max(double a, double b) { return a != a || b != b ? NAN : a > b ? a : b; }

static double fx_min(double a, double b) { return a != a || b != b ? NAN : a < b ? a : b; }

static int64_t fx_imax(int64_t a, int64_t b) { return a > b ? a : b; }

static int64_t fx_imin(int64_t a, int64_t b) { return a < b ? a : b; }

static int64_t fx_iabs(int64_t a) { return a < 0 ? (int64_t)(0 - (uint64_t)a) : a; }

static double fx_sign(double a) { return a > 0 ? 1.0 : a < 0 ? -1.0 : a; }

static int64_t fx_isign(int64_t a) { return (a > 0) - (a < 0); }

static double fx_square(double a) { return a * a; }

/* Whole numbers are divided as XLA does it: no trap by zero or by overflow. */
static int64_t fx_idiv(int64_t a, int64_t b) { return b == 0 ? -1 : b == -1 ? (int64_t)(0 - (uint64_t)a) : a / b; }

static int64_t fx_irem(int64_t a, int64_t b) { return b == 0 ? a : b == -1 ? 0 : a % b; }

static int64_t fx_clip(int64_t a, int64_t most) { return a < 0 || most < 0 ? 0 : a > most ? most : a; }

static int64_t fx_whole(double a, int64_t least, int64_t most)
{
    if (a != a) return 0;
    return a <= (double)least ? least : a >= (double)most ? most : (int64_t)a;
}

static int64_t fx_iipow(int64_t a, int n)
{
    uint64_t x = (uint64_t)a, found = 1;
    for (; n > 0; n >>= 1, x *= x)
        if (n & 1) found *= x;
    return (int64_t)found;
}

static double fx_ipow(double x, int n)
{
    double found = 1.0;
    int k = n < 0 ? -n : n;
    for (; k > 0; k >>= 1, x *= x)
        if (k & 1) found *= x;
    return n < 0 ? 1.0 / found : found;
}

/* The total order of numbers: -nan, -inf, .., -0, 0, .., inf, nan. */
static int64_t fx_before(double a, double b)
{
    int64_t i, k;
    memcpy(&i, &a, sizeof i);
    memcpy(&k, &b, sizeof k);
    i = i < 0 ? INT64_MIN + (INT64_MAX ^ (i & INT64_MAX)) : i;
    k = k < 0 ? INT64_MIN + (INT64_MAX ^ (k & INT64_MAX)) : k;
    return i < k;
}

/* The order of sorting: zeros are equal, and what is no number comes last. */
static int64_t fx_sooner(double a, double b) { return a < b || (a == a && b != b); }

/* LU factors with the largest pivot of each column, in place; rows follow each other. */
static void fx_lu(double *a, int64_t *pivot, int64_t *order, int m, int n)
{
    for (int i = 0; i < m; i++) order[i] = i;
    for (int k = 0; k < m && k < n; k++) {
        int best = k;
        for (int i = k + 1; i < m; i++)
            if (fabs(a[i * n + k]) > fabs(a[best * n + k])) best = i;
        pivot[k] = best;
        if (best != k) {
            int64_t row = order[k];
            order[k] = order[best];
            order[best] = row;
            for (int j = 0; j < n; j++) {
                double v = a[k * n + j];
                a[k * n + j] = a[best * n + j];
                a[best * n + j] = v;
            }
        }
        if (a[k * n + k] == 0) continue;
        for (int i = k + 1; i < m; i++) {
            double share = a[i * n + k] /= a[k * n + k];
            if (share != 0)
                for (int j = k + 1; j < n; j++) a[i * n + j] -= share * a[k * n + j];
        }
    }
}

static void fx_permutation(const int64_t *pivot, int64_t *order, int count, int n)
{
    for (int i = 0; i < n; i++) order[i] = i;
    for (int k = 0; k < count; k++) {
        int64_t row = order[k];
        order[k] = order[pivot[k]];
        order[pivot[k]] = row;
    }
}

/* Solution of a triangular system in place; row and column: strides of the matrix, down and across: of what is solved for. */
static void fx_triangle(const double *a, int row, int column, double *x, int down, int across, int n, int count,
                        int lower, int unit)
{
    for (int step = 0; step < n; step++) {
        int i = lower ? step : n - 1 - step;
        for (int j = lower ? 0 : i + 1; j < (lower ? i : n); j++)
            for (int k = 0; k < count; k++) x[i * down + k * across] -= a[i * row + j * column] * x[j * down + k * across];
        if (!unit)
            for (int k = 0; k < count; k++) x[i * down + k * across] /= a[i * row + i * column];
    }
}

/* Lower Cholesky factor in place; no numbers where there is none. */
static void fx_cholesky(double *a, int n)
{
    int good = 1;
    for (int j = 0; j < n; j++) {
        for (int i = j; i < n; i++) {
            double s = a[i * n + j];
            for (int k = 0; k < j; k++) s -= a[i * n + k] * a[j * n + k];
            if (i == j) good = good && s > 0;
            a[i * n + j] = i == j ? sqrt(s) : s / a[j * n + j];
        }
        for (int i = 0; i < j; i++) a[i * n + j] = 0;
    }
    for (int i = 0; !good && i < n * n; i++) a[i] = i / n >= i % n ? NAN : 0;
}
