/* Angle, speed and acceleration of each joint kept within its limits, by the rule in PROTOCOL.md. */
#ifndef SB_LIMITER_H
#define SB_LIMITER_H

#include <stdbool.h>
#include <stdint.h>

#include "hal.h"

struct sb_limits {
    float angle_rad;
    float speed_rad_s;
    float acceleration_rad_s2;
};

/* Where a path is, and its mean speed over the last tick. */
struct sb_path {
    float angle_rad;
    float speed_rad_s;
};

struct sb_limiter {
    uint8_t joints;
    uint32_t credit_us;
    float dt_before_s; /* 0: none yet, the first tick counts as after one of its own length */
    struct sb_limits limits[SB_MAX_JOINTS]; /* in force */
    float applied_rad[SB_MAX_JOINTS];
    float target_rad[SB_MAX_JOINTS]; /* of the tick before */
    struct sb_path slow[SB_MAX_JOINTS]; /* of the paths that keep the limits near all that was applied */
    struct sb_path fast[SB_MAX_JOINTS];
};

/* Begin, at rest at the applied angles, with the credit of a sender that comes on time. */
void sb_limiter_reset(struct sb_limiter *limiter);

/*
 * Stop where it is; elapsed_us since the last set-point. There is no more credit than this time brings, and of the
 * paths near what was applied one stays: the slack is not granted anew.
 */
void sb_limiter_rest(struct sb_limiter *limiter, uint32_t elapsed_us);

/* A joint without power: its register follows where the joint is. */
void sb_limiter_follow(struct sb_limiter *limiter, uint8_t joint, float angle_rad);

/*
 * Move towards the targets as far as the limits let it.
 *
 * declared_us: interval times the sequence step; elapsed_us: since the set-point before on the board's own clock.
 * False: too early, nothing has changed but the credit's claim on time (the caller keeps counting `elapsed_us`).
 */
bool sb_limiter_execute(struct sb_limiter *limiter, const float *target_rad, uint32_t declared_us, uint32_t elapsed_us);

#endif
