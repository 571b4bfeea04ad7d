/* An importer of FMI 3.0 units in C: loads a unit, steps two instances, prints their digests.

usage: importer LIBRARY RESOURCES TOKEN DIGEST STEPS STEP_SIZE [VR=VALUE …]

DIGEST is the value reference of the digest, VR=VALUE sets a Float64 before the first step. Ends with
1 after a status that is not fmi3OK; log messages go to stderr. */

#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

typedef void *(*instantiate)(const char *, const char *, const char *, bool, bool, bool, bool,
                             const uint32_t[], size_t, void *,
                             void (*)(void *, int, const char *, const char *), void *);
typedef int (*initialise)(void *, bool, double, double, bool, double);
typedef int (*simple)(void *);
typedef int (*step)(void *, double, double, bool, bool *, bool *, bool *, double *);
typedef int (*set_real)(void *, const uint32_t[], size_t, const double[], size_t);
typedef int (*get_text)(void *, const uint32_t[], size_t, const char *[], size_t);
typedef void (*release)(void *);

static void print_log(void *environment, int status, const char *category, const char *text) {
    fprintf(stderr, "%s %d %s: %s\n", (const char *)environment, status, category, text);
}

static void *function(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (found == NULL) {
        fprintf(stderr, "%s: %s\n", name, dlerror());
        exit(2);
    }
    return found;
}

static void check(int status, const char *what) {
    if (status != 0) {
        fprintf(stderr, "%s: status %d\n", what, status);
        exit(1);
    }
}

int main(int count, char **arguments) {
    if (count < 7)
        return 2;
    void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return 2;
    }
    instantiate make = (instantiate)function(library, "fmi3InstantiateCoSimulation");
    initialise enter = (initialise)function(library, "fmi3EnterInitializationMode");
    simple leave = (simple)function(library, "fmi3ExitInitializationMode");
    simple terminate = (simple)function(library, "fmi3Terminate");
    step do_step = (step)function(library, "fmi3DoStep");
    set_real set = (set_real)function(library, "fmi3SetFloat64");
    get_text get = (get_text)function(library, "fmi3GetString");
    release release_instance = (release)function(library, "fmi3FreeInstance");
    uint32_t digest = (uint32_t)atoi(arguments[4]);
    int steps = atoi(arguments[5]);
    double size = atof(arguments[6]);
    void *instances[2];
    char *names[2] = {"first", "second"};
    for (int i = 0; i < 2; i++) {
        instances[i] = make(names[i], arguments[3], arguments[2], false, false, false, false, NULL,
                            0, names[i], print_log, NULL);
        if (instances[i] == NULL)
            return 1;
        check(enter(instances[i], false, 0.0, 0.0, false, 0.0), "fmi3EnterInitializationMode");
        for (int n = 7; n < count; n++) {
            uint32_t reference;
            double value;
            if (sscanf(arguments[n], "%u=%lf", &reference, &value) != 2)
                return 2;
            check(set(instances[i], &reference, 1, &value, 1), "fmi3SetFloat64");
        }
        check(leave(instances[i]), "fmi3ExitInitializationMode");
    }
    for (int n = 0; n < steps; n++)
        for (int i = 0; i < 2; i++) {
            bool event, end, early;
            double time = 0.0;
            check(do_step(instances[i], n * size, size, true, &event, &end, &early, &time),
                  "fmi3DoStep");
        }
    for (int i = 0; i < 2; i++) {
        const char *text;
        check(get(instances[i], &digest, 1, &text, 1), "fmi3GetString");
        printf("%s %s\n", names[i], text);
        check(terminate(instances[i]), "fmi3Terminate");
        release_instance(instances[i]);
    }
    dlclose(library);
    return 0;
}
