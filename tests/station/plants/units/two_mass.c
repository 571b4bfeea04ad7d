/* A motor and a load on a spring with damping: torque in Nm, angles in rad. */

#define COUNT 9
#include "plant.h"

enum { TORQUE, MOTOR_ANGLE, MOTOR_SPEED, LOAD_ANGLE, LOAD_SPEED, MOTOR, LOAD, SPRING, DAMPER };
enum { PARTS = 50 };

static void begin(plant *p) {
    p->v[MOTOR] = 1e-3;
    p->v[LOAD] = 1e-3;
    p->v[SPRING] = 5000.0;
    p->v[DAMPER] = 0.5;
}

static int step(plant *p, double time, double size) {
    double *v = p->v, part = size / PARTS;
    for (int n = 0; n < PARTS; n++) {
        double between = v[SPRING] * (v[MOTOR_ANGLE] - v[LOAD_ANGLE])
                         + v[DAMPER] * (v[MOTOR_SPEED] - v[LOAD_SPEED]);
        v[MOTOR_SPEED] += part * (v[TORQUE] - between) / v[MOTOR];
        v[LOAD_SPEED] += part * between / v[LOAD];
        v[MOTOR_ANGLE] += part * v[MOTOR_SPEED];
        v[LOAD_ANGLE] += part * v[LOAD_SPEED];
    }
    return 0;
}
