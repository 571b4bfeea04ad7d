/* The unit: its image of values, its steps, its saved states. */

#define _GNU_SOURCE
#include "process.h"

#include <math.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LONGEST_TEXT = 4000, LONGEST_STATE = 1 << 30 };

static const char *const MODES[] = {"instantiated", "initialization mode", "step mode", "terminated"};

/* Instances */

typedef struct entry {
    void *instance;
    struct entry *next;
} entry;

static entry *instances;
static atomic_flag busy = ATOMIC_FLAG_INIT; /* importers may have a thread for each instance */

static void begin_list(void) {
    while (atomic_flag_test_and_set(&busy))
        ;
}

static void end_list(void) { atomic_flag_clear(&busy); }

void instance_made(void *instance) {
    entry *made = malloc(sizeof *made);
    if (made == NULL)
        return; /* it then counts as freed: calls answer an error */
    made->instance = instance;
    begin_list();
    made->next = instances;
    instances = made;
    end_list();
}

bool instance_lives(const void *instance) {
    begin_list();
    const entry *each = instances;
    while (each != NULL && each->instance != instance)
        each = each->next;
    end_list();
    return each != NULL;
}

bool instance_freed(void *instance) {
    entry *gone = NULL;
    begin_list();
    for (entry **each = &instances; *each != NULL; each = &(*each)->next)
        if ((*each)->instance == instance) {
            gone = *each;
            *each = gone->next;
            break;
        }
    end_list();
    free(gone);
    return gone != NULL;
}

/* Errors */

unit_status unit_error(unit *self, const char *format, ...) {
    char text[LONGEST_TEXT];
    if (self == NULL)
        return UNIT_ERROR;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    self->log(self->owner, UNIT_ERROR, "logStatusError", text);
    return UNIT_ERROR;
}

unit_status unit_refuse(unit *self, const char *what) {
    return unit_error(self, "%s: not supported by this unit", what);
}

static unit_status take_image(unit *self, size_t size) {
    if (size != self->image_size)
        return unit_error(self, "image: expected %u bytes, got %zu", self->image_size, size);
    memcpy(self->image, self->buffer, size);
    return UNIT_OK;
}

static unit_status greet(unit *self) {
    size_t resources = strlen(self->resources) + 1, token = strlen(self->token) + 1, size = 0;
    uint32_t version = PROTOCOL;
    char *names = malloc(resources + token);
    if (names == NULL)
        return unit_error(self, "no memory");
    memcpy(names, self->resources, resources);
    memcpy(names + resources, self->token, token);
    unit_status status = process_call(self, self->channel, OPEN, &version, sizeof version, names,
                              resources + token, &size, NULL);
    free(names);
    if (status != UNIT_OK)
        return status;
    uint32_t counts[3];
    if (size < sizeof counts)
        return unit_error(self, "table: expected %zu bytes or more, got %zu", sizeof counts, size);
    memcpy(counts, self->buffer, sizeof counts);
    size_t table = (size_t)counts[0] * sizeof(variable);
    if (size != sizeof counts + table + counts[2] || counts[1] > counts[2])
        return unit_error(self, "table: %u variables and %u bytes of values do not fit into %zu",
                          counts[0], counts[2], size);
    free(self->variables);
    free(self->image);
    self->variables = malloc(table + 1);
    self->image = malloc((size_t)counts[2] + 1);
    if (self->variables == NULL || self->image == NULL)
        return unit_error(self, "no memory");
    self->variable_count = counts[0];
    self->input_size = counts[1];
    self->image_size = counts[2];
    memcpy(self->variables, self->buffer + sizeof counts, table);
    memcpy(self->image, self->buffer + sizeof counts + table, counts[2]);
    for (uint32_t i = 0; i < self->variable_count; i++) {
        const variable *each = &self->variables[i];
        if (each->offset > self->image_size || each->size > self->image_size - each->offset)
            return unit_error(self, "table: variable %u is outside of the image", i);
    }
    self->inputs_changed = false;
    return UNIT_OK;
}

/* The unit */

unit *unit_open(const char *resources, const char *token, bool verbose, unit_log log, void *owner) {
    unit *self = calloc(1, sizeof *self);
    if (self == NULL)
        return NULL;
    self->log = log;
    self->owner = owner;
    self->verbose = verbose;
    self->first_channel = self->channel = -1;
    self->resources = strdup(resources == NULL ? "" : resources);
    self->token = strdup(token == NULL ? "" : token);
    if (self->resources == NULL || self->token == NULL || process_start(self) != UNIT_OK
        || greet(self) != UNIT_OK) {
        unit_close(self);
        return NULL;
    }
    return self;
}

void unit_close(unit *self) {
    if (self == NULL)
        return;
    process_stop(self);
    free(self->resources);
    free(self->token);
    free(self->variables);
    free(self->image);
    free(self->buffer);
    free(self);
}

unit_status unit_reset(unit *self) {
    if (self == NULL)
        return UNIT_ERROR;
    process_stop(self);
    self->time = self->start = 0.0;
    self->mode = INSTANTIATED;
    unit_status status = process_start(self);
    return status == UNIT_OK ? greet(self) : status;
}

void unit_verbose(unit *self, bool verbose) {
    if (self != NULL)
        self->verbose = verbose;
}

unit_status unit_failure(const unit *self) {
    return self != NULL && self->dead ? UNIT_FATAL : UNIT_ERROR;
}

unit_status unit_go(unit *self, const char *what, unit_mode from, unit_mode or_from, unit_mode next) {
    if (self == NULL)
        return UNIT_ERROR;
    if (self->mode != from && self->mode != or_from)
        return unit_error(self, "%s: expected %s, the mode is: %s", what, MODES[from],
                          MODES[self->mode]);
    if (self->dead)
        return UNIT_FATAL;
    self->mode = next;
    return UNIT_OK;
}

unit_status unit_begin(unit *self, double start, bool has_stop, double stop) {
    if (self == NULL)
        return UNIT_ERROR;
    if (self->mode != INSTANTIATED)
        return unit_error(self, "start: expected %s, the mode is: %s", MODES[INSTANTIATED],
                          MODES[self->mode]);
    if (!isfinite(start) || (has_stop && !(stop >= start)))
        return unit_error(self, "start: expected a finite time and a stop not before it, got %g s"
                          " and %g s", start, has_stop ? stop : INFINITY);
    self->start = self->time = start;
    return UNIT_OK;
}

double unit_last_time(unit *self) { return self == NULL ? 0.0 : self->time; }

/* Send changed inputs, and receive the image at a station time (ns). */
static unit_status exchange(unit *self, uint32_t kind, uint64_t number) {
    size_t size = 0;
    size_t inputs = self->inputs_changed ? self->input_size : 0;
    unit_status status =
        process_call(self, self->channel, kind, &number, sizeof number, self->image, inputs, &size, NULL);
    if (status != UNIT_OK)
        return status;
    self->inputs_changed = false;
    return take_image(self, size);
}

unit_status unit_step(unit *self, double at, double by) {
    unit_status right = unit_go(self, "step", STEPPING, STEPPING, STEPPING);
    if (right != UNIT_OK)
        return right;
    double tolerance = 1e-9 * fmax(1.0, fabs(at));
    if (!(fabs(at - self->time) <= tolerance))
        return unit_error(self, "communication point: expected %.17g s, got %.17g s", self->time, at);
    if (!(by >= 0.0) || !(at + by - self->start < 9.0e9))
        return unit_error(self, "step: expected 0 s or more and an end below 9e9 s, got %.17g s", by);
    double end = at + by;
    unit_status status =
        exchange(self, STEP, (uint64_t)llround(fmax(0.0, end - self->start) * 1e9));
    if (status == UNIT_OK)
        self->time = end;
    return status;
}

const variable *unit_variable(unit *self, uint32_t reference) {
    if (self == NULL)
        return NULL;
    if (reference < self->variable_count)
        return &self->variables[reference];
    unit_error(self, "value reference %u: expected one below %u", reference, self->variable_count);
    return NULL;
}

unit_status unit_arrays(unit *self, size_t count, const void *references, const void *values) {
    if (self == NULL)
        return UNIT_ERROR;
    if (count > 0 && (references == NULL || values == NULL))
        return unit_error(self, "expected %zu value references and their values, got NULL", count);
    return UNIT_OK;
}

unit_status unit_finite(unit *self, uint32_t reference, double value) {
    if (isfinite(value))
        return UNIT_OK;
    return unit_error(self, "value reference %u: expected a finite number, got %g", reference, value);
}

const void *unit_read(unit *self, const variable *which) {
    if (self->dead || self->channel < 0)
        return NULL;
    if (which->source == FROM_TIME)
        return &self->time;
    if (which->source == ON_REQUEST
        && exchange(self, REFRESH, (uint64_t)(which - self->variables)) != UNIT_OK)
        return NULL;
    return self->image + which->offset;
}

void *unit_write(unit *self, const variable *which) {
    if (!which->settable) {
        unit_error(self, "value reference %u: not an input or a parameter",
                   (unsigned)(which - self->variables));
        return NULL;
    }
    if (self->mode == TERMINATED) {
        unit_error(self, "value reference %u: the unit is terminated, reset it to set values",
                   (unsigned)(which - self->variables));
        return NULL;
    }
    self->inputs_changed = true;
    return self->image + which->offset;
}

unit_status unit_write_text(unit *self, const variable *which, const char *text, bool only_check) {
    size_t length = text == NULL ? 0 : strlen(text);
    if (which->size == 0 || length > which->size - 1)
        return unit_error(self, "value reference %u: a text of %zu bytes, expected at most %u",
                          (unsigned)(which - self->variables), length, which->size - 1);
    char *place = unit_write(self, which);
    if (place == NULL || only_check)
        return place == NULL ? UNIT_ERROR : UNIT_OK;
    memset(place, 0, which->size);
    memcpy(place, text == NULL ? "" : text, length);
    return UNIT_OK;
}

/* Saved states: each is a process that waits at a channel of its own */

static unit_status keep(unit *self, int channel, unit_mode mode, unit_state **state) {
    unit_state *made = channel < 0 ? NULL : calloc(1, sizeof *made);
    if (made == NULL) {
        if (channel >= 0)
            close(channel);
        return unit_error(self, "the state has no channel");
    }
    made->channel = channel;
    made->mode = mode;
    made->next = self->states;
    self->states = made;
    *state = made;
    return UNIT_OK;
}

static unit_status without_state(unit *self) {
    return unit_error(self, "expected a place for the state, got NULL");
}

unit_status unit_save(unit *self, unit_state **state) {
    int channel = -1;
    if (self == NULL || state == NULL)
        return without_state(self);
    double time = self->time - self->start;
    if (*state != NULL) { /* an older state to overwrite */
        unit_drop(self, *state);
        *state = NULL;
    }
    if (self->inputs_changed) {
        unit_status status = exchange(self, REFRESH, UINT64_MAX);
        if (status != UNIT_OK)
            return status;
    }
    unit_status status =
        process_call(self, self->channel, SAVE, &time, sizeof time, NULL, 0, NULL, &channel);
    return status == UNIT_OK ? keep(self, channel, self->mode, state) : status;
}

static bool is_kept(const unit *self, const unit_state *state) {
    const unit_state *each = self->states;
    while (each != NULL && each != state)
        each = each->next;
    return each != NULL;
}

unit_status unit_restore(unit *self, unit_state *state) {
    if (self == NULL)
        return UNIT_ERROR;
    if (!is_kept(self, state))
        return unit_error(self, "expected a state of this unit that was not freed");
    int channel = -1;
    size_t size = 0;
    double time;
    unit_status status = process_call(self, state->channel, RESTORE, NULL, 0, NULL, 0, &size, &channel);
    if (status != UNIT_OK)
        return status;
    if (channel < 0 || size != sizeof time + self->image_size) {
        if (channel >= 0)
            close(channel);
        return unit_error(self, "the restored state has no channel");
    }
    if (self->channel != self->first_channel)
        close(self->channel);
    self->channel = channel;
    self->inputs_changed = false;
    memcpy(&time, self->buffer, sizeof time);
    memcpy(self->image, self->buffer + sizeof time, self->image_size);
    self->time = self->start + time;
    self->mode = state->mode;
    return UNIT_OK;
}

void unit_drop(unit *self, unit_state *state) {
    if (self == NULL)
        return;
    for (unit_state **each = &self->states; *each != NULL; each = &(*each)->next)
        if (*each == state) {
            *each = state->next;
            close(state->channel);
            free(state->packed);
            free(state);
            return;
        }
}

unit_status unit_pack(unit *self, unit_state *state, const void **bytes, size_t *size) {
    if (self == NULL || size == NULL)
        return without_state(self);
    if (!is_kept(self, state))
        return unit_error(self, "expected a state of this unit that was not freed");
    if (state->packed == NULL) {
        size_t length = 0;
        unit_status status = process_call(self, state->channel, PACK, NULL, 0, NULL, 0, &length, NULL);
        if (status != UNIT_OK)
            return status;
        state->packed = malloc(length + 1);
        if (state->packed == NULL)
            return unit_error(self, "no memory for a state of %zu bytes", length);
        memcpy(state->packed, self->buffer, length);
        ((uint8_t *)state->packed)[length] = (uint8_t)state->mode;
        state->packed_size = length + 1;
    }
    *bytes = state->packed;
    *size = state->packed_size;
    return UNIT_OK;
}

unit_status unit_unpack(unit *self, const void *bytes, size_t size, unit_state **state) {
    int channel = -1;
    if (self == NULL || state == NULL)
        return without_state(self);
    uint8_t mode = bytes == NULL || size == 0 ? UINT8_MAX : ((const uint8_t *)bytes)[size - 1];
    if (mode > TERMINATED || size > LONGEST_STATE)
        return unit_error(self, "state: expected bytes of a serialised state, got %zu others", size);
    if (*state != NULL) {
        unit_drop(self, *state);
        *state = NULL;
    }
    unit_status status =
        process_call(self, self->channel, UNPACK, NULL, 0, bytes, size - 1, NULL, &channel);
    return status == UNIT_OK ? keep(self, channel, (unit_mode)mode, state) : status;
}
