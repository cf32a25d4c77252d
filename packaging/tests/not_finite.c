/* A model of FMI 2.0 whose numbers are 1, but for the variable REFERENCE, which is NUMBER from TIME on. */

#include <math.h>
#include <stdlib.h>

typedef void *component;
typedef const char *string;
typedef unsigned reference;

component fmi2Instantiate(string name, int kind, string guid, string resources, const void *functions,
                          int visible, int logging) {
    return calloc(1, sizeof(double));
}

void fmi2FreeInstance(component c) { free(c); }

int fmi2SetupExperiment(component c, int has_tolerance, double tolerance, double start, int has_stop,
                        double stop) {
    return 0;
}

int fmi2EnterInitializationMode(component c) { return 0; }
int fmi2ExitInitializationMode(component c) { return 0; }
int fmi2Terminate(component c) { return 0; }
int fmi2Reset(component c) { return 0; }
int fmi2SetReal(component c, const reference *of, size_t count, const double *values) { return 0; }
int fmi2SetInteger(component c, const reference *of, size_t count, const int *values) { return 0; }
int fmi2SetBoolean(component c, const reference *of, size_t count, const int *values) { return 0; }

int fmi2DoStep(component c, double time, double step, int no_return) {
    *(double *)c = time + step;
    return 0;
}

int fmi2GetReal(component c, const reference *of, size_t count, double *values) {
    for (size_t k = 0; k < count; k++)
        values[k] = of[k] == REFERENCE && *(double *)c > TIME ? NUMBER : 1.0;
    return 0;
}

int fmi2GetInteger(component c, const reference *of, size_t count, int *values) {
    for (size_t k = 0; k < count; k++)
        values[k] = 1;
    return 0;
}

int fmi2GetBoolean(component c, const reference *of, size_t count, int *values) {
    for (size_t k = 0; k < count; k++)
        values[k] = 0;
    return 0;
}

int fmi2GetString(component c, const reference *of, size_t count, string *values) {
    for (size_t k = 0; k < count; k++)
        values[k] = "";
    return 0;
}
