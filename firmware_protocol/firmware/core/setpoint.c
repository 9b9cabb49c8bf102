#include "setpoint.h"

#include <stddef.h>
#include <string.h>

#include "crc.h"

#define SHORT_MASK 0xFFFu /* what a group frame keeps of a sequence number */

uint8_t sb_groups(uint8_t joints)
{
    return (uint8_t)((joints + SB_GROUP - 1u) / SB_GROUP);
}

void sb_assembler_reset(struct sb_assembler *assembler)
{
    memset(assembler->unfinished, 0, sizeof assembler->unfinished);
}

/* The set-point with that number, or a new one in place of the oldest. */
static struct sb_unfinished *find(struct sb_assembler *assembler, uint16_t key)
{
    struct sb_unfinished *place = &assembler->unfinished[0];
    for (uint32_t i = 0u; i < SB_UNFINISHED; i++) {
        struct sb_unfinished *one = &assembler->unfinished[i];
        if (one->used && (one->key == key)) {
            return one;
        }
        const bool older = (int32_t)(one->birth - place->birth) < 0;
        if (place->used && (!one->used || older)) {
            place = one;
        }
    }
    if (place->used) {
        assembler->dropped++;
    }
    memset(place, 0, sizeof *place);
    place->used = true;
    place->key = key;
    place->birth = assembler->births;
    assembler->births++;
    return place;
}

static uint32_t count_bits(uint32_t bits)
{
    uint32_t count = 0u;
    for (uint32_t rest = bits; rest != 0u; rest &= rest - 1u) {
        count++;
    }
    return count;
}

/* CRC-32 over (sequence u16, joints u8, joints x i16), little-endian. */
static uint32_t setpoint_crc(uint16_t sequence, uint8_t joints, const int16_t *angle)
{
    uint8_t bytes[3u + 2u * SB_MAX_JOINTS];
    bytes[0] = (uint8_t)(sequence & 0xFFu);
    bytes[1] = (uint8_t)(sequence >> 8);
    bytes[2] = joints;
    for (uint32_t i = 0u; i < joints; i++) {
        const uint16_t raw = (uint16_t)angle[i];
        bytes[3u + 2u * i] = (uint8_t)(raw & 0xFFu);
        bytes[4u + 2u * i] = (uint8_t)(raw >> 8);
    }
    return sb_crc32(bytes, 3u + 2u * (uint32_t)joints);
}

/* Group frames carry 12 bits of the number: a remnant that stayed would meet the tick that comes 4096 later. */
static void forget_older(struct sb_assembler *assembler, uint16_t complete)
{
    for (uint32_t i = 0u; i < SB_UNFINISHED; i++) {
        struct sb_unfinished *one = &assembler->unfinished[i];
        if (one->used && ((((uint32_t)complete - one->key) & SHORT_MASK) <= SHORT_MASK / 2u)) {
            one->used = false;
            assembler->dropped++;
        }
    }
}

/* Release the set-point if it is complete and right. */
static bool release(struct sb_assembler *assembler, struct sb_unfinished *one, struct sb_tick *tick)
{
    const uint32_t wanted = sb_groups(assembler->joints);
    if (!one->latched || (count_bits(one->groups) < wanted)) {
        return false;
    }
    one->used = false;
    const uint32_t all = (1u << wanted) - 1u;
    if (((one->groups & all) != all) || (one->latch.joints != assembler->joints) ||
        (setpoint_crc(one->latch.sequence, assembler->joints, one->angle) != one->latch.crc32)) {
        assembler->dropped++;
        return false;
    }
    forget_older(assembler, one->key);
    tick->sequence = one->latch.sequence;
    tick->interval = one->latch.interval_s;
    memcpy(tick->angle, one->angle, sizeof tick->angle);
    return true;
}

bool sb_assembler_group(struct sb_assembler *assembler, const struct snakebot_setpoint_t *group, struct sb_tick *tick)
{
    struct sb_unfinished *one = find(assembler, group->sequence);
    one->groups = (uint16_t)(one->groups | (1u << group->group));
    if (group->group < SB_MAX_GROUPS) {
        int16_t *angle = &one->angle[(size_t)SB_GROUP * group->group];
        angle[0] = group->first_rad;
        angle[1] = group->second_rad;
        angle[2] = group->third_rad;
    }
    return release(assembler, one, tick);
}

bool sb_assembler_latch(struct sb_assembler *assembler, const struct snakebot_latch_t *latch, struct sb_tick *tick)
{
    struct sb_unfinished *one = find(assembler, (uint16_t)(latch->sequence & SHORT_MASK));
    one->latched = true;
    one->latch = *latch;
    return release(assembler, one, tick);
}
