/* The unit: its image of values, its steps, its saved states. */

#define _GNU_SOURCE
#include "process.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LONGEST_TEXT = 4000 };

unit_status unit_error(unit *self, const char *format, ...) {
    char text[LONGEST_TEXT];
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
    process_stop(self);
    self->time = self->start = 0.0;
    unit_status status = process_start(self);
    return status == UNIT_OK ? greet(self) : status;
}

void unit_verbose(unit *self, bool verbose) { self->verbose = verbose; }

void unit_begin(unit *self, double start_time) { self->start = self->time = start_time; }

double unit_last_time(unit *self) { return self->time; }

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
    if (reference < self->variable_count)
        return &self->variables[reference];
    unit_error(self, "value reference %u: expected one below %u", reference, self->variable_count);
    return NULL;
}

const void *unit_read(unit *self, const variable *which) {
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
    self->inputs_changed = true;
    return self->image + which->offset;
}

unit_status unit_write_text(unit *self, const variable *which, const char *text) {
    size_t length = text == NULL ? 0 : strlen(text);
    if (which->size == 0 || length > which->size - 1)
        return unit_error(self, "value reference %u: a text of %zu bytes, expected at most %u",
                          (unsigned)(which - self->variables), length, which->size - 1);
    char *place = unit_write(self, which);
    if (place == NULL)
        return UNIT_ERROR;
    memset(place, 0, which->size);
    memcpy(place, text == NULL ? "" : text, length);
    return UNIT_OK;
}

/* Saved states: each is a process that waits at a channel of its own */

static unit_status keep(unit *self, int channel, unit_state **state) {
    unit_state *made = channel < 0 ? NULL : calloc(1, sizeof *made);
    if (made == NULL) {
        if (channel >= 0)
            close(channel);
        return unit_error(self, "the state has no channel");
    }
    made->channel = channel;
    made->next = self->states;
    self->states = made;
    *state = made;
    return UNIT_OK;
}

unit_status unit_save(unit *self, unit_state **state) {
    int channel = -1;
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
    return status == UNIT_OK ? keep(self, channel, state) : status;
}

static bool is_kept(const unit *self, const unit_state *state) {
    const unit_state *each = self->states;
    while (each != NULL && each != state)
        each = each->next;
    return each != NULL;
}

unit_status unit_restore(unit *self, unit_state *state) {
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
    return UNIT_OK;
}

void unit_drop(unit *self, unit_state *state) {
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
        state->packed_size = length;
    }
    *bytes = state->packed;
    *size = state->packed_size;
    return UNIT_OK;
}

unit_status unit_unpack(unit *self, const void *bytes, size_t size, unit_state **state) {
    int channel = -1;
    if (*state != NULL) {
        unit_drop(self, *state);
        *state = NULL;
    }
    unit_status status =
        process_call(self, self->channel, UNPACK, NULL, 0, bytes, size, NULL, &channel);
    return status == UNIT_OK ? keep(self, channel, state) : status;
}
