/* What hub.c and fakecan.c tell each other besides frames. */
#ifndef PROTOCOL_H
#define PROTOCOL_H

#include <linux/can.h>
#include <stdint.h>

enum { MOST_FILTERS = 16, QUEUE_BYTES = 16 << 20 };

/* The first word of a message that sets the filters; no frame has it for its identifier. */
#define SETS_FILTERS UINT32_MAX

struct filter_message {
    uint32_t kind;
    uint32_t count;
    struct can_filter filters[MOST_FILTERS];
};

#endif
