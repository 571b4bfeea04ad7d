/* The process of a unit and its messages: between process.c and unit.c alone. */

#ifndef ACHSE_PROCESS_H
#define ACHSE_PROCESS_H

#include "unit.h"

#include <stdio.h>
#include <sys/types.h>

enum { PROTOCOL = 1 };

/* Requests, in the order of achse.fmu.protocol.Request. */
enum { OPEN, STEP, REFRESH, SAVE, RESTORE, PACK, UNPACK };

struct unit_state {
    int channel;
    unit_mode mode;
    void *packed; /* with the mode as its last byte */
    size_t packed_size;
    unit_state *next;
};

struct unit {
    unit_log log;
    void *owner;
    bool verbose;
    char *resources;
    char *token;
    pid_t process;
    int first_channel; /* of the process that was started; the parent of all others */
    int channel;       /* of the process that is the model now */
    FILE *errors;      /* what the process wrote to its standard error */
    bool dead;
    unit_mode mode;
    bool inputs_changed;
    double start, time;
    uint32_t variable_count, input_size, image_size;
    variable *variables;
    uint8_t *image;
    uint8_t *buffer;
    size_t capacity;
    unit_state *states;
};

/* Start the process of the unit. */
unit_status process_start(unit *self);
/* End the process and all saved states. */
void process_stop(unit *self);
/* One round trip. The content of the reply is in the buffer, followed by a zero byte; a descriptor
that comes with it goes to `passed`. `first` has at most 64 bytes. */
unit_status process_call(unit *self, int channel, uint32_t kind, const void *first,
                         size_t first_size, const void *second, size_t second_size, size_t *size,
                         int *passed);

#endif
