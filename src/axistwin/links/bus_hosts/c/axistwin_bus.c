/* See axistwin_bus.h.  The protocol: docs/bus.md. */
#define _POSIX_C_SOURCE 200112L

#include "axistwin_bus.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define BLOCK 256           /* bytes of a block transfer */
#define LINE (3 * BLOCK + 16)

static int bus = -1;
static char received[LINE]; /* received characters, not yet processed */
static size_t pending = 0;
static int line_level = 0;  /* last reported level of the interrupt line */
static int subscribed = 0;

static void give_up(const char *what, const char *detail)
{
    fprintf(stderr, "axistwin_bus: %s: %s\n", what, detail);
    exit(3);
}

static int try_addresses(struct addrinfo *found)
{
    int made, on = 1;

    for (; found != NULL; found = found->ai_next) {
        made = socket(found->ai_family, found->ai_socktype, found->ai_protocol);
        if (made >= 0 && connect(made, found->ai_addr, found->ai_addrlen) == 0) {
            setsockopt(made, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
            return made;
        }
        if (made >= 0)
            close(made);
    }
    return -1;
}

static void dial(void)
{
    const char *where = getenv("AXISTWIN_BUS");
    char host[256];
    const char *colon;
    struct addrinfo hints, *found;

    if (where == NULL || (colon = strrchr(where, ':')) == NULL || (size_t)(colon - where) >= sizeof host)
        give_up("AXISTWIN_BUS", "set it to HOST:PORT of axistwin serve 1811 --bus HOST:PORT");
    memcpy(host, where, (size_t)(colon - where));
    host[colon - where] = '\0';
    memset(&hints, 0, sizeof hints);
    hints.ai_socktype = SOCK_STREAM;
    if (getaddrinfo(host[0] ? host : "127.0.0.1", colon + 1, &hints, &found) != 0)
        give_up(where, "no such address");
    bus = try_addresses(found);
    freeaddrinfo(found);
    if (bus < 0)
        give_up(where, "no answer: start axistwin serve at this address");
}

static void say(const char *text, size_t length)
{
    ssize_t written;

    if (bus < 0)
        dial();
    for (; length > 0; text += written, length -= (size_t)written) {
        written = sendto(bus, text, length, MSG_NOSIGNAL, NULL, 0); /* not send: a host may have its own */
        if (written <= 0)
            give_up("AXISTWIN_BUS", "the connection is lost");
    }
}

/* Read the next line, without its end.  Returns 0 after a timeout in milliseconds; negative: wait for ever. */
static int hear(char *line, int milliseconds)
{
    struct pollfd ready;
    char *end;
    ssize_t more;
    size_t length;

    while ((end = memchr(received, '\n', pending)) == NULL) {
        ready.fd = bus;
        ready.events = POLLIN;
        if (poll(&ready, 1, milliseconds) == 0)
            return 0;
        more = pending < sizeof received ? recvfrom(bus, received + pending, sizeof received - pending, 0, NULL, NULL) : 0;
        if (more <= 0)
            give_up("AXISTWIN_BUS", "the connection is lost, or another host has the bus");
        pending += (size_t)more;
    }
    length = (size_t)(end - received);
    memcpy(line, received, length);
    line[length] = '\0';
    pending -= length + 1;
    memmove(received, end + 1, pending);
    return 1;
}

/* Send a request and read its answer; store reports of the interrupt line that come before the answer. */
static void ask(const char *request, char *answer)
{
    say(request, strlen(request));
    for (;;) {
        hear(answer, -1);
        if (answer[0] != '!')
            break;
        line_level = answer[2] == '1';
    }
    if (strncmp(answer, "error", 5) == 0)
        give_up(request, answer);
}

int in(unsigned long address)
{
    char answer[LINE];

    ask((address & 1) ? "r 1\n" : "r 0\n", answer);
    return (int)strtol(answer, NULL, 16);
}

void out(unsigned long address, int byte)
{
    char request[16], answer[LINE];

    sprintf(request, "w %d %02x\n", (int)(address & 1), (unsigned)byte & 0xFFu);
    ask(request, answer);
}

void in_block(unsigned long address, unsigned char *bytes, int count)
{
    char request[16], answer[LINE], *at;
    int part, i;

    for (; count > 0; count -= part) {
        part = count < BLOCK ? count : BLOCK;
        sprintf(request, "r %d %d\n", (int)(address & 1), part);
        ask(request, answer);
        for (i = 0, at = answer; i < part; i++)
            *bytes++ = (unsigned char)strtol(at, &at, 16);
    }
}

void out_block(unsigned long address, const unsigned char *bytes, int count)
{
    char request[LINE], answer[LINE], *at;
    int part, i;

    for (; count > 0; count -= part) {
        part = count < BLOCK ? count : BLOCK;
        at = request + sprintf(request, "w %d", (int)(address & 1));
        for (i = 0; i < part; i++)
            at += sprintf(at, " %02x", *bytes++);
        strcpy(at, "\n");
        ask(request, answer);
    }
}

int interrupt_line(void)
{
    char answer[LINE];

    ask("i\n", answer);
    return answer[0] == '1';
}

static long now_ms(void)
{
    struct timespec now;

    clock_gettime(CLOCK_MONOTONIC, &now);
    return (long)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

int wait_interrupt(int milliseconds)
{
    char answer[LINE];
    long end = now_ms() + milliseconds;
    long left = milliseconds;

    if (!subscribed) {
        ask("s 1\n", answer);
        subscribed = 1;
    }
    line_level = interrupt_line();
    while (!line_level && hear(answer, (int)left)) {
        line_level = answer[2] == '1';
        left = milliseconds < 0 ? -1 : end > now_ms() ? end - now_ms() : 0;
    }
    return line_level;
}
