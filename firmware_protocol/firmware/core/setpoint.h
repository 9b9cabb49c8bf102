/* Set-points put together from their frames: complete, with a CRC-32 that agrees, or not at all. */
#ifndef SB_SETPOINT_H
#define SB_SETPOINT_H

#include <stdbool.h>
#include <stdint.h>

#include "generated/snakebot.h"
#include "hal.h"

#define SB_GROUP 3u /* joints a frame */
#define SB_MAX_GROUPS ((SB_MAX_JOINTS + SB_GROUP - 1u) / SB_GROUP)
#define SB_UNFINISHED 4u /* set-points that are remembered before the oldest is given up */

/* One complete set-point of all joints. */
struct sb_tick {
    uint16_t sequence;
    uint8_t interval; /* since the set-point before, as the host planned it; steps of SB_INTERVAL_STEP_S */
    int16_t angle[SB_MAX_GROUPS * SB_GROUP]; /* steps of SB_ANGLE_STEP_RAD */
};

struct sb_unfinished {
    bool used;
    bool latched;
    uint16_t key; /* low 12 bits of the sequence number */
    uint16_t groups; /* one bit each */
    uint32_t birth;
    struct snakebot_latch_t latch;
    int16_t angle[SB_MAX_GROUPS * SB_GROUP];
};

struct sb_assembler {
    uint8_t joints;
    uint16_t dropped; /* given up incomplete, or with a CRC that did not agree */
    uint32_t births;
    struct sb_unfinished unfinished[SB_UNFINISHED];
};

/* Group frames for that many joints. */
uint8_t sb_groups(uint8_t joints);

/* Forget what is unfinished. */
void sb_assembler_reset(struct sb_assembler *assembler);

/* One frame more, in any order; true when the set-point is complete. */
bool sb_assembler_group(struct sb_assembler *assembler, const struct snakebot_setpoint_t *group, struct sb_tick *tick);
bool sb_assembler_latch(struct sb_assembler *assembler, const struct snakebot_latch_t *latch, struct sb_tick *tick);

#endif
