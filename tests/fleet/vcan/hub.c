/* One CAN bus without a kernel that has one: hub SOCKET-FILE
 *
 * Every frame that one program sends goes to all others whose filters let it through. Programs
 * connect by way of fakecan.c. One socket file is one bus.
 */
#define _GNU_SOURCE
#include "protocol.h"

#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

enum { MOST_PROGRAMS = 63, UNFILTERED = -1 };

struct program {
    int filter_count;
    struct can_filter filters[MOST_FILTERS];
};

/* sockets[0] is the one that programs connect to; programs[i] belongs to sockets[i]. */
static struct pollfd sockets[1 + MOST_PROGRAMS];
static struct program programs[1 + MOST_PROGRAMS];
static int used = 1;

static bool takes(const struct program *program, canid_t id) {
    if (program->filter_count == UNFILTERED)
        return true;
    for (int i = 0; i < program->filter_count; i++) {
        canid_t wanted = program->filters[i].can_id & ~CAN_INV_FILTER;
        canid_t mask = program->filters[i].can_mask;
        bool inverted = program->filters[i].can_id & CAN_INV_FILTER;
        if (((id & mask) == (wanted & mask)) != inverted)
            return true;
    }
    return false;
}

static void let_in(void) {
    static const int queue = QUEUE_BYTES;
    int fd = accept(sockets[0].fd, NULL, NULL);
    if (fd < 0)
        return;
    if (used > MOST_PROGRAMS) {
        close(fd);
        return;
    }
    setsockopt(fd, SOL_SOCKET, SO_SNDBUFFORCE, &queue, sizeof queue);
    sockets[used] = (struct pollfd){.fd = fd, .events = POLLIN};
    programs[used].filter_count = UNFILTERED;
    used++;
}

/* Pass on what a program has sent; return whether it is still there. */
static bool serve(int sender) {
    union {
        struct can_frame frame;
        struct filter_message filter;
    } message;
    ssize_t length = recv(sockets[sender].fd, &message, sizeof message, 0);
    if (length <= 0)
        return false;
    if (length != sizeof message.frame && message.filter.kind == SETS_FILTERS) {
        programs[sender].filter_count = message.filter.count;
        memcpy(programs[sender].filters, message.filter.filters, sizeof message.filter.filters);
        return true;
    }
    for (int i = 1; i < used; i++)
        if (i != sender && takes(&programs[i], message.frame.can_id))
            send(sockets[i].fd, &message, length, MSG_NOSIGNAL);
    return true;
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fputs("usage: hub SOCKET-FILE\n", stderr);
        return 2;
    }
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(argv[1]) >= sizeof address.sun_path) {
        fputs("hub: the name of the socket file is too long\n", stderr);
        return 2;
    }
    strcpy(address.sun_path, argv[1]);
    unlink(argv[1]);
    int fd = socket(AF_UNIX, SOCK_SEQPACKET, 0);
    if (bind(fd, (struct sockaddr *)&address, sizeof address) || listen(fd, 16)) {
        perror("hub");
        return 1;
    }
    sockets[0] = (struct pollfd){.fd = fd, .events = POLLIN};
    puts("hub ready");
    fflush(stdout);
    for (;;) {
        if (poll(sockets, used, -1) < 0)
            continue;
        if (sockets[0].revents & POLLIN)
            let_in();
        for (int i = 1; i < used; i++) {
            if (!sockets[i].revents || serve(i))
                continue;
            close(sockets[i].fd);
            used--;
            sockets[i] = sockets[used];
            programs[i] = programs[used];
            i--;
        }
    }
}
