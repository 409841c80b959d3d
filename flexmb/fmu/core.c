/* A mechanism as a functional mock-up unit: what it computes. fmi3.c and fmi2.c, which speak with the importer, include
 * this file, and it the others, so that a unit is one translation unit, in C99, without the headers of the standard.
 *
 * data.h is generated and says which plant it is:
 *
 *   N_T == 1  linear:        x' = A x + B u,  y = C x + D u
 *   N_T > 1   time-varying:  x' = A(t) x + B(t) (u - u0(t)),  y = y0(t) + C(t) x + D(t) (u - u0(t)), its matrices
 *             splines through those at the knots TIMES[N_T], held before the first and after the last
 *   N_T == 0  nonlinear:     plant.c, generated too, is included here. It defines
 *
 *     static int plant(const double *p, double t, const double *x, const double *u, double *xdot, double *y,
 *                      double *memory, double *work);
 *
 *   p (N_P) parameters, x (N_X) states, u (N_U) inputs; it fills xdot (N_X) and y (N_Y - N_ABSOLUTE). memory
 *   (N_MEMORY) is where iterations start; it is read and written, begins as data.h says, and belongs to the unit's
 *   state. work (N_WORK) holds nothing from call to call. All arrays lie on the heap and none overlap. 0 is returned
 *   where all converged. No other variable of the file may change: many units run in one process. Constant tables are
 *   `static const`.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data.h"

/* What a unit knows of itself stands in one array: time, inputs, states, parameters, memory. Its rates and outputs
 * follow from that. A value reference is a place in time, inputs, states, parameters, rates, outputs. */
#define AT_U 1
#define AT_X (AT_U + N_U)
#define AT_P (AT_X + N_X)
#define AT_RATES (AT_P + N_P)
#define AT_Y (AT_RATES + N_X)
#define N_VALUES (AT_Y + N_Y)
#define N_KEPT (AT_RATES + N_MEMORY)

typedef struct {
    double *kept;
    double *rates; /* N_X rates, then N_Y outputs */
    double *room;  /* for intermediate results */
    double *table; /* matrices that are no parameters, read from a file */
    double *slopes; /* of a time-varying plant: derivatives of its table by time */
    int stale;     /* whether slopes and the step `moved` are those of other parameters */
    double *moved; /* by the step `step`: states after it, by states and inputs before it */
    double step;
    size_t *order; /* of rows, for factors */
    int fresh;     /* whether the rates and outputs are those of what is kept */
    double tolerance;
    void *environment;
    void (*logger)(void);
    char *name;
} Unit;

/* Tells the importer, in the way of its version. */
static void complain(const Unit *unit, const char *message);

#if N_T != 1
/* Times that importers add up step by step differ by round-off. */
static int same_time(double a, double b) { return fabs(a - b) <= 8 * DBL_EPSILON * (fabs(a) + fabs(b)); }
#endif

#include "algebra.c"
#if N_T > 0
#include "linear.c"
#else
#include "plant.c"

#include "nonlinear.c"
#endif

static void start(Unit *unit) {
    memset(unit->kept, 0, N_KEPT * sizeof *unit->kept);
    memcpy(unit->kept + AT_U, START, (N_KEPT - AT_U) * sizeof *unit->kept);
    unit->fresh = 0, unit->stale = 1, unit->step = 0, unit->tolerance = 1e-6;
}

static void release(Unit *unit) {
    if (unit == NULL) return;
    free(unit->kept), free(unit->rates), free(unit->room), free(unit->moved), free(unit->order), free(unit->slopes);
    free(unit->table), free(unit->name), free(unit);
}

#if N_T > 0 && !SETTABLE
/* The table in the unit's folder of resources: numbers of eight bytes, of which the first is one, in either order. */
static int read_table(Unit *unit, const char *folder) {
    static const char file[] = "/" TABLE_FILE;
    char *path = folder == NULL ? NULL : malloc(strlen(folder) + sizeof file);
    FILE *stream;
    double one = 0;
    size_t i, found = 0;
    unit->table = malloc(N_TABLE * sizeof *unit->table);
    if (path == NULL || unit->table == NULL) {
        free(path);
        return 1;
    }
    strcat(strcpy(path, folder), file);
    stream = fopen(path, "rb");
    free(path);
    if (stream == NULL) return 1;
    if (fread(&one, sizeof one, 1, stream) == 1) found = fread(unit->table, sizeof one, N_TABLE, stream);
    fclose(stream);
    if (one != 1)
        for (i = 0; i < N_TABLE; i++) {
            unsigned char *byte = (unsigned char *)(unit->table + i), kept;
            size_t j;
            for (j = 0; j < 4; j++) kept = byte[j], byte[j] = byte[7 - j], byte[7 - j] = kept;
        }
    return found != N_TABLE;
}
#endif

static Unit *begin(const char *name, const char *token, const char *folder, void (*logger)(void), void *environment) {
    Unit *unit = calloc(1, sizeof *unit);
    if (unit == NULL) return NULL;
    unit->logger = logger, unit->environment = environment;
    unit->kept = malloc(N_KEPT * sizeof *unit->kept);
    unit->rates = malloc((N_X + N_Y) * sizeof *unit->rates);
    unit->room = malloc(N_ROOM * sizeof *unit->room);
    unit->moved = malloc(N_MOVED * sizeof *unit->moved);
    unit->order = malloc(N_AUGMENTED * sizeof *unit->order);
    unit->slopes = malloc((N_TABLE + 1) * sizeof *unit->slopes);
    unit->name = malloc(strlen(name == NULL ? "" : name) + 1);
    if (!unit->kept || !unit->rates || !unit->room || !unit->moved || !unit->order || !unit->slopes || !unit->name) {
        release(unit);
        return NULL;
    }
    strcpy(unit->name, name == NULL ? "" : name);
    if (token == NULL || strcmp(token, TOKEN) != 0) {
        complain(unit, "The token of modelDescription.xml is not that of this unit: they are not of one export.");
        release(unit);
        return NULL;
    }
#if N_T > 0 && !SETTABLE
    if (read_table(unit, folder)) {
        complain(unit, "The file " TABLE_FILE " of the unit's resources cannot be read.");
        release(unit);
        return NULL;
    }
#else
    (void)folder;
#endif
    start(unit);
    return unit;
}

/* Absolute positions, the last outputs: displacements plus the coordinates that these count from, or their change. */
static void add_absolute(double *y, double whole) {
    size_t i;
    for (i = N_Y - N_ABSOLUTE; i < N_Y; i++) {
        const size_t k = i - (N_Y - N_ABSOLUTE);
        y[i] = y[ABSOLUTE_OF[k]] + whole * ABSOLUTE_FROM[k];
    }
}

static int refresh(Unit *unit) {
    if (unit->fresh) return 0;
    if (evaluate(unit)) {
        complain(unit, "The plant cannot be evaluated at this state.");
        return 1;
    }
    add_absolute(unit->rates + N_X, 1);
    unit->fresh = 1;
    return 0;
}

/* Numbers that a value reference stands for: one, or all of an array of parameters; 0 where there is no such value. */
static size_t size_of_value(unsigned int reference) {
    size_t i;
    for (i = 0; i < N_ARRAYS; i++)
        if (ARRAY_AT[i] == reference) return ARRAY_SIZE[i];
    return reference < N_VALUES;
}

static double *place_of(Unit *unit, unsigned int reference) {
    return reference < AT_RATES ? unit->kept + reference : unit->rates + (reference - AT_RATES);
}

static int get_values(Unit *unit, const unsigned int *references, size_t n, double *values, size_t n_values) {
    size_t i, done = 0;
    for (i = 0; i < n; i++) {
        const size_t size = size_of_value(references[i]);
        if (size == 0 || done + size > n_values) {
            complain(unit, "There is no value of this reference, or not as many numbers as asked for.");
            return 1;
        }
        if (references[i] >= AT_RATES && refresh(unit)) return 1;
        memcpy(values + done, place_of(unit, references[i]), size * sizeof *values);
        done += size;
    }
    return done != n_values;
}

static int set_values(Unit *unit, const unsigned int *references, size_t n, const double *values, size_t n_values) {
    size_t i, done = 0;
    for (i = 0; i < n; i++) {
        const size_t size = size_of_value(references[i]);
        if (references[i] == 0 || references[i] >= AT_RATES || done + size > n_values) {
            complain(unit, "Inputs, states and parameters alone can be set, each to as many numbers as it has.");
            return 1;
        }
        memcpy(place_of(unit, references[i]), values + done, size * sizeof *values);
        done += size;
        if (references[i] >= AT_P) unit->stale = 1;
    }
    unit->fresh = 0;
    return done != n_values;
}

static void set_time(Unit *unit, double t) {
    if (unit->kept[0] == t) return;
    unit->kept[0] = t;
    unit->fresh = 0;
}

static int counted(const Unit *unit, size_t n) {
    if (n != N_X) complain(unit, "There are not as many states.");
    return n == N_X;
}

static int get_states(Unit *unit, double *x, size_t n) {
    if (!counted(unit, n)) return 1;
    memcpy(x, unit->kept + AT_X, N_X * sizeof *x);
    return 0;
}

static int set_states(Unit *unit, const double *x, size_t n) {
    if (!counted(unit, n)) return 1;
    memcpy(unit->kept + AT_X, x, N_X * sizeof *x);
    unit->fresh = 0;
    return 0;
}

static int get_rates(Unit *unit, double *rates, size_t n) {
    if (!counted(unit, n) || refresh(unit)) return 1;
    memcpy(rates, unit->rates, N_X * sizeof *rates);
    return 0;
}

static int get_nominals(Unit *unit, double *nominals, size_t n) {
    if (!counted(unit, n)) return 1;
    memcpy(nominals, NOMINAL, sizeof NOMINAL);
    return 0;
}

/* A step from the unit's time; that of the importer differs from it by round-off at most. */
static int advance(Unit *unit, double from, double h) {
    if (!(h > 0) || !(fabs(from - unit->kept[0]) <= 1e-9 * (fabs(from) + h))) {
        complain(unit, "A step must go forward, from the time at which the last one ended.");
        return 1;
    }
    unit->kept[0] = from;
    if (move(unit, h)) return 1;
    unit->kept[0] = from + h;
    unit->fresh = 0;
    return 0;
}

/* Changes of the unknowns where the knowns change by the seed: both lists of references. */
static int directional(Unit *unit, const unsigned int *unknowns, size_t n_unknowns, const unsigned int *knowns,
                       size_t n_knowns, const double *seed, size_t n_seed, double *change, size_t n_change) {
    double *by = calloc(N_KEPT + N_X + N_Y, sizeof *by), *found = by + N_KEPT;
    size_t i, done = 0;
    int failed = by == NULL;
    for (i = 0; i < n_knowns && !failed; i++) {
        const size_t size = size_of_value(knowns[i]);
        failed = knowns[i] == 0 || knowns[i] >= AT_RATES || done + size > n_seed;
        if (!failed) memcpy(by + knowns[i], seed + done, size * sizeof *by);
        done += size;
    }
    failed = failed || done != n_seed || n_change != n_unknowns || derivative(unit, by, found);
    if (!failed) add_absolute(found + N_X, 0);
    for (i = 0; i < n_unknowns && !failed; i++) {
        if (unknowns[i] >= N_VALUES || unknowns[i] < AT_X || (unknowns[i] >= AT_P && unknowns[i] < AT_RATES)) failed = 1;
        else change[i] = unknowns[i] < AT_RATES ? by[unknowns[i]] : found[unknowns[i] - AT_RATES];
    }
    free(by);
    if (failed) complain(unit, "There are no such derivatives: of states, rates and outputs by inputs, states, parameters.");
    return failed;
}

/* The unit's state: a copy of what it knows of itself. */
static double *copied(const double *kept, double *to) {
    if (to == NULL) to = malloc(N_KEPT * sizeof *to);
    if (to != NULL) memcpy(to, kept, N_KEPT * sizeof *to);
    return to;
}

static void set_state(Unit *unit, const double *state) {
    if (memcmp(state + AT_P, unit->kept + AT_P, N_P * sizeof *state) != 0) unit->stale = 1;
    copied(state, unit->kept);
    unit->fresh = 0;
}
