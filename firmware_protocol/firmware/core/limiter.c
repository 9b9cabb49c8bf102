#include "limiter.h"

#include <math.h>

#include "generated/catalogue.h"

#define CREDIT_SLACK_US 20000u /* by how much a set-point may come early after a late one */
#define MIN_INTERVAL_US 500u

static float clamp(float value, float lower, float upper)
{
    return fminf(fmaxf(value, lower), upper);
}

void sb_limiter_reset(struct sb_limiter *limiter)
{
    limiter->credit_us = CREDIT_SLACK_US;
    for (uint32_t i = 0u; i < SB_MAX_JOINTS; i++) {
        limiter->speed_rad_s[i] = 0.0f;
    }
}

void sb_limiter_follow(struct sb_limiter *limiter, uint8_t joint, float angle_rad)
{
    limiter->applied_rad[joint] = angle_rad;
    limiter->speed_rad_s[joint] = 0.0f;
}

static void move(struct sb_limiter *limiter, uint32_t joint, float target_rad, float dt_s)
{
    const struct sb_limits *limits = &limiter->limits[joint];
    const float angle = limits->angle_rad;
    const float applied = limiter->applied_rad[joint];
    const float before = limiter->speed_rad_s[joint];
    const float slack = SB_ANGLE_STEP_RAD / dt_s; /* rounding alone must not look like a broken limit */
    const float fastest = limits->speed_rad_s + slack;

    float want = (clamp(target_rad, -angle, angle) - applied) / dt_s;
    want = clamp(want, -fastest, fastest);

    /* Braking by acceleration * dt a tick, from v, takes v^2 / (2 acceleration) + v dt / 2 of the way to the end. */
    const float room = fmaxf(0.0f, angle - ((want > 0.0f) ? applied : -applied));
    const float brake = limits->acceleration_rad_s2 * dt_s;
    const float braking = sqrtf(2.0f * limits->acceleration_rad_s2 * room) - brake / 2.0f;
    const float stop = fmaxf(fminf(room / dt_s, brake), braking) + slack;
    want = clamp(want, -stop, stop);

    const float band = brake + 2.0f * slack;
    const float speed = clamp(clamp(want, before - band, before + band), -fastest, fastest);
    const float bound = fmaxf(angle, fabsf(applied));
    limiter->applied_rad[joint] = clamp(applied + speed * dt_s, -bound, bound);
    limiter->speed_rad_s[joint] = speed;
}

bool sb_limiter_execute(struct sb_limiter *limiter, const float *target_rad, uint32_t declared_us, uint32_t elapsed_us)
{
    /* A day without a set-point must not overflow: more than the cap is never used. */
    const uint32_t cap = declared_us + CREDIT_SLACK_US;
    const uint32_t earned = (elapsed_us < cap) ? elapsed_us : cap;
    const uint32_t credit = (limiter->credit_us + earned < cap) ? (limiter->credit_us + earned) : cap;
    const uint32_t dt_us = (declared_us < credit) ? declared_us : credit;
    if (dt_us < MIN_INTERVAL_US) {
        return false;
    }
    limiter->credit_us = credit - dt_us;
    const float dt_s = (float)dt_us * 1e-6f;
    for (uint32_t i = 0u; i < limiter->joints; i++) {
        move(limiter, i, target_rad[i], dt_s);
    }
    return true;
}
