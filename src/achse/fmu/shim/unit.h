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

/* Modes of an instance (FMI 3.0.2, 4.2.1). */
typedef enum { INSTANTIATED, INITIALIZING, STEPPING, TERMINATED } unit_mode;

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

/* Instances that were made and not freed: importers may pass others, after a second free for
example. All functions below take NULL for a unit, and answer an error. */
void instance_made(void *instance);
bool instance_lives(const void *instance);
/* False if it was not made, or is freed already. */
bool instance_freed(void *instance);

/* Start the process; NULL after a failure, which is logged. `resources` is a path. */
unit *unit_open(const char *resources, const char *token, bool verbose, unit_log log, void *owner);
/* End the process and all saved states. */
void unit_close(unit *self);
/* Start again with a fresh station. */
unit_status unit_reset(unit *self);
void unit_verbose(unit *self, bool verbose);
/* Go from one of two modes to the next. `what` is the function that was called. */
unit_status unit_go(unit *self, const char *what, unit_mode from, unit_mode or_from, unit_mode next);
/* Times of the importer; the mode has to be the first. */
unit_status unit_begin(unit *self, double start, bool has_stop, double stop);
unit_status unit_step(unit *self, double at, double by);

/* The variable of a reference; NULL for an unknown one, which is logged. */
const variable *unit_variable(unit *self, uint32_t reference);
/* Arrays of a call: an error for NULL where something should be. */
unit_status unit_arrays(unit *self, size_t count, const void *references, const void *values);
/* An error for a number that no process image may have: not a number, infinity. */
unit_status unit_finite(unit *self, uint32_t reference, double value);
/* UNIT_ERROR, or UNIT_FATAL once the process has ended. */
unit_status unit_failure(const unit *self);
/* Bytes of a variable in the image, brought up to date; NULL after a failure. */
const void *unit_read(unit *self, const variable *which);
/* Bytes to fill; NULL if the variable cannot be set. */
void *unit_write(unit *self, const variable *which);
/* Set a text; with `only_check` nothing but what speaks against it is said. */
unit_status unit_write_text(unit *self, const variable *which, const char *text, bool only_check);
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
