/* What FMI 2.0 and 3.0 share; fmi2.c and fmi3.c include it once they have said how names and the logger differ. */
#include "core.c"

#define JOINED(a, b) a##b
#define JOIN(a, b) JOINED(a, b)
#if defined(PREFIX)
#define NAME(name) JOIN(PREFIX, name)
#else
#define NAME(name) name
#endif
#if defined(_WIN32)
#define FMI __declspec(dllexport)
#elif defined(__GNUC__)
#define FMI __attribute__((visibility("default")))
#else
#define FMI
#endif
#define UNUSED(x) (void)(x)

typedef const unsigned int References[];
typedef enum { OK = 0, ERROR = 3 } Status;

static Status done(int failed) { return failed ? ERROR : OK; }

static void complain(const Unit *unit, const char *message) {
    if (unit->logger != NULL) LOG(unit, message);
}

static Status unsupported(void *unit, const char *what) {
    complain(unit, what);
    return ERROR;
}

FMI void VERSIONED(FreeInstance)(void *unit) { release(unit); }

FMI Status VERSIONED(Reset)(void *unit) {
    start(unit);
    return OK;
}

FMI Status STATE(Get)(void *unit, void **state) {
    *state = copied(((Unit *)unit)->kept, *state);
    return done(*state == NULL);
}

FMI Status STATE(Set)(void *unit, void *state) {
    set_state(unit, state);
    return OK;
}

FMI Status STATE(Free)(void *unit, void **state) {
    UNUSED(unit);
    if (state != NULL) free(*state), *state = NULL;
    return OK;
}

FMI Status STATE_SIZE(void *unit, void *state, size_t *size) {
    UNUSED(unit), UNUSED(state);
    *size = N_KEPT * sizeof(double);
    return OK;
}

FMI Status STATE(Serialize)(void *unit, void *state, Byte bytes[], size_t size) {
    if (size < N_KEPT * sizeof(double)) return unsupported(unit, "There is no room for the unit's state.");
    memcpy(bytes, state, N_KEPT * sizeof(double));
    return OK;
}

FMI Status STATE_OF_BYTES(void *unit, const Byte bytes[], size_t size, void **state) {
    if (size < N_KEPT * sizeof(double)) return unsupported(unit, "These bytes are not this unit's state.");
    if (*state == NULL) *state = malloc(N_KEPT * sizeof(double));
    if (*state == NULL) return ERROR;
    memcpy(*state, bytes, N_KEPT * sizeof(double));
    return OK;
}

/* Modes that ask for nothing here: nothing happens at an instant. */
#define A_MODE(name) \
    FMI Status VERSIONED(name)(void *unit) { \
        UNUSED(unit); \
        return OK; \
    }
A_MODE(ExitInitializationMode)
A_MODE(EnterEventMode)
A_MODE(EnterContinuousTimeMode)
A_MODE(Terminate)

FMI Status VERSIONED(SetTime)(void *unit, double t) {
    set_time(unit, t);
    return OK;
}

FMI Status VERSIONED(SetContinuousStates)(void *unit, const double x[], size_t n) {
    return done(set_states(unit, x, n));
}

FMI Status VERSIONED(GetContinuousStates)(void *unit, double x[], size_t n) { return done(get_states(unit, x, n)); }

FMI Status VERSIONED(GetNominalsOfContinuousStates)(void *unit, double nominals[], size_t n) {
    return done(get_nominals(unit, nominals, n));
}

FMI Status VERSIONED(GetEventIndicators)(void *unit, double indicators[], size_t n) {
    UNUSED(indicators);
    return n ? unsupported(unit, "This unit has no events.") : OK;
}
