#include "limiter.h"

#include <math.h>

#include "generated/catalogue.h"

#define CREDIT_SLACK_US 20000u /* by how much a set-point may come early after a late one */
#define MIN_INTERVAL_US 500u
#define ROUNDING_RAD 1e-6f /* of a path's own arithmetic: its angle may lie on the edge of a step */

static float clamp(float value, float lower, float upper)
{
    return fminf(fmaxf(value, lower), upper);
}

void sb_limiter_reset(struct sb_limiter *limiter)
{
    limiter->credit_us = CREDIT_SLACK_US;
    limiter->dt_before_s = 0.0f;
    for (uint8_t i = 0u; i < SB_MAX_JOINTS; i++) {
        sb_limiter_follow(limiter, i, limiter->applied_rad[i]);
    }
}

void sb_limiter_follow(struct sb_limiter *limiter, uint8_t joint, float angle_rad)
{
    const struct sb_path at_rest = {angle_rad, 0.0f};
    limiter->applied_rad[joint] = angle_rad;
    limiter->target_rad[joint] = angle_rad;
    limiter->slow[joint] = at_rest;
    limiter->fast[joint] = at_rest;
}

static float off(struct sb_path path, float target_rad)
{
    return fabsf(path.angle_rad - target_rad);
}

static uint32_t credit(uint32_t before_us, uint32_t elapsed_us, uint32_t most_us)
{
    /* A day without a set-point must not overflow: more than the most is never used. */
    const uint32_t earned = (elapsed_us < most_us) ? elapsed_us : most_us;
    return (before_us + earned < most_us) ? (before_us + earned) : most_us;
}

void sb_limiter_rest(struct sb_limiter *limiter, uint32_t elapsed_us)
{
    limiter->credit_us = credit(limiter->credit_us, elapsed_us, CREDIT_SLACK_US);
    limiter->dt_before_s = 0.0f;
    for (uint8_t i = 0u; i < SB_MAX_JOINTS; i++) {
        const float applied = limiter->applied_rad[i];
        const struct sb_path slow = limiter->slow[i];
        const struct sb_path fast = limiter->fast[i];
        const struct sb_path at_rest = {((off(fast, applied) < off(slow, applied)) ? fast : slow).angle_rad, 0.0f};
        limiter->target_rad[i] = applied;
        limiter->slow[i] = at_rest;
        limiter->fast[i] = at_rest;
    }
}

/* One tick of one joint. */
struct step {
    const struct sb_limits *limits;
    float dt_s;
    float change_rad_s; /* of speed that it may make */
};

/* Limits are convex: what lies between two paths that keep them is a path that keeps them. */
static struct sb_path mixture(struct sb_path slow, struct sb_path fast, float wanted_share)
{
    const float share = clamp(wanted_share, 0.0f, 1.0f);
    const struct sb_path mixed = {
        slow.angle_rad + share * (fast.angle_rad - slow.angle_rad),
        slow.speed_rad_s + share * (fast.speed_rad_s - slow.speed_rad_s),
    };
    return mixed;
}

/* Largest speed of this tick from which braking ends within the room, whatever the ticks' lengths. */
static float stopping(float room_rad, const struct step *step)
{
    const float acceleration = step->limits->acceleration_rad_s2;
    const float half = acceleration * step->dt_s / 2.0f;
    return (room_rad <= half * step->dt_s) ? (room_rad / step->dt_s) : (sqrtf(2.0f * acceleration * room_rad) - half);
}

/* From `start` with the speed nearest to `want` that the limits allow. */
static struct sb_path go(struct sb_path start, float want, const struct step *step)
{
    const float angle = step->limits->angle_rad;
    const float fastest = step->limits->speed_rad_s;
    const float change = step->change_rad_s;
    const float room = fmaxf(0.0f, angle - ((want > 0.0f) ? start.angle_rad : -start.angle_rad));
    const float stop = stopping(room, step);
    const float braked = clamp(want, -stop, stop);
    const float bent = clamp(braked, start.speed_rad_s - change, start.speed_rad_s + change);
    const float speed = clamp(bent, -fastest, fastest);

    const struct sb_path end = {start.angle_rad + speed * step->dt_s, speed};
    const float bound = fmaxf(angle, fabsf(start.angle_rad));
    if (fabsf(end.angle_rad) <= bound) {
        return end;
    }
    /* Only where a limit was tightened, or arithmetic rounds. */
    const float stopped_rad = copysignf(bound, end.angle_rad);
    const struct sb_path stopped = {stopped_rad, (stopped_rad - start.angle_rad) / step->dt_s};
    return stopped;
}

/* Towards a target out of reach, so that both would come to rest at one place if both began to brake. */
static struct sb_path chase(struct sb_path start, float target_rad, float target_speed_rad_s, const struct step *step)
{
    const float fastest = step->limits->speed_rad_s;
    const float acceleration = step->limits->acceleration_rad_s2;
    const float u = clamp(target_speed_rad_s, -fastest, fastest);
    const float after = fmaxf(0.0f, fabsf(u) - acceleration * step->dt_s / 2.0f);
    const float way = after * after / (2.0f * acceleration);
    const float room = target_rad + copysignf(way, u) - start.angle_rad;
    return go(start, copysignf(stopping(fabsf(room), step), room), step);
}

/* The slowest and the fastest way on that end within a step of the target, or as near as they come; the nearer first. */
static void bracket(const struct sb_limiter *limiter, uint32_t joint, float target_rad, const struct step *step,
                    struct sb_path *near, struct sb_path *other)
{
    const struct sb_path slow = limiter->slow[joint];
    const struct sb_path fast = limiter->fast[joint];
    const float low = target_rad - SB_ANGLE_STEP_RAD;
    const float high = target_rad + SB_ANGLE_STEP_RAD;
    const float spread = fast.speed_rad_s - slow.speed_rad_s + (fast.angle_rad - slow.angle_rad) / step->dt_s;
    struct sb_path from_slow = slow;
    struct sb_path from_fast = fast;
    if (spread > 0.0f) { /* of all mixtures the one that comes to its edge by all the change that it may make */
        const float to_low = (low - slow.angle_rad) / step->dt_s - slow.speed_rad_s;
        const float to_high = (high - slow.angle_rad) / step->dt_s - slow.speed_rad_s;
        from_slow = mixture(slow, fast, (to_low + step->change_rad_s) / spread);
        from_fast = mixture(slow, fast, (to_high - step->change_rad_s) / spread);
    }
    const struct sb_path slowest = go(from_slow, (low - from_slow.angle_rad) / step->dt_s, step);
    const struct sb_path fastest = go(from_fast, (high - from_fast.angle_rad) / step->dt_s, step);
    const bool fastest_first = off(fastest, target_rad) < off(slowest, target_rad);
    *near = fastest_first ? fastest : slowest;
    *other = fastest_first ? slowest : fastest;
}

static void move(struct sb_limiter *limiter, uint32_t joint, float wanted_rad, float dt_s)
{
    const struct sb_limits *limits = &limiter->limits[joint];
    const float target = clamp(wanted_rad, -limits->angle_rad, limits->angle_rad);
    const float target_before = limiter->target_rad[joint];
    /* A speed is the mean over its tick: between the middles of two ticks lies half of each. */
    const float dt_before_s = (limiter->dt_before_s > 0.0f) ? limiter->dt_before_s : dt_s;
    const float change = limits->acceleration_rad_s2 * (dt_before_s + dt_s) / 2.0f;
    const struct step step = {limits, dt_s, change};
    const float within = SB_ANGLE_STEP_RAD + ROUNDING_RAD;

    bool behind = fabsf(limiter->applied_rad[joint] - target_before) > 2.0f * ROUNDING_RAD;
    struct sb_path near = limiter->slow[joint];
    struct sb_path other = limiter->fast[joint];
    if (!behind) {
        bracket(limiter, joint, target, &step, &near, &other);
        behind = off(near, target) > within;
        other = (off(other, target) > within) ? near : other;
    }
    if (behind) {
        const struct sb_path fast = limiter->fast[joint];
        const struct sb_path start = (target > fast.angle_rad) ? fast : limiter->slow[joint];
        near = chase(start, target, (target - target_before) / dt_s, &step);
        other = near;
    }
    const bool near_is_slow = near.speed_rad_s <= other.speed_rad_s;
    limiter->slow[joint] = near_is_slow ? near : other;
    limiter->fast[joint] = near_is_slow ? other : near;
    limiter->target_rad[joint] = target;
    limiter->applied_rad[joint] = clamp(target, near.angle_rad - SB_ANGLE_STEP_RAD, near.angle_rad + SB_ANGLE_STEP_RAD);
}

bool sb_limiter_execute(struct sb_limiter *limiter, const float *target_rad, uint32_t declared_us, uint32_t elapsed_us)
{
    const uint32_t available_us = credit(limiter->credit_us, elapsed_us, declared_us + CREDIT_SLACK_US);
    const uint32_t dt_us = (declared_us < available_us) ? declared_us : available_us;
    if (dt_us < MIN_INTERVAL_US) {
        return false;
    }
    limiter->credit_us = available_us - dt_us;
    const float dt_s = (float)dt_us * 1e-6f;
    for (uint32_t i = 0u; i < limiter->joints; i++) {
        move(limiter, i, target_rad[i], dt_s);
    }
    limiter->dt_before_s = dt_s;
    return true;
}
