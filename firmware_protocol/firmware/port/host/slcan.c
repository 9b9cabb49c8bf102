#include "slcan.h"

#include <string.h>

static int32_t hex(char character)
{
    if ((character >= '0') && (character <= '9')) {
        return character - '0';
    }
    if ((character >= 'A') && (character <= 'F')) {
        return character - 'A' + 10;
    }
    if ((character >= 'a') && (character <= 'f')) {
        return character - 'a' + 10;
    }
    return -1;
}

/* tiiildd..: identifier, length, data. */
static bool parse_frame(const char *line, uint32_t length, struct sb_frame *frame)
{
    if (length < 5u) {
        return false;
    }
    uint32_t id = 0u;
    for (uint32_t i = 1u; i < 4u; i++) {
        const int32_t digit = hex(line[i]);
        if (digit < 0) {
            return false;
        }
        id = (id << 4) | (uint32_t)digit;
    }
    const int32_t bytes = hex(line[4]);
    if ((id > SB_MAX_ID) || (bytes < 0) || (bytes > (int32_t)SB_MAX_PAYLOAD) ||
        (length != 5u + 2u * (uint32_t)bytes)) {
        return false;
    }
    memset(frame, 0, sizeof *frame);
    frame->id = (uint16_t)id;
    frame->length = (uint8_t)bytes;
    for (uint32_t i = 0u; i < (uint32_t)bytes; i++) {
        const int32_t high = hex(line[5u + 2u * i]);
        const int32_t low = hex(line[6u + 2u * i]);
        if ((high < 0) || (low < 0)) {
            return false;
        }
        frame->data[i] = (uint8_t)((high << 4) | low);
    }
    return true;
}

static enum slcan_event obey(struct slcan *slcan, struct sb_frame *frame)
{
    switch (slcan->line[0]) {
    case 't':
        return (slcan->open && parse_frame(slcan->line, slcan->length, frame)) ? SLCAN_FRAME : SLCAN_ERROR;
    case 'O':
        slcan->open = true;
        return SLCAN_OK;
    case 'C':
        slcan->open = false;
        return SLCAN_OK;
    case 'S': /* bit rates mean nothing here */
    case 's':
    case 'Y':
        return SLCAN_OK;
    default:
        return SLCAN_ERROR;
    }
}

enum slcan_event slcan_feed(struct slcan *slcan, char character, struct sb_frame *frame)
{
    enum slcan_event event = SLCAN_NOTHING;
    if ((character != '\r') && (character != '\n')) {
        if (slcan->length < SLCAN_LINE) {
            slcan->line[slcan->length] = character;
            slcan->length++;
        } else {
            slcan->overlong = true;
        }
        return event;
    }
    if (slcan->overlong) {
        event = SLCAN_ERROR;
    } else if (slcan->length > 0u) {
        event = obey(slcan, frame);
    } else {
        event = (character == '\r') ? SLCAN_OK : SLCAN_NOTHING;
    }
    slcan->length = 0u;
    slcan->overlong = false;
    return event;
}

uint32_t slcan_print(const struct sb_frame *frame, char line[SLCAN_LINE])
{
    static const char digits[] = "0123456789ABCDEF";
    uint32_t end = 0u;
    line[end++] = 't';
    line[end++] = digits[(frame->id >> 8) & 0xFu];
    line[end++] = digits[(frame->id >> 4) & 0xFu];
    line[end++] = digits[frame->id & 0xFu];
    line[end++] = digits[frame->length & 0xFu];
    for (uint32_t i = 0u; (i < frame->length) && (i < SB_MAX_PAYLOAD); i++) {
        line[end++] = digits[frame->data[i] >> 4];
        line[end++] = digits[frame->data[i] & 0xFu];
    }
    line[end++] = '\r';
    return end;
}
