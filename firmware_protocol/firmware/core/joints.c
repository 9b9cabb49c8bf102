#include "joints.h"

#include <math.h>
#include <string.h>

#include "generated/catalogue.h"
#include "generated/snakebot.h"

#define ACTIVE SNAKEBOT_JOINT_MODE_REQUEST_MODE_ACTIVE_CHOICE
#define FREE SNAKEBOT_JOINT_MODE_REQUEST_MODE_FREE_CHOICE
#define RIGID SNAKEBOT_JOINT_MODE_REQUEST_MODE_RIGID_CHOICE
#define TWO_PI 6.28318530718f
#define LARGEST 32767
#define NO_READING (-32768)

float *sb_limit(struct sb_limits *limits, uint8_t kind)
{
    switch (kind) {
    case SNAKEBOT_LIMIT_REQUEST_KIND_ANGLE_CHOICE:
        return &limits->angle_rad;
    case SNAKEBOT_LIMIT_REQUEST_KIND_SPEED_CHOICE:
        return &limits->speed_rad_s;
    default:
        return &limits->acceleration_rad_s2;
    }
}

static float trim_rad(const struct sb_joints *joints, uint8_t joint)
{
    return (float)joints->trim[joint] * SB_ANGLE_STEP_RAD;
}

void sb_joints_reset(struct sb_joints *joints, const struct sb_config *config)
{
    memset(joints, 0, sizeof *joints);
    joints->config = config;
    joints->limiter.joints = config->joints;
    memcpy(joints->limiter.limits, config->limits, sizeof joints->limiter.limits);
    if (!hal_parameters_load(&joints->parameters)) {
        memset(&joints->parameters, 0, sizeof joints->parameters);
    }
    for (uint8_t i = 0u; i < SB_MAX_JOINTS; i++) {
        int16_t *trim = &joints->parameters.trim[i];
        if ((*trim > SB_MOST_TRIM) || (*trim < -SB_MOST_TRIM)) {
            *trim = 0; /* no request has stored that */
        }
        joints->trim[i] = *trim;
        joints->limiter.applied_rad[i] = trim_rad(joints, i);
    }
    sb_limiter_reset(&joints->limiter);
    for (uint8_t i = 0u; i < config->joints; i++) {
        hal_servo_off(i);
    }
    sb_joints_read(joints);
}

static void read_one(struct sb_joints *joints, uint8_t joint)
{
    int32_t counts = 0;
    joints->reading[joint] = hal_encoder_read(joint, &counts);
    if (!joints->reading[joint]) {
        return;
    }
    joints->known[joint] = true;
    /* Unsigned: an encoder that has counted around must not be undefined behaviour. */
    joints->counts[joint] = (int32_t)((uint32_t)counts - (uint32_t)(int32_t)joints->parameters.zero_counts[joint]);
    if (!joints->powered[joint]) {
        const float angle_rad = (float)joints->counts[joint] * (TWO_PI / (float)joints->config->counts_per_rev);
        sb_limiter_follow(&joints->limiter, joint, angle_rad + trim_rad(joints, joint));
    }
}

void sb_joints_read(struct sb_joints *joints)
{
    for (uint8_t i = 0u; i < joints->config->joints; i++) {
        read_one(joints, i);
    }
}

static void command_one(const struct sb_joints *joints, uint8_t joint)
{
    const struct sb_servo *servo = &joints->config->servos[joint];
    const float pulse_ns = (float)servo->centre_ns + joints->limiter.applied_rad[joint] * (float)servo->ns_per_rad;
    const float safe_ns = fminf(fmaxf(pulse_ns, (float)servo->shortest_ns), (float)servo->longest_ns);
    hal_servo_pulse(joint, (uint32_t)lroundf(safe_ns));
}

void sb_joints_command(struct sb_joints *joints)
{
    for (uint8_t i = 0u; i < joints->config->joints; i++) {
        if (joints->powered[i]) {
            command_one(joints, i);
        }
    }
}

void sb_joints_power(struct sb_joints *joints, bool powered)
{
    for (uint8_t i = 0u; i < joints->config->joints; i++) {
        const bool wanted = powered && (joints->mode[i] != FREE);
        if (wanted == joints->powered[i]) {
            continue;
        }
        if (wanted) {
            read_one(joints, i); /* it starts where it is: nothing jumps */
            if (joints->known[i]) {
                joints->powered[i] = true;
                joints->trim[i] = joints->parameters.trim[i]; /* a change is made under the limits, from now on */
                command_one(joints, i);
            }
        } else {
            joints->powered[i] = false;
            hal_servo_off(i);
        }
    }
}

/* Where the servo is to be. */
static float target(const struct sb_joints *joints, uint8_t joint, int16_t setpoint)
{
    switch (joints->mode[joint]) {
    case ACTIVE:
        return (float)(setpoint + joints->trim[joint]) * SB_ANGLE_STEP_RAD;
    case RIGID:
        return joints->hold_rad[joint] + trim_rad(joints, joint);
    default:
        return joints->limiter.applied_rad[joint];
    }
}

bool sb_joints_execute(struct sb_joints *joints, const struct sb_tick *tick, uint32_t gap, uint32_t elapsed_us,
                       bool *clamped)
{
    const uint32_t interval_us = (uint32_t)lroundf(SB_INTERVAL_STEP_S * 1e6f) * tick->interval;
    float target_rad[SB_MAX_JOINTS] = {0.0f};
    for (uint8_t i = 0u; i < joints->config->joints; i++) {
        target_rad[i] = target(joints, i, tick->angle[i]);
    }
    if (!sb_limiter_execute(&joints->limiter, target_rad, interval_us * gap, elapsed_us)) {
        return false;
    }
    *clamped = false;
    for (uint8_t i = 0u; i < joints->config->joints; i++) {
        const float changed_rad = fabsf(joints->limiter.applied_rad[i] - target_rad[i]);
        if ((joints->mode[i] == ACTIVE) && (changed_rad > SB_ANGLE_STEP_RAD / 2.0f)) {
            *clamped = true;
        }
    }
    sb_joints_command(joints);
    return true;
}

int16_t sb_joints_applied(const struct sb_joints *joints, uint8_t joint)
{
    const float raw = joints->limiter.applied_rad[joint] / SB_ANGLE_STEP_RAD - (float)joints->trim[joint];
    return (int16_t)lroundf(fminf(fmaxf(raw, (float)-LARGEST), (float)LARGEST));
}

int16_t sb_joints_measured(const struct sb_joints *joints, uint8_t joint)
{
    const int32_t counts = joints->counts[joint];
    /* Beyond 16 bits a wrong angle would be worse than none. */
    if (!joints->reading[joint] || (counts > LARGEST) || (counts < -LARGEST)) {
        return NO_READING;
    }
    return (int16_t)counts;
}
