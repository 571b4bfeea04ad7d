/* A unit that harms its importer when it is told to. */

#include <math.h>
#include <unistd.h>

#define COUNT 3
#include "plant.h"

enum { DEED, VALUE, ADDED };
enum { NOTHING, CRASH, HANG, END, FAILS, NOT_A_NUMBER, PRINT, DISCARD,
       INFINITE, HUGE, TINY, WARNS, FATAL, EVENT, TERMINATES, EARLY };

static void begin(plant *p) {}

static int step(plant *p, double time, double size) {
    p->v[VALUE] += 1.0 + p->v[ADDED];
    switch ((int)p->v[DEED]) {
    case CRASH:
        fprintf(stderr, "about to crash\n");
        *(volatile int *)8 = 1;
        break;
    case HANG:
        for (;;)
            pause();
    case END:
        fprintf(stderr, "the licence has expired\n");
        exit(7);
    case FAILS:
        say(p, 3, "the solver did not converge");
        return 3;
    case NOT_A_NUMBER:
        p->v[VALUE] = NAN;
        break;
    case PRINT:
        for (int n = 0; n < 1000; n++)
            printf("step %d at %g with much text behind it\n", n, time);
        fflush(stdout);
        break;
    case DISCARD:
        return 2;
    case INFINITE:
        p->v[VALUE] = -INFINITY;
        break;
    case HUGE:
        p->v[VALUE] = 1e308;
        break;
    case TINY:
        p->v[VALUE] = 5e-324;
        break;
    case WARNS:
        say(p, 1, "close to a limit");
        return 1;
    case FATAL:
        say(p, 4, "out of memory");
        return 4;
    case EVENT:
        p->event = true;
        break;
    case TERMINATES:
        p->terminate = true;
        break;
    case EARLY:
        p->early = true;
        break;
    }
    return 0;
}
