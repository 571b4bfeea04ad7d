/* A belt that goes with its speed; a part of it is in front of a light barrier now and then. */

#include <math.h>

#define COUNT 5
#include "plant.h"

enum { SPEED, POSITION, BARRIER, COUNTED, PITCH };

static void begin(plant *p) { p->v[PITCH] = 0.5; }

static int step(plant *p, double time, double size) {
    double *v = p->v;
    v[POSITION] += size * v[SPEED];
    double within = fmod(v[POSITION], v[PITCH]);
    bool blocked = v[POSITION] > 0.1 && within < 0.1;
    v[COUNTED] += blocked && v[BARRIER] == 0.0;
    v[BARRIER] = blocked;
    return 0;
}
