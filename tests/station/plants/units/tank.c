/* A tank with a pump and an outlet: the level follows inflow minus outflow. */

#include <math.h>

#define COUNT 5
#include "plant.h"

enum { PUMP, VALVE, LEVEL, FULL, AREA };
enum { PARTS = 10 };

static void begin(plant *p) { p->v[AREA] = 2.0; }

static int step(plant *p, double time, double size) {
    double *v = p->v;
    for (int n = 0; n < PARTS; n++) {
        double flow = v[PUMP] - v[VALVE] * sqrt(fmax(v[LEVEL], 0.0));
        v[LEVEL] = fmax(0.0, v[LEVEL] + size / PARTS * flow / v[AREA]);
    }
    v[FULL] = v[LEVEL] > 1.0;
    return 0;
}
