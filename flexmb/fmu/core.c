/* A mechanism as a functional mock-up unit: what it computes. fmi3.c and fmi2.c, which speak with the importer, include
 * this file, so that a unit is one translation unit, in C99, without the headers of the standard.
 *
 * data.h is generated and says which plant it is:
 *
 *   N_T == 1  linear:        x' = A x + B u,  y = C x + D u
 *   N_T > 1   time-varying:  x' = A(t) x + B(t) (u - u0(t)),  y = y0(t) + C(t) x + D(t) (u - u0(t)), its matrices
 *             linear in time between the knots TIMES[N_T], held before the first and after the last
 *   N_T == 0  nonlinear:     plant.c, generated too, is included here. It defines
 *
 *     static int plant(const double *p, double t, const double *x, const double *u, double *xdot, double *y,
 *                      double *memory, double *work);
 *
 *   p (N_P) parameters, x (N_X) states, u (N_U) inputs; it fills xdot (N_X) and y (N_Y). memory (N_MEMORY) is where
 *   iterations start; it is read and written, begins as data.h says, and belongs to the unit's state. work (N_WORK)
 *   holds nothing from call to call. All arrays lie on the heap and none overlap. 0 is returned where all converged. No
 *   other variable of the file may change: many units run in one process. Constant tables are `static const`.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "data.h"

#if N_T == 0
#include "plant.c"
#endif

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
    double *moved; /* by the step `step`: states after it, by states and inputs before it */
    double step;
    int fresh;     /* whether the rates and outputs are those of what is kept */
    double tolerance;
    void *environment;
    void (*logger)(void);
    char *name;
} Unit;

/* Tells the importer, in the way of its version. */
static void complain(const Unit *unit, const char *message);

static int same_time(double a, double b) {
    /* Times that importers add up step by step differ by round-off. */
    return fabs(a - b) <= 8 * DBL_EPSILON * (fabs(a) + fabs(b));
}
