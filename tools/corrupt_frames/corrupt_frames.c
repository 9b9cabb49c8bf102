/* Damaged packets into the board's own framing, catalogue and set-point assembly: how many get how far. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "framing.h"
#include "generated/catalogue.h"
#include "generated/snakebot.h"
#include "setpoint.h"

#define JOINTS 5u
#define FRAMES 3u
#define LINE (4u * FRAMES * (SB_MAX_ENCODED + 1u) + 64u)

enum kind { ONE_BIT, TWO_BITS, THREE_BITS, EIGHT_BITS, BURST, LOST_BYTES, NOISE, PAYLOAD, KINDS };
static const char *const names[KINDS] = {"1 bit",  "2 bits",     "3 bits",       "8 bits",
                                         "burst",  "lost bytes", "random bytes", "payload, unchecked"};

static uint64_t state;

static uint32_t draw(void) /* xorshift64* */
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (uint32_t)((state * 0x2545F4914F6CDD1DuLL) >> 32);
}

static uint32_t below(uint32_t n) { return (uint32_t)(((uint64_t)draw() * n) >> 32); }

struct count {
    uint64_t damaged;  /* packets */
    uint64_t framed;   /* came out of the framing as a frame that was not sent */
    uint64_t accepted; /* of those: a frame of the catalogue */
    uint64_t command;  /* of those: not a set-point, so obeyed without another check than the host's number */
    uint64_t executed; /* set-points with angles that were not sent */
    uint64_t right;    /* set-points as sent */
};

static void flip(uint8_t *bytes, uint32_t length, uint32_t bits)
{
    uint32_t done[8];
    for (uint32_t i = 0; i < bits; i++) {
        uint32_t bit;
        uint32_t again = 1;
        while (again) { /* different bits */
            bit = below(8u * length);
            again = 0;
            for (uint32_t j = 0; j < i; j++) {
                again |= done[j] == bit;
            }
            done[i] = bit;
        }
        bytes[done[i] / 8u] ^= (uint8_t)(1u << (done[i] % 8u));
    }
}

/* Damages the first `length` bytes of a packet; its new length. The delimiter is hit as any other byte. */
static uint32_t damage(uint8_t *packet, uint32_t length, enum kind kind)
{
    switch (kind) {
    case ONE_BIT: flip(packet, length, 1); break;
    case TWO_BITS: flip(packet, length, 2); break;
    case THREE_BITS: flip(packet, length, 3); break;
    case EIGHT_BITS: flip(packet, length, 8); break;
    case BURST: {
        const uint32_t first = below(length);
        const uint32_t many = 1u + below(4u);
        for (uint32_t i = first; i < length && i < first + many; i++) {
            packet[i] = (uint8_t)draw();
        }
        break;
    }
    case LOST_BYTES: {
        const uint32_t first = below(length);
        const uint32_t many = 1u + below(length - first);
        memmove(&packet[first], &packet[first + many], length - first - many);
        return length - many;
    }
    default: /* as many random bytes, none of them a delimiter: the hardest case for the CRC */
        for (uint32_t i = 0; i + 1u < length; i++) {
            packet[i] = (uint8_t)(1u + below(255u));
        }
        if (below(2)) { /* and one code that COBS can read, so that the CRC has to find it */
            packet[0] = (uint8_t)(length - 1u);
        }
        break;
    }
    return length;
}

static int16_t sent_angle[65536][JOINTS];

int main(int argc, char **argv)
{
    const uint64_t ticks = argc > 1 ? strtoull(argv[1], NULL, 10) : 100000u;
    state = 88172645463325252uLL ^ ((argc > 2 ? strtoull(argv[2], NULL, 10) : 1u) * 0x9E3779B97F4A7C15uLL);
    for (int kind = 0; kind < KINDS; kind++) {
        struct count count = {0};
        struct sb_decoder decoder = {0};
        struct sb_assembler assembler = {.joints = JOINTS};
        sb_assembler_reset(&assembler);
        for (uint64_t n = 0; n < ticks; n++) {
            const uint16_t sequence = (uint16_t)n;
            int16_t *angle = sent_angle[sequence];
            for (uint32_t i = 0; i < JOINTS; i++) {
                angle[i] = (int16_t)((int32_t)below(23000u) - 11500);
            }
            uint8_t crc[3u + 2u * JOINTS] = {(uint8_t)sequence, (uint8_t)(sequence >> 8), JOINTS};
            for (uint32_t i = 0; i < JOINTS; i++) {
                crc[3u + 2u * i] = (uint8_t)((uint16_t)angle[i] & 0xFFu);
                crc[4u + 2u * i] = (uint8_t)((uint16_t)angle[i] >> 8);
            }
            extern uint32_t sb_crc32(const uint8_t *, uint32_t);
            struct sb_frame frames[FRAMES] = {{.id = SNAKEBOT_SETPOINT_FRAME_ID, .length = 8},
                                              {.id = SNAKEBOT_SETPOINT_FRAME_ID, .length = 8},
                                              {.id = SNAKEBOT_LATCH_FRAME_ID, .length = 8}};
            const struct snakebot_setpoint_t head = {sequence & 0xFFFu, 0, angle[0], angle[1], angle[2]};
            const struct snakebot_setpoint_t tail = {sequence & 0xFFFu, 1, angle[3], angle[4], 0};
            const struct snakebot_latch_t latch = {sequence, JOINTS, 20, sb_crc32(crc, sizeof crc)};
            snakebot_setpoint_pack(frames[0].data, &head, 8);
            snakebot_setpoint_pack(frames[1].data, &tail, 8);
            frames[2].length = (uint8_t)snakebot_latch_pack(frames[2].data, &latch, 8);

            struct sb_frame out[2u * FRAMES + 2u];
            uint32_t outs = 0;
            const uint32_t hit = (uint32_t)(n % (FRAMES + 1u)); /* one packet of most ticks */
            uint8_t line[LINE] = {0};
            uint32_t length = 0;
            for (uint32_t i = 0; i < FRAMES; i++) {
                if (kind == PAYLOAD) { /* a carrier that has no check of its own */
                    out[outs] = frames[i];
                    if (i == hit) {
                        flip(out[outs].data, out[outs].length, 1u + below(8u));
                        count.damaged++;
                        count.framed++;
                    }
                    outs++;
                    continue;
                }
                const uint32_t packet = sb_pack(&frames[i], &line[length]);
                if (i == hit) {
                    count.damaged++;
                    length += damage(&line[length], packet, (enum kind)kind);
                } else {
                    length += packet;
                }
            }
            for (uint32_t i = 0; i < length; i++) {
                struct sb_frame frame;
                if (!sb_decoder_feed(&decoder, line[i], &frame)) {
                    continue;
                }
                uint32_t known = 0;
                for (uint32_t j = 0; j < FRAMES; j++) {
                    known |= frame.id == frames[j].id && frame.length == frames[j].length &&
                             memcmp(frame.data, frames[j].data, frame.length) == 0;
                }
                count.framed += !known;
                if (outs < sizeof out / sizeof out[0]) {
                    out[outs++] = frame;
                }
            }
            for (uint32_t i = 0; i < outs; i++) {
                uint32_t known = 0;
                for (uint32_t j = 0; j < FRAMES; j++) {
                    known |= out[i].id == frames[j].id && memcmp(out[i].data, frames[j].data, 8) == 0;
                }
                if (!sb_catalogue_accepts(out[i].id, out[i].data, out[i].length)) {
                    continue;
                }
                count.accepted += !known;
                struct sb_tick tick;
                bool complete = false;
                if (out[i].id == SNAKEBOT_SETPOINT_FRAME_ID) {
                    struct snakebot_setpoint_t group;
                    snakebot_setpoint_unpack(&group, out[i].data, out[i].length);
                    complete = sb_assembler_group(&assembler, &group, &tick);
                } else if (out[i].id == SNAKEBOT_LATCH_FRAME_ID) {
                    struct snakebot_latch_t heard;
                    snakebot_latch_unpack(&heard, out[i].data, out[i].length);
                    complete = sb_assembler_latch(&assembler, &heard, &tick);
                } else {
                    count.command += !known;
                }
                if (complete) {
                    const int same = memcmp(tick.angle, sent_angle[tick.sequence], sizeof sent_angle[0]) == 0;
                    count.executed += !same;
                    count.right += (uint64_t)same;
                }
            }
        }
        printf("%s,%llu,%llu,%llu,%llu,%llu,%llu\n", names[kind], (unsigned long long)count.damaged,
               (unsigned long long)count.framed, (unsigned long long)count.accepted,
               (unsigned long long)count.command, (unsigned long long)count.executed,
               (unsigned long long)count.right);
        fflush(stdout);
    }
    return 0;
}
