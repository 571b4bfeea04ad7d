/* The process of a unit: its start, its messages, its end. */

#define _GNU_SOURCE
#include "process.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#ifndef MSG_NOSIGNAL
#define MSG_NOSIGNAL 0
#endif

extern char **environ;

enum { LONGEST_TEXT = 4000, LONGEST_BEGIN = 64, PATIENCE_MS = 5000 };

/* Replies, in the order of achse.fmu.protocol.Reply. */
enum { DONE, FAILED, LOG };

typedef struct {
    uint32_t kind;
    uint32_t size;
} header;

static void close_on_exec(int descriptor) {
    fcntl(descriptor, F_SETFD, fcntl(descriptor, F_GETFD) | FD_CLOEXEC);
}

static int pair(int ends[2]) {
#ifdef SOCK_CLOEXEC
    return socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends);
#else
    int failed = socketpair(AF_UNIX, SOCK_STREAM, 0, ends);
    if (!failed) {
        close_on_exec(ends[0]);
        close_on_exec(ends[1]);
    }
    return failed;
#endif
}

/* The Python that runs the station: ACHSE_PYTHON, the one that exported the unit, or python3. */
static void find_python(const char *resources, char *python, size_t size) {
    const char *named = getenv("ACHSE_PYTHON");
    if (named != NULL && *named != '\0') {
        snprintf(python, size, "%s", named);
        return;
    }
    char name[4096];
    snprintf(name, sizeof name, "%s/python.txt", resources);
    FILE *file = fopen(name, "r");
    if (file != NULL) {
        char *line = fgets(python, (int)size, file);
        fclose(file);
        if (line != NULL) {
            python[strcspn(python, "\r\n")] = '\0';
            if (access(python, X_OK) == 0)
                return;
        }
    }
    snprintf(python, size, "python3");
}

unit_status process_start(unit *self) {
    int ends[2];
    char python[4096];
    find_python(self->resources, python, sizeof python);
    self->errors = tmpfile();
    if (self->errors == NULL || pair(ends) != 0) {
        if (self->errors != NULL)
            fclose(self->errors);
        self->errors = NULL;
        return unit_error(self, "no channel to the station's process: %s", strerror(errno));
    }
    close_on_exec(fileno(self->errors));
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none, defaults;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 0);
    posix_spawn_file_actions_adddup2(&actions, fileno(self->errors), 1);
    posix_spawn_file_actions_adddup2(&actions, fileno(self->errors), 2);
    posix_spawnattr_init(&attributes);
    sigemptyset(&none);
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGCHLD);
    sigaddset(&defaults, SIGPIPE);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    /* a group of its own: Ctrl-C at a terminal is for the importer */
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(
        &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    char *arguments[] = {python, "-m", "achse.fmu", NULL};
    int failure = posix_spawnp(&self->process, python, &actions, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    if (failure != 0) {
        close(ends[0]);
        fclose(self->errors);
        self->errors = NULL;
        return unit_error(self, "cannot start %s: %s; expected a Python with achse, name it in"
                                " ACHSE_PYTHON", python, strerror(failure));
    }
    self->first_channel = self->channel = ends[0];
    self->dead = false;
    return UNIT_OK;
}

/* End of what the process wrote to its standard error. */
static void last_words(unit *self, char *text, size_t size) {
    text[0] = '\0';
    if (self->errors == NULL)
        return;
    fseek(self->errors, 0, SEEK_END);
    long end = ftell(self->errors);
    long begin = end > (long)size - 1 ? end - ((long)size - 1) : 0;
    fseek(self->errors, begin, SEEK_SET);
    size_t length = fread(text, 1, size - 1, self->errors);
    while (length > 0 && text[length - 1] == '\n')
        length--;
    text[length] = '\0';
}

/* Wait for the end of the process that was started; true with its status. */
static bool reap(unit *self, int *status) {
    pid_t process = self->process;
    self->process = 0;
    if (process <= 0)
        return false;
    for (int waited = 0;; waited++) {
        pid_t ended = waitpid(process, status, WNOHANG);
        if (ended == process)
            return true;
        if (ended < 0 && errno != EINTR)
            return false;
        if (waited == PATIENCE_MS)
            kill(-process, SIGKILL);
        struct timespec pause = {0, 1000000};
        nanosleep(&pause, NULL);
    }
}

static unit_status died(unit *self) {
    char words[LONGEST_TEXT - 200], text[LONGEST_TEXT], why[80] = "";
    int status;
    if (self->dead)
        return UNIT_FATAL;
    self->dead = true;
    if (self->channel == self->first_channel && reap(self, &status)) {
        if (WIFSIGNALED(status))
            snprintf(why, sizeof why, " by signal %d", WTERMSIG(status));
        else
            snprintf(why, sizeof why, " with exit code %d", WEXITSTATUS(status));
    }
    last_words(self, words, sizeof words);
    snprintf(text, sizeof text, "the station's process ended%s%s%s", why, *words ? ": " : "", words);
    self->log(self->owner, UNIT_FATAL, "logStatusFatal", text);
    return UNIT_FATAL;
}

void process_stop(unit *self) {
    for (unit_state *state = self->states; state != NULL;) {
        unit_state *next = state->next;
        close(state->channel);
        free(state->packed);
        free(state);
        state = next;
    }
    self->states = NULL;
    if (self->channel >= 0 && self->channel != self->first_channel)
        close(self->channel);
    if (self->first_channel >= 0)
        close(self->first_channel);
    self->channel = self->first_channel = -1;
    int status;
    reap(self, &status);
    if (self->errors != NULL)
        fclose(self->errors);
    self->errors = NULL;
}

/* Messages */

static bool reserve(unit *self, size_t size) {
    if (size <= self->capacity)
        return true;
    uint8_t *larger = realloc(self->buffer, size);
    if (larger == NULL)
        return false;
    self->buffer = larger;
    self->capacity = size;
    return true;
}

static bool send_all(int channel, const void *first, size_t first_size, const void *second,
                     size_t second_size) {
    struct iovec parts[2] = {{(void *)first, first_size}, {(void *)second, second_size}};
    struct msghdr message = {0};
    message.msg_iov = parts;
    message.msg_iovlen = 2;
    while (parts[0].iov_len + parts[1].iov_len > 0) {
        ssize_t sent = sendmsg(channel, &message, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR)
            continue;
        if (sent <= 0)
            return false;
        for (int part = 0; part < 2; part++) {
            size_t done = (size_t)sent < parts[part].iov_len ? (size_t)sent : parts[part].iov_len;
            parts[part].iov_base = (uint8_t *)parts[part].iov_base + done;
            parts[part].iov_len -= done;
            sent -= (ssize_t)done;
        }
    }
    return true;
}

/* Read exactly `size` bytes; a descriptor that comes with them goes to `passed`. */
static bool receive_all(int channel, void *data, size_t size, int *passed) {
    uint8_t *at = data;
    while (size > 0) {
        union {
            struct cmsghdr align;
            char space[CMSG_SPACE(sizeof(int))];
        } control;
        struct iovec part = {at, size};
        struct msghdr message = {0};
        message.msg_iov = &part;
        message.msg_iovlen = 1;
        message.msg_control = control.space;
        message.msg_controllen = sizeof control.space;
        ssize_t received = recvmsg(channel, &message, 0);
        if (received < 0 && errno == EINTR)
            continue;
        if (received <= 0)
            return false;
        struct cmsghdr *first = CMSG_FIRSTHDR(&message);
        if (first != NULL && first->cmsg_level == SOL_SOCKET && first->cmsg_type == SCM_RIGHTS) {
            int descriptor;
            memcpy(&descriptor, CMSG_DATA(first), sizeof descriptor);
            close_on_exec(descriptor);
            if (passed != NULL && *passed < 0)
                *passed = descriptor;
            else
                close(descriptor);
        }
        at += received;
        size -= (size_t)received;
    }
    return true;
}

static void log_line(unit *self, size_t size) {
    if (size < 1)
        return;
    unit_status status = self->buffer[0];
    self->buffer[size] = '\0';
    if (status > UNIT_FATAL)
        status = UNIT_ERROR;
    if (status != UNIT_OK || self->verbose)
        self->log(self->owner, status, "station", (const char *)self->buffer + 1);
}

unit_status process_call(unit *self, int channel, uint32_t kind, const void *first,
                         size_t first_size, const void *second, size_t second_size, size_t *size,
                         int *passed) {
    if (self->dead || channel < 0)
        return UNIT_FATAL;
    uint8_t begin[sizeof(header) + LONGEST_BEGIN];
    header request = {kind, (uint32_t)(first_size + second_size)};
    if (first_size > LONGEST_BEGIN)
        return unit_error(self, "request %u: %zu bytes are too many", kind, first_size);
    memcpy(begin, &request, sizeof request);
    if (first_size > 0)
        memcpy(begin + sizeof request, first, first_size);
    if (!send_all(channel, begin, sizeof request + first_size, second, second_size))
        return died(self);
    for (;;) {
        header reply;
        if (!receive_all(channel, &reply, sizeof reply, passed))
            return died(self);
        if (!reserve(self, (size_t)reply.size + 1))
            return unit_error(self, "no memory for a reply of %u bytes", reply.size);
        if (!receive_all(channel, self->buffer, reply.size, passed))
            return died(self);
        self->buffer[reply.size] = '\0';
        if (reply.kind == LOG) {
            log_line(self, reply.size);
            continue;
        }
        if (size != NULL)
            *size = reply.size;
        if (reply.kind == DONE)
            return UNIT_OK;
        self->log(self->owner, UNIT_ERROR, "logStatusError", (const char *)self->buffer);
        return UNIT_ERROR;
    }
}
