/* A co-simulation unit whose model is a station in a process of its own.

The shim has no variables of its own: the process sends a table of them and an image of their
values. Set and get work on the image; a step sends the inputs that have changed and receives the
whole image. Messages are listed in achse.fmu.protocol; numbers are little-endian, as on all
platforms that the shim is compiled for. */

#ifndef ACHSE_UNIT_H
#define ACHSE_UNIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum { UNIT_OK, UNIT_WARNING, UNIT_DISCARD, UNIT_ERROR, UNIT_FATAL } unit_status;

/* Types of values, in the order of achse.fmu.variables.ValueType. */
typedef enum {
    TYPE_BOOLEAN, TYPE_INT8, TYPE_UINT8, TYPE_INT16, TYPE_UINT16, TYPE_INT32, TYPE_UINT32,
    TYPE_INT64, TYPE_UINT64, TYPE_FLOAT32, TYPE_FLOAT64, TYPE_STRING
} value_type;

/* Where a value comes from. */
typedef enum { FROM_IMAGE, ON_REQUEST, FROM_TIME } value_source;

/* One row of the table; the value reference is its number. */
typedef struct {
    uint8_t type;
    uint8_t settable;
    uint8_t source; /* one of value_source */
    uint8_t reserved;
    uint32_t count; /* values: elements of an array */
    uint32_t offset;
    uint32_t size; /* bytes of all values in the image */
} variable;

typedef void (*unit_log)(void *owner, unit_status status, const char *category, const char *text);

typedef struct unit unit;
typedef struct unit_state unit_state;

/* Start the process; NULL after a failure, which is logged. `resources` is a path. */
unit *unit_open(const char *resources, const char *token, bool verbose, unit_log log, void *owner);
/* End the process and all saved states. */
void unit_close(unit *self);
/* Start again with a fresh station. */
unit_status unit_reset(unit *self);
void unit_verbose(unit *self, bool verbose);
void unit_begin(unit *self, double start);
unit_status unit_step(unit *self, double at, double by);

/* The variable of a reference; NULL for an unknown one, which is logged. */
const variable *unit_variable(unit *self, uint32_t reference);
/* Bytes of a variable in the image, brought up to date; NULL after a failure. */
const void *unit_read(unit *self, const variable *which);
/* Bytes to fill; NULL if the variable cannot be set. */
void *unit_write(unit *self, const variable *which);
unit_status unit_write_text(unit *self, const variable *which, const char *text);
double unit_last_time(unit *self);

unit_status unit_save(unit *self, unit_state **state);
unit_status unit_restore(unit *self, unit_state *state);
void unit_drop(unit *self, unit_state *state);
/* Bytes of a saved state; they belong to the state. */
unit_status unit_pack(unit *self, unit_state *state, const void **bytes, size_t *size);
unit_status unit_unpack(unit *self, const void *bytes, size_t size, unit_state **state);

unit_status unit_refuse(unit *self, const char *what);
unit_status unit_error(unit *self, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
