/* The ASCII protocol of serial CAN adapters (Lawicel): what this program says looks like a CAN bus to the other end. */
#ifndef SLCAN_H
#define SLCAN_H

#include <stdbool.h>
#include <stdint.h>

#include "core/frame.h"

#define SLCAN_LINE 32u

struct slcan {
    char line[SLCAN_LINE];
    uint32_t length;
    bool overlong;
    bool open; /* the host has opened the channel */
};

enum slcan_event { SLCAN_NOTHING, SLCAN_FRAME, SLCAN_OK, SLCAN_ERROR };

/* One more character; says whether it completes a frame, or a command that is to be answered. */
enum slcan_event slcan_feed(struct slcan *slcan, char character, struct sb_frame *frame);

/* The frame as a line; returns its length, at most SLCAN_LINE. */
uint32_t slcan_print(const struct sb_frame *frame, char line[SLCAN_LINE]);

#endif
