#include "framing.h"

#include <string.h>

#include "crc.h"

#define MIN_PACKET 4u

uint8_t sb_pack(const struct sb_frame *frame, uint8_t packet[SB_MAX_ENCODED + 1u])
{
    uint8_t body[SB_MAX_PACKET];
    const uint32_t payload = (frame->length <= SB_MAX_PAYLOAD) ? frame->length : SB_MAX_PAYLOAD;

    body[0] = (uint8_t)(frame->id & 0xFFu);
    body[1] = (uint8_t)(frame->id >> 8);
    memcpy(&body[2], frame->data, payload);
    const uint16_t crc = sb_crc16(body, 2u + payload);
    body[2u + payload] = (uint8_t)(crc & 0xFFu);
    body[3u + payload] = (uint8_t)(crc >> 8);

    uint32_t code = 0u; /* where the length of the run at hand belongs */
    uint32_t end = 1u;
    for (uint32_t i = 0u; i < payload + 4u; i++) {
        if (body[i] == 0u) {
            packet[code] = (uint8_t)(end - code);
            code = end;
        } else {
            packet[end] = body[i];
        }
        end++;
    }
    packet[code] = (uint8_t)(end - code);
    packet[end] = 0u;
    return (uint8_t)(end + 1u);
}

/* COBS decoding; 0 if the runs do not end where the packet does (a frame is never empty). */
static uint32_t uncobs(const uint8_t *packet, uint32_t length, uint8_t body[SB_MAX_PACKET])
{
    uint32_t out = 0u;
    uint32_t in = 0u;
    while (in < length) {
        const uint32_t run = (uint32_t)packet[in] - 1u; /* there is no zero in a packet */
        in++;
        if (run > length - in) {
            return 0u;
        }
        memcpy(&body[out], &packet[in], run);
        out += run;
        in += run;
        if (in < length) {
            body[out] = 0u;
            out++;
        }
    }
    return out;
}

static bool unpack(const uint8_t *packet, uint32_t encoded, struct sb_frame *frame)
{
    uint8_t body[SB_MAX_PACKET];
    const uint32_t length = uncobs(packet, encoded, body);
    if (length < MIN_PACKET) {
        return false;
    }
    const uint32_t crc = (uint32_t)body[length - 2u] | ((uint32_t)body[length - 1u] << 8);
    if (sb_crc16(body, length - 2u) != crc) {
        return false;
    }
    const uint32_t id = (uint32_t)body[0] | ((uint32_t)body[1] << 8);
    if (id > SB_MAX_ID) {
        return false;
    }
    frame->id = (uint16_t)id;
    frame->length = (uint8_t)(length - MIN_PACKET);
    memset(frame->data, 0, sizeof frame->data);
    memcpy(frame->data, &body[2], length - MIN_PACKET);
    return true;
}

bool sb_decoder_feed(struct sb_decoder *decoder, uint8_t byte, struct sb_frame *frame)
{
    if (byte != 0u) {
        if (decoder->length < SB_MAX_ENCODED) {
            decoder->pending[decoder->length] = byte;
            decoder->length++;
        } else {
            decoder->overlong = true;
        }
        return false;
    }
    bool complete = false;
    if (decoder->length > 0u) {
        complete = !decoder->overlong && unpack(decoder->pending, decoder->length, frame);
        if (!complete) {
            decoder->corrupt++;
        }
    }
    decoder->length = 0u;
    decoder->overlong = false;
    return complete;
}
