/* One frame, as CAN carries it and as a serial line wraps it. */
#ifndef SB_FRAME_H
#define SB_FRAME_H

#include <stdint.h>

#define SB_MAX_PAYLOAD 8u
#define SB_MAX_ID 0x7FFu

struct sb_frame {
    uint16_t id; /* 11 bits */
    uint8_t length;
    uint8_t data[SB_MAX_PAYLOAD];
};

#endif
