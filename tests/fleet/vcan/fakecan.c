/* Lets programs that use SocketCAN run where the kernel has none, over hub.c instead:
 *
 *   FAKECAN=SOCKET-FILE LD_PRELOAD=fakecan.so PROGRAM ...
 *
 * A raw CAN socket becomes a connection to the hub, and interfaces called vcan* exist. There is no
 * broadcast manager, there are no error frames and no netlink. Programs that do not call the C
 * library (Go) are out of its reach.
 */
#define _GNU_SOURCE
#include "protocol.h"

#include <dlfcn.h>
#include <errno.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

enum { MOST_DESCRIPTORS = 4096, INTERFACE_INDEX = 3, UNFILTERED = -1 };

struct fake {
    bool is_can;
    bool connected;
    /* SO_TIMESTAMP, SO_TIMESTAMPNS, or 0: none wanted. */
    int stamps;
    int filter_count;
    struct can_filter filters[MOST_FILTERS];
};

static struct fake fakes[MOST_DESCRIPTORS];

/* What the C library has under the name of the function that asks. */
#define REAL(type, name, ...)                                                                      \
    static type (*real)(__VA_ARGS__);                                                              \
    if (!real)                                                                                     \
        real = dlsym(RTLD_NEXT, name)

static struct fake *fake_of(int fd) {
    bool known = fd >= 0 && fd < MOST_DESCRIPTORS && fakes[fd].is_can;
    return known ? &fakes[fd] : NULL;
}

static bool is_ours(const char *interface) {
    return !strncmp(interface, "vcan", 4);
}

static void tell_filters(int fd, const struct fake *fake) {
    if (fake->filter_count == UNFILTERED)
        return;
    struct filter_message message = {.kind = SETS_FILTERS, .count = fake->filter_count};
    memcpy(message.filters, fake->filters, sizeof message.filters);
    send(fd, &message, sizeof message, 0);
}

static int real_setsockopt(int fd, int level, int name, const void *value, socklen_t length) {
    REAL(int, "setsockopt", int, int, int, const void *, socklen_t);
    return real(fd, level, name, value, length);
}

int socket(int domain, int type, int protocol) {
    static const int queue = QUEUE_BYTES;
    REAL(int, "socket", int, int, int);
    if (domain != AF_CAN)
        return real(domain, type, protocol);
    int flags = type & (SOCK_NONBLOCK | SOCK_CLOEXEC);
    if ((type & ~flags) != SOCK_RAW || protocol != CAN_RAW) {
        errno = EPROTONOSUPPORT;
        return -1;
    }
    int fd = real(AF_UNIX, SOCK_SEQPACKET | flags, 0);
    if (fd >= 0 && fd < MOST_DESCRIPTORS) {
        fakes[fd] = (struct fake){.is_can = true, .filter_count = UNFILTERED};
        real_setsockopt(fd, SOL_SOCKET, SO_SNDBUFFORCE, &queue, sizeof queue);
    }
    return fd;
}

int close(int fd) {
    REAL(int, "close", int);
    struct fake *fake = fake_of(fd);
    if (fake)
        fake->is_can = false;
    return real(fd);
}

int bind(int fd, const struct sockaddr *address, socklen_t length) {
    REAL(int, "bind", int, const struct sockaddr *, socklen_t);
    struct fake *fake = fake_of(fd);
    if (!fake)
        return real(fd, address, length);
    struct sockaddr_un hub = {.sun_family = AF_UNIX};
    const char *path = getenv("FAKECAN");
    if (!path || strlen(path) >= sizeof hub.sun_path) {
        errno = ENODEV;
        return -1;
    }
    strcpy(hub.sun_path, path);
    int status = connect(fd, (struct sockaddr *)&hub, sizeof hub);
    if (!status) {
        fake->connected = true;
        tell_filters(fd, fake);
    }
    return status;
}

int ioctl(int fd, unsigned long request, ...) {
    REAL(int, "ioctl", int, unsigned long, ...);
    va_list arguments;
    va_start(arguments, request);
    void *argument = va_arg(arguments, void *);
    va_end(arguments);
    struct ifreq *interface = argument;
    switch (request) {
    case SIOCGIFINDEX:
    case SIOCGIFMTU:
    case SIOCGIFFLAGS:
        if (interface && is_ours(interface->ifr_name))
            break;
        /* fall through */
    default:
        return real(fd, request, argument);
    }
    if (request == SIOCGIFINDEX)
        interface->ifr_ifindex = INTERFACE_INDEX;
    else if (request == SIOCGIFMTU)
        interface->ifr_mtu = CAN_MTU;
    else
        interface->ifr_flags = IFF_UP | IFF_RUNNING;
    return 0;
}

unsigned if_nametoindex(const char *name) {
    REAL(unsigned, "if_nametoindex", const char *);
    return is_ours(name) ? INTERFACE_INDEX : real(name);
}

static void keep_filters(int fd, struct fake *fake, const void *value, socklen_t length) {
    int count = length / sizeof(struct can_filter);
    fake->filter_count = count < MOST_FILTERS ? count : MOST_FILTERS;
    memcpy(fake->filters, value, fake->filter_count * sizeof(struct can_filter));
    if (fake->connected)
        tell_filters(fd, fake);
}

int setsockopt(int fd, int level, int name, const void *value, socklen_t length) {
    struct fake *fake = fake_of(fd);
    if (!fake)
        return real_setsockopt(fd, level, name, value, length);
    if (level == SOL_CAN_RAW) {
        if (name == CAN_RAW_FILTER)
            keep_filters(fd, fake, value, length);
        return 0;
    }
    if (level == SOL_SOCKET) {
        switch (name) {
        case SO_TIMESTAMP:
        case SO_TIMESTAMPNS:
            fake->stamps = name;
            return 0;
        case SO_TIMESTAMPING:
        case SO_RXQ_OVFL:
            return 0;
        }
    }
    return real_setsockopt(fd, level, name, value, length);
}

int getsockopt(int fd, int level, int name, void *value, socklen_t *length) {
    REAL(int, "getsockopt", int, int, int, void *, socklen_t *);
    if (!fake_of(fd) || level != SOL_CAN_RAW)
        return real(fd, level, name, value, length);
    memset(value, 0, *length);
    return 0;
}

static void stamp(struct msghdr *message, int kind) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    struct timeval coarse = {now.tv_sec, now.tv_nsec / 1000};
    bool fine = kind == SO_TIMESTAMPNS;
    message->msg_controllen = CMSG_SPACE(sizeof now);
    struct cmsghdr *header = CMSG_FIRSTHDR(message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = fine ? SCM_TIMESTAMPNS : SCM_TIMESTAMP;
    header->cmsg_len = CMSG_LEN(sizeof now);
    memcpy(CMSG_DATA(header), fine ? (void *)&now : (void *)&coarse, sizeof now);
}

ssize_t recvmsg(int fd, struct msghdr *message, int flags) {
    REAL(ssize_t, "recvmsg", int, struct msghdr *, int);
    const struct fake *fake = fake_of(fd);
    if (!fake)
        return real(fd, message, flags);
    socklen_t name_room = message->msg_namelen;
    size_t control_room = message->msg_controllen;
    ssize_t length = real(fd, message, flags);
    if (length < 0)
        return length;
    message->msg_controllen = 0;
    if (fake->stamps && message->msg_control &&
        control_room >= CMSG_SPACE(sizeof(struct timespec)))
        stamp(message, fake->stamps);
    if (message->msg_name && name_room >= sizeof(struct sockaddr_can)) {
        struct sockaddr_can from = {.can_family = AF_CAN, .can_ifindex = INTERFACE_INDEX};
        memcpy(message->msg_name, &from, sizeof from);
        message->msg_namelen = sizeof from;
    }
    return length;
}

ssize_t recvfrom(int fd, void *buffer, size_t room, int flags, struct sockaddr *from,
                 socklen_t *from_length) {
    REAL(ssize_t, "recvfrom", int, void *, size_t, int, struct sockaddr *, socklen_t *);
    if (!fake_of(fd))
        return real(fd, buffer, room, flags, from, from_length);
    ssize_t length = recv(fd, buffer, room, flags);
    if (length >= 0 && from && from_length && *from_length >= sizeof(struct sockaddr_can)) {
        struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = INTERFACE_INDEX};
        memcpy(from, &address, sizeof address);
        *from_length = sizeof address;
    }
    return length;
}

ssize_t sendto(int fd, const void *buffer, size_t length, int flags, const struct sockaddr *to,
               socklen_t to_length) {
    REAL(ssize_t, "sendto", int, const void *, size_t, int, const struct sockaddr *, socklen_t);
    if (fake_of(fd))
        return real(fd, buffer, length, flags, NULL, 0);
    return real(fd, buffer, length, flags, to, to_length);
}

int getsockname(int fd, struct sockaddr *address, socklen_t *length) {
    REAL(int, "getsockname", int, struct sockaddr *, socklen_t *);
    if (!fake_of(fd))
        return real(fd, address, length);
    struct sockaddr_can own = {.can_family = AF_CAN, .can_ifindex = INTERFACE_INDEX};
    memcpy(address, &own, *length < sizeof own ? *length : sizeof own);
    *length = sizeof own;
    return 0;
}
