/* Drives the library of an FMI 2.0 Co-Simulation unit: loader LIBRARY JOB RESULT.
 *
 * JOB, in the machine's byte order (all platforms are little-endian): struct job, the value references of
 * inputs and of outputs (Reals, Integers, Booleans), then a row a step: its time in s and the inputs, all as
 * double. RESULT: a row of outputs after initialisation with the first row's inputs, and one after each step.
 * Exit status 0 if every call returned fmi2OK and nothing was logged as a warning or worse. */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <windows.h>
#define OPEN(path) ((void *)LoadLibraryA(path))
#define FIND(library, name) ((void *)(uintptr_t)GetProcAddress((HMODULE)(library), name))
#else
#include <dlfcn.h>
#define OPEN(path) dlopen(path, RTLD_NOW | RTLD_LOCAL)
#define FIND(library, name) dlsym(library, name)
#endif

typedef void *component;
typedef int status;

struct callbacks {
    void (*log)(void *, const char *, status, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, status);
    void *environment;
};

enum { REALS, INTEGERS, BOOLEANS, KINDS };

struct job {
    char guid[64];
    double step_s;
    uint32_t inputs[KINDS], outputs[KINDS], rows, padding;
};

static int complaints;

static void fail(const char *what, const char *of)
{
    fprintf(stderr, "loader: %s: %s\n", what, of);
    exit(1);
}

static void log_message(void *environment, const char *name, status s, const char *category,
                        const char *message, ...)
{
    (void)environment;
    if (s > 0) {
        complaints++;
        fprintf(stderr, "%s [%s] %s\n", name, category, message);
    }
}

static void *library;

static void *function(const char *name)
{
    void *found = FIND(library, name);
    if (!found)
        fail("not exported", name);
    return found;
}

#define CALL(name, types, ...)                           \
    do {                                                 \
        status (*call) types = function(#name);          \
        if (call(__VA_ARGS__) != 0)                      \
            fail("not fmi2OK", #name);                   \
    } while (0)

static void take(FILE *file, void *bytes, size_t size)
{
    if (fread(bytes, 1, size, file) != size)
        fail("cannot read", "job");
}

static uint32_t *references(FILE *file, const uint32_t *counts, uint32_t *total)
{
    *total = counts[REALS] + counts[INTEGERS] + counts[BOOLEANS];
    uint32_t *list = calloc(*total + 1, sizeof *list);
    take(file, list, *total * sizeof *list);
    return list;
}

static void set(component c, const uint32_t *list, const uint32_t *counts, const double *values)
{
    int whole[64];
    if (counts[INTEGERS] + counts[BOOLEANS] > 64)
        fail("too many inputs", "job");
    const uint32_t *discrete = list + counts[REALS];
    for (uint32_t i = 0; i < counts[INTEGERS] + counts[BOOLEANS]; i++)
        whole[i] = (int)values[counts[REALS] + i];
    if (counts[REALS])
        CALL(fmi2SetReal, (component, const uint32_t *, size_t, const double *), c, list, counts[REALS], values);
    if (counts[INTEGERS])
        CALL(fmi2SetInteger, (component, const uint32_t *, size_t, const int *), c, discrete, counts[INTEGERS],
             whole);
    if (counts[BOOLEANS])
        CALL(fmi2SetBoolean, (component, const uint32_t *, size_t, const int *), c, discrete + counts[INTEGERS],
             counts[BOOLEANS], whole + counts[INTEGERS]);
}

static void get(component c, const uint32_t *list, const uint32_t *counts, double *values)
{
    int whole[1024];
    if (counts[INTEGERS] + counts[BOOLEANS] > 1024)
        fail("too many outputs", "job");
    const uint32_t *discrete = list + counts[REALS];
    if (counts[REALS])
        CALL(fmi2GetReal, (component, const uint32_t *, size_t, double *), c, list, counts[REALS], values);
    if (counts[INTEGERS])
        CALL(fmi2GetInteger, (component, const uint32_t *, size_t, int *), c, discrete, counts[INTEGERS], whole);
    if (counts[BOOLEANS])
        CALL(fmi2GetBoolean, (component, const uint32_t *, size_t, int *), c, discrete + counts[INTEGERS],
             counts[BOOLEANS], whole + counts[INTEGERS]);
    for (uint32_t i = 0; i < counts[INTEGERS] + counts[BOOLEANS]; i++)
        values[counts[REALS] + i] = whole[i];
}

int main(int count, char **arguments)
{
    if (count != 4)
        fail("usage", "loader LIBRARY JOB RESULT");
    FILE *job_file = fopen(arguments[2], "rb"), *result = fopen(arguments[3], "wb");
    if (!job_file || !result)
        fail("cannot open", "job or result");
    struct job job;
    take(job_file, &job, sizeof job);
    uint32_t inputs, outputs;
    uint32_t *set_list = references(job_file, job.inputs, &inputs);
    uint32_t *get_list = references(job_file, job.outputs, &outputs);
    double *row = calloc(inputs + 1, sizeof *row), *values = calloc(outputs + 1, sizeof *values);

    library = OPEN(arguments[1]);
    if (!library)
        fail("cannot load", arguments[1]);
    struct callbacks callbacks = { log_message, calloc, free, NULL, NULL };
    component (*instantiate)(const char *, int, const char *, const char *, const struct callbacks *, int, int) =
        function("fmi2Instantiate");
    component c = instantiate("loaded", 1, job.guid, "", &callbacks, 0, 1);
    if (!c)
        fail("refused", "fmi2Instantiate");
    CALL(fmi2SetupExperiment, (component, int, double, double, int, double), c, 0, 0.0, 0.0, 0, 0.0);
    for (uint32_t k = 0; k < job.rows; k++) {
        take(job_file, row, (inputs + 1) * sizeof *row);
        if (k == 0)
            CALL(fmi2EnterInitializationMode, (component), c);
        set(c, set_list, job.inputs, row + 1);
        if (k == 0) {
            CALL(fmi2ExitInitializationMode, (component), c);
            get(c, get_list, job.outputs, values);
            fwrite(values, sizeof *values, outputs, result);
        }
        CALL(fmi2DoStep, (component, double, double, int), c, row[0], job.step_s, 1);
        get(c, get_list, job.outputs, values);
        fwrite(values, sizeof *values, outputs, result);
    }
    CALL(fmi2Terminate, (component), c);
    void (*release)(component) = function("fmi2FreeInstance");
    release(c);
    if (fclose(result))
        fail("cannot write", arguments[3]);
    return complaints ? 1 : 0;
}
