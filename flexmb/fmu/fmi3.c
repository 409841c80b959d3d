/* The functions of FMI 3.0, co-simulation and model exchange. What is computed stands in core.c. */
#include <stdbool.h>
#include <stdint.h>

#if defined(FMI3_FUNCTION_PREFIX) && !defined(FMI3_OVERRIDE_FUNCTION_PREFIX)
#define PREFIX FMI3_FUNCTION_PREFIX
#endif
#define VERSIONED(name) NAME(fmi3##name)
#define STATE(verb) NAME(fmi3##verb##FMUState)
#define STATE_SIZE NAME(fmi3SerializedFMUStateSize)
#define STATE_OF_BYTES NAME(fmi3DeserializeFMUState)
#define LOG(unit, message) ((Logger)(unit)->logger)((unit)->environment, ERROR, "logStatusError", message)
typedef uint8_t Byte;
typedef void (*Logger)(void *environment, int status, const char *category, const char *message);
#include "fmi.c"

FMI const char *NAME(fmi3GetVersion)(void) { return "3.0"; }

FMI Status NAME(fmi3SetDebugLogging)(void *unit, bool on, size_t n, const char *const categories[]) {
    UNUSED(unit), UNUSED(on), UNUSED(n), UNUSED(categories);
    return OK;
}

FMI void *NAME(fmi3InstantiateModelExchange)(const char *name, const char *token, const char *folder, bool visible,
                                             bool logging, void *environment, Logger logger) {
    UNUSED(visible), UNUSED(logging);
    return begin(name, token, folder, (void (*)(void))logger, environment);
}

FMI void *NAME(fmi3InstantiateCoSimulation)(const char *name, const char *token, const char *folder, bool visible,
                                            bool logging, bool events, bool early, References between,
                                            size_t n_between, void *environment, Logger logger,
                                            void (*update)(void)) {
    UNUSED(visible), UNUSED(logging), UNUSED(events), UNUSED(early), UNUSED(between), UNUSED(n_between), UNUSED(update);
    return begin(name, token, folder, (void (*)(void))logger, environment);
}

FMI void *NAME(fmi3InstantiateScheduledExecution)(const char *name, const char *token, const char *folder, bool visible,
                                                  bool logging, void *environment, Logger logger,
                                                  void (*clock)(void), void (*lock)(void), void (*unlock)(void)) {
    UNUSED(name), UNUSED(token), UNUSED(folder), UNUSED(visible), UNUSED(logging), UNUSED(environment);
    UNUSED(clock), UNUSED(lock), UNUSED(unlock);
    if (logger != NULL) logger(environment, ERROR, "logStatusError", "This unit has no scheduled execution.");
    return NULL;
}

FMI Status NAME(fmi3EnterInitializationMode)(void *unit, bool has_tolerance, double tolerance, double begins,
                                             bool has_stop, double stop) {
    UNUSED(has_stop), UNUSED(stop);
    if (has_tolerance && tolerance > 0) ((Unit *)unit)->tolerance = tolerance;
    set_time(unit, begins);
    return OK;
}

A_MODE(EnterStepMode)
A_MODE(EnterConfigurationMode)
A_MODE(ExitConfigurationMode)
A_MODE(EvaluateDiscreteStates)

FMI Status NAME(fmi3GetFloat64)(void *unit, References references, size_t n, double values[], size_t n_values) {
    return done(get_values(unit, references, n, values, n_values));
}

FMI Status NAME(fmi3SetFloat64)(void *unit, References references, size_t n, const double values[], size_t n_values) {
    return done(set_values(unit, references, n, values, n_values));
}

/* All values are numbers of double precision. */
#define NO_VALUES(kind, type) \
    FMI Status NAME(fmi3Get##kind)(void *unit, References references, size_t n, type values[], size_t n_values) { \
        UNUSED(references), UNUSED(values); \
        return n || n_values ? unsupported(unit, "This unit has no values of type " #kind ".") : OK; \
    } \
    FMI Status NAME(fmi3Set##kind)(void *unit, References references, size_t n, const type values[], \
                                   size_t n_values) { \
        UNUSED(references), UNUSED(values); \
        return n || n_values ? unsupported(unit, "This unit has no values of type " #kind ".") : OK; \
    }
typedef const char *String;
NO_VALUES(Float32, float)
NO_VALUES(Int8, int8_t)
NO_VALUES(UInt8, uint8_t)
NO_VALUES(Int16, int16_t)
NO_VALUES(UInt16, uint16_t)
NO_VALUES(Int32, int32_t)
NO_VALUES(UInt32, uint32_t)
NO_VALUES(Int64, int64_t)
NO_VALUES(UInt64, uint64_t)
NO_VALUES(Boolean, bool)
NO_VALUES(String, String)

FMI Status NAME(fmi3GetBinary)(void *unit, References references, size_t n, size_t sizes[], const uint8_t *values[],
                               size_t n_values) {
    UNUSED(references), UNUSED(sizes), UNUSED(values);
    return n || n_values ? unsupported(unit, "This unit has no values of type Binary.") : OK;
}

FMI Status NAME(fmi3SetBinary)(void *unit, References references, size_t n, const size_t sizes[],
                               const uint8_t *const values[], size_t n_values) {
    UNUSED(references), UNUSED(sizes), UNUSED(values);
    return n || n_values ? unsupported(unit, "This unit has no values of type Binary.") : OK;
}

/* There are no clocks, each with one number, or with two. */
#define NO_CLOCKS(name, one) \
    FMI Status NAME(name)(void *unit, References clocks, size_t n, one a[]) { \
        UNUSED(clocks), UNUSED(a); \
        return n ? unsupported(unit, "This unit has no clocks.") : OK; \
    }
#define NO_CLOCKS_OF_TWO(name, one, two) \
    FMI Status NAME(name)(void *unit, References clocks, size_t n, one a[], two b[]) { \
        UNUSED(clocks), UNUSED(a), UNUSED(b); \
        return n ? unsupported(unit, "This unit has no clocks.") : OK; \
    }
NO_CLOCKS(fmi3GetClock, bool)
NO_CLOCKS(fmi3SetClock, const bool)
NO_CLOCKS(fmi3GetShiftDecimal, double)
NO_CLOCKS(fmi3SetShiftDecimal, const double)
NO_CLOCKS(fmi3SetIntervalDecimal, const double)
NO_CLOCKS_OF_TWO(fmi3GetIntervalDecimal, double, int)
NO_CLOCKS_OF_TWO(fmi3GetShiftFraction, uint64_t, uint64_t)
NO_CLOCKS_OF_TWO(fmi3SetShiftFraction, const uint64_t, const uint64_t)
NO_CLOCKS_OF_TWO(fmi3SetIntervalFraction, const uint64_t, const uint64_t)

FMI Status NAME(fmi3GetIntervalFraction)(void *unit, References clocks, size_t n, uint64_t counters[],
                                         uint64_t resolutions[], int qualifiers[]) {
    UNUSED(clocks), UNUSED(counters), UNUSED(resolutions), UNUSED(qualifiers);
    return n ? unsupported(unit, "This unit has no clocks.") : OK;
}

FMI Status NAME(fmi3ActivateModelPartition)(void *unit, unsigned int clock, double t) {
    UNUSED(clock), UNUSED(t);
    return unsupported(unit, "This unit has no clocks.");
}

FMI Status NAME(fmi3GetNumberOfVariableDependencies)(void *unit, unsigned int reference, size_t *n) {
    UNUSED(reference), UNUSED(n);
    return unsupported(unit, "Dependencies stand in modelDescription.xml.");
}

FMI Status NAME(fmi3GetVariableDependencies)(void *unit, unsigned int dependent, size_t elements[],
                                             unsigned int independents[], size_t of_elements[], int kinds[],
                                             size_t n) {
    UNUSED(dependent), UNUSED(elements), UNUSED(independents), UNUSED(of_elements), UNUSED(kinds), UNUSED(n);
    return unsupported(unit, "Dependencies stand in modelDescription.xml.");
}

FMI Status NAME(fmi3GetDirectionalDerivative)(void *unit, References unknowns, size_t n_unknowns, References knowns,
                                              size_t n_knowns, const double seed[], size_t n_seed, double change[],
                                              size_t n_change) {
    return done(directional(unit, unknowns, n_unknowns, knowns, n_knowns, seed, n_seed, change, n_change));
}

FMI Status NAME(fmi3GetAdjointDerivative)(void *unit, References unknowns, size_t n_unknowns, References knowns,
                                          size_t n_knowns, const double seed[], size_t n_seed, double change[],
                                          size_t n_change) {
    UNUSED(unknowns), UNUSED(n_unknowns), UNUSED(knowns), UNUSED(n_knowns);
    UNUSED(seed), UNUSED(n_seed), UNUSED(change), UNUSED(n_change);
    return unsupported(unit, "This unit has directional derivatives alone.");
}

FMI Status NAME(fmi3UpdateDiscreteStates)(void *unit, bool *again, bool *ends, bool *other_nominals,
                                          bool *other_states, bool *has_event, double *event) {
    UNUSED(unit), UNUSED(event);
    *again = *ends = *other_nominals = *other_states = *has_event = false;
    return OK;
}

/* ---- Model exchange -------------------------------------------------------------------------------------------- */

FMI Status NAME(fmi3CompletedIntegratorStep)(void *unit, bool final, bool *event, bool *ends) {
    UNUSED(unit), UNUSED(final);
    *event = *ends = false;
    return OK;
}

FMI Status NAME(fmi3GetContinuousStateDerivatives)(void *unit, double rates[], size_t n) {
    return done(get_rates(unit, rates, n));
}

FMI Status NAME(fmi3GetNumberOfEventIndicators)(void *unit, size_t *n) {
    UNUSED(unit);
    *n = 0;
    return OK;
}

FMI Status NAME(fmi3GetNumberOfContinuousStates)(void *unit, size_t *n) {
    UNUSED(unit);
    *n = N_X;
    return OK;
}

/* ---- Co-simulation --------------------------------------------------------------------------------------------- */

FMI Status NAME(fmi3GetOutputDerivatives)(void *unit, References references, size_t n, const int32_t orders[],
                                          double values[], size_t n_values) {
    UNUSED(references), UNUSED(orders), UNUSED(values);
    return n || n_values ? unsupported(unit, "This unit gives no derivatives of outputs.") : OK;
}

FMI Status NAME(fmi3DoStep)(void *unit, double t, double h, bool final, bool *event, bool *ends, bool *early,
                            double *reached) {
    const int failed = advance(unit, t, h);
    UNUSED(final);
    *event = *ends = *early = false;
    *reached = ((Unit *)unit)->kept[0];
    return done(failed);
}
