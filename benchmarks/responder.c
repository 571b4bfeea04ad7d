/* The least that answers an ADS Read: 4 zero bytes for each frame, over one connection at a time. */
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { TCP_HEADER = 6, AMS_HEADER = 32, ANSWER = 12, ROOM = 1 << 16 };

static void serve(int client) {
    static uint8_t in[ROOM], out[ROOM];
    size_t held = 0;
    for (;;) {
        ssize_t got = recv(client, in + held, sizeof in - held, 0);
        if (got <= 0) return;
        held += (size_t)got;
        size_t at = 0, size = 0;
        while (held - at >= TCP_HEADER) {
            uint32_t length;
            memcpy(&length, in + at + 2, sizeof length);
            if (length > ROOM - TCP_HEADER || held - at < TCP_HEADER + length) break;
            const uint8_t *ams = in + at + TCP_HEADER;
            uint8_t *answer = out + size;
            memset(answer, 0, TCP_HEADER + AMS_HEADER + ANSWER);
            answer[2] = AMS_HEADER + ANSWER;
            memcpy(answer + 6, ams + 8, 8);       /* target: who asked */
            memcpy(answer + 14, ams, 8);
            answer[22] = 2;                       /* Read */
            answer[24] = 5;                       /* an answer, of ADS */
            answer[26] = ANSWER;
            memcpy(answer + 34, ams + 28, 4);     /* invoke id */
            answer[42] = 4;                       /* length of the data */
            size += TCP_HEADER + AMS_HEADER + ANSWER;
            at += TCP_HEADER + length;
            if (size > ROOM - 64) break;
        }
        for (size_t sent = 0; sent < size;) {
            ssize_t gone = send(client, out + sent, size - sent, MSG_NOSIGNAL);
            if (gone <= 0) return;
            sent += (size_t)gone;
        }
        held -= at;
        memmove(in, in + at, held);
    }
}

int main(int count, char **arguments) {
    struct sockaddr_in here = {.sin_family = AF_INET, .sin_port = htons(48898)};
    int yes = 1, listener = socket(AF_INET, SOCK_STREAM, 0);
    setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (count != 2 || inet_pton(AF_INET, arguments[1], &here.sin_addr) != 1) return 2;
    if (bind(listener, (struct sockaddr *)&here, sizeof here) || listen(listener, 8)) return 1;
    puts("peer ready");
    fflush(stdout);
    for (;;) {
        int client = accept(listener, NULL, NULL);
        setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
        serve(client);
        close(client);
    }
}
