/* Frames on a serial line: COBS with a zero delimiter around id, payload and CRC-16. */
#ifndef SB_FRAMING_H
#define SB_FRAMING_H

#include <stdbool.h>
#include <stdint.h>

#include "frame.h"

#define SB_MAX_PACKET (2u + SB_MAX_PAYLOAD + 2u) /* id, payload, CRC */
#define SB_MAX_ENCODED (SB_MAX_PACKET + 1u)      /* COBS adds one byte */

/* Cuts a byte stream into frames. All zero is a fresh one. */
struct sb_decoder {
    uint8_t pending[SB_MAX_ENCODED];
    uint8_t length;
    bool overlong; /* inside a run of bytes too long to be a packet: skip to its zero */
    uint16_t corrupt;
};

/* The frame as one packet with its delimiter; returns its length, at most SB_MAX_ENCODED + 1. */
uint8_t sb_pack(const struct sb_frame *frame, uint8_t packet[SB_MAX_ENCODED + 1u]);

/* One more byte of the stream; true when it completes a frame. */
bool sb_decoder_feed(struct sb_decoder *decoder, uint8_t byte, struct sb_frame *frame);

#endif
