/* The functions of FMI 2.0, co-simulation and model exchange. What is computed stands in core.c. */
#if defined(FMI2_FUNCTION_PREFIX) && !defined(FMI2_OVERRIDE_FUNCTION_PREFIX)
#define PREFIX FMI2_FUNCTION_PREFIX
#endif
#define VERSIONED(name) NAME(fmi2##name)
#define STATE(verb) NAME(fmi2##verb##FMUstate)
#define STATE_SIZE NAME(fmi2SerializedFMUstateSize)
#define STATE_OF_BYTES NAME(fmi2DeSerializeFMUstate)
#define LOG(unit, message) ((Logger)(unit)->logger)((unit)->environment, (unit)->name, ERROR, "logStatusError", message)
typedef char Byte;
typedef void (*Logger)(void *environment, const char *name, int status, const char *category, const char *message, ...);
#include "fmi.c"

typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    int again, ends, other_nominals, other_states, has_event;
    double event;
} Events;

FMI const char *NAME(fmi2GetTypesPlatform)(void) { return "default"; }

FMI const char *NAME(fmi2GetVersion)(void) { return "2.0"; }

FMI Status NAME(fmi2SetDebugLogging)(void *unit, int on, size_t n, const char *const categories[]) {
    UNUSED(unit), UNUSED(on), UNUSED(n), UNUSED(categories);
    return OK;
}

static int digit(char c) {
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* The folder that an address such as file:///home/me/a%20b stands for, to be freed; NULL where it is none. */
static char *folder_of(const char *address) {
    char *folder, *to;
    if (address == NULL || strncmp(address, "file:", 5) != 0) return NULL;
    address += 5;
    if (strncmp(address, "//", 2) == 0) {
        /* A host's name, "localhost" at most, stands before the path. */
        address = strchr(address + 2, '/');
        if (address == NULL) return NULL;
    }
#if defined(_WIN32)
    if (address[0] == '/' && address[1] != 0 && address[2] == ':') address++;
#endif
    folder = to = malloc(strlen(address) + 1);
    if (folder == NULL) return NULL;
    while (*address != 0) {
        if (*address == '%' && digit(address[1]) >= 0 && digit(address[2]) >= 0) {
            *to++ = (char)(16 * digit(address[1]) + digit(address[2]));
            address += 3;
        } else
            *to++ = *address++;
    }
    *to = 0;
    return folder;
}

FMI void *NAME(fmi2Instantiate)(const char *name, int kind, const char *token, const char *resources,
                                const Callbacks *callbacks, int visible, int logging) {
    char *folder = folder_of(resources);
    void (*logger)(void) = callbacks == NULL ? NULL : (void (*)(void))callbacks->logger;
    Unit *unit = begin(name, token, folder, logger, callbacks == NULL ? NULL : callbacks->environment);
    UNUSED(kind), UNUSED(visible), UNUSED(logging);
    free(folder);
    return unit;
}

FMI Status NAME(fmi2SetupExperiment)(void *unit, int has_tolerance, double tolerance, double begins, int has_stop,
                                     double stop) {
    UNUSED(has_stop), UNUSED(stop);
    if (has_tolerance && tolerance > 0) ((Unit *)unit)->tolerance = tolerance;
    set_time(unit, begins);
    return OK;
}

A_MODE(EnterInitializationMode)

FMI Status NAME(fmi2GetReal)(void *unit, References references, size_t n, double values[]) {
    return done(get_values(unit, references, n, values, n));
}

FMI Status NAME(fmi2SetReal)(void *unit, References references, size_t n, const double values[]) {
    return done(set_values(unit, references, n, values, n));
}

/* All values are real numbers. */
#define NO_VALUES(kind, type) \
    FMI Status NAME(fmi2Get##kind)(void *unit, References references, size_t n, type values[]) { \
        UNUSED(references), UNUSED(values); \
        return n ? unsupported(unit, "This unit has no values of type " #kind ".") : OK; \
    } \
    FMI Status NAME(fmi2Set##kind)(void *unit, References references, size_t n, const type values[]) { \
        UNUSED(references), UNUSED(values); \
        return n ? unsupported(unit, "This unit has no values of type " #kind ".") : OK; \
    }
typedef const char *Text;
NO_VALUES(Integer, int)
NO_VALUES(Boolean, int)
NO_VALUES(String, Text)

FMI Status NAME(fmi2GetDirectionalDerivative)(void *unit, References unknowns, size_t n_unknowns, References knowns,
                                              size_t n_knowns, const double seed[], double change[]) {
    return done(directional(unit, unknowns, n_unknowns, knowns, n_knowns, seed, n_knowns, change, n_unknowns));
}

/* ---- Model exchange -------------------------------------------------------------------------------------------- */

FMI Status NAME(fmi2NewDiscreteStates)(void *unit, Events *events) {
    UNUSED(unit);
    events->again = events->ends = events->other_nominals = events->other_states = events->has_event = 0;
    events->event = 0;
    return OK;
}

FMI Status NAME(fmi2CompletedIntegratorStep)(void *unit, int final, int *event, int *ends) {
    UNUSED(unit), UNUSED(final);
    *event = *ends = 0;
    return OK;
}

FMI Status NAME(fmi2GetDerivatives)(void *unit, double rates[], size_t n) { return done(get_rates(unit, rates, n)); }

/* ---- Co-simulation --------------------------------------------------------------------------------------------- */

FMI Status NAME(fmi2SetRealInputDerivatives)(void *unit, References references, size_t n, const int orders[],
                                             const double values[]) {
    UNUSED(references), UNUSED(orders), UNUSED(values);
    return n ? unsupported(unit, "Inputs are held for the step.") : OK;
}

FMI Status NAME(fmi2GetRealOutputDerivatives)(void *unit, References references, size_t n, const int orders[],
                                              double values[]) {
    UNUSED(references), UNUSED(orders), UNUSED(values);
    return n ? unsupported(unit, "This unit gives no derivatives of outputs.") : OK;
}

FMI Status NAME(fmi2DoStep)(void *unit, double t, double h, int final) {
    UNUSED(final);
    return done(advance(unit, t, h));
}

FMI Status NAME(fmi2CancelStep)(void *unit) { return unsupported(unit, "A step is done when the call returns."); }

/* Steps are done at once, so that there is no status to ask for but the time reached. */
FMI Status NAME(fmi2GetRealStatus)(void *unit, int kind, double *value) {
    if (kind != 2) return unsupported(unit, "This unit has no such status.");
    *value = ((Unit *)unit)->kept[0];
    return OK;
}

FMI Status NAME(fmi2GetBooleanStatus)(void *unit, int kind, int *value) {
    if (kind != 3) return unsupported(unit, "This unit has no such status.");
    *value = 0;
    return OK;
}

#define NO_STATUS(name, type) \
    FMI Status NAME(name)(void *unit, int kind, type *value) { \
        UNUSED(kind), UNUSED(value); \
        return unsupported(unit, "This unit has no such status."); \
    }
NO_STATUS(fmi2GetStatus, int)
NO_STATUS(fmi2GetIntegerStatus, int)
NO_STATUS(fmi2GetStringStatus, Text)
