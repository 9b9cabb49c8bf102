#include "requests.h"

#include <math.h>

#include "generated/catalogue.h"

#define OK SNAKEBOT_ACKNOWLEDGE_RESULT_OK_CHOICE
#define BAD_VALUE SNAKEBOT_ACKNOWLEDGE_RESULT_BAD_VALUE_CHOICE
#define BAD_JOINT SNAKEBOT_ACKNOWLEDGE_RESULT_BAD_JOINT_CHOICE
#define FORBIDDEN SNAKEBOT_ACKNOWLEDGE_RESULT_FORBIDDEN_CHOICE
#define HELD SNAKEBOT_ACKNOWLEDGE_RESULT_HELD_CHOICE
#define RIGID SNAKEBOT_JOINT_MODE_REQUEST_MODE_RIGID_CHOICE

static struct sb_answer answer(uint8_t result, uint8_t detail)
{
    return (struct sb_answer){result, detail};
}

static bool disarmed(const struct sb_modes *modes)
{
    return modes->mode == SNAKEBOT_STATE_MODE_DISARMED_CHOICE;
}

/* What every request is looked at for first; OK where nothing is wrong so far. */
static struct sb_answer look(const struct sb_joints *joints, const struct sb_modes *modes, uint8_t joint, uint32_t host)
{
    if (sb_modes_held_against(modes, host)) {
        return answer(HELD, 0u);
    }
    if ((joint < 1u) || (joint > joints->config->joints)) {
        return answer(BAD_JOINT, joints->config->joints);
    }
    if (host == SB_NOBODY) {
        return answer(BAD_VALUE, 0u);
    }
    return answer(OK, 0u);
}

struct sb_answer sb_request_joint_mode(struct sb_joints *joints, const struct sb_modes *modes,
                                       const struct snakebot_joint_mode_request_t *request)
{
    const struct sb_answer first = look(joints, modes, request->joint, request->host);
    if (first.result != OK) {
        return first;
    }
    const uint8_t joint = (uint8_t)(request->joint - 1u);
    const float angle_rad = (float)request->angle_rad * SB_ANGLE_STEP_RAD;
    const float limit_rad = joints->limiter.limits[joint].angle_rad + SB_ANGLE_STEP_RAD / 2.0f;
    if ((request->mode == RIGID) && (fabsf(angle_rad) > limit_rad)) {
        return answer(BAD_VALUE, 0u);
    }
    if (!disarmed(modes) && !sb_modes_held(modes)) {
        return answer(FORBIDDEN, 0u);
    }
    joints->mode[joint] = request->mode;
    joints->hold_rad[joint] = angle_rad;
    sb_joints_power(joints, modes->powered);
    return first;
}

struct sb_answer sb_request_limit(struct sb_joints *joints, const struct sb_modes *modes,
                                  const struct snakebot_limit_request_t *request)
{
    const struct sb_answer first = look(joints, modes, request->joint, request->host);
    if (first.result != OK) {
        return first;
    }
    const uint8_t joint = (uint8_t)(request->joint - 1u);
    const float half_step = SB_LIMIT_STEP / 2.0f; /* rounding must not make a limit forbidden */
    const float value = (float)request->value * SB_LIMIT_STEP;
    struct sb_limits built_in = joints->config->limits[joint];
    const float largest = *sb_limit(&built_in, request->kind);
    float *in_force = sb_limit(&joints->limiter.limits[joint], request->kind);
    if ((request->value == 0u) || (value > largest + half_step)) {
        return answer(BAD_VALUE, 0u);
    }
    if (disarmed(modes)) {
        *in_force = fminf(value, largest);
        return first;
    }
    if (!sb_modes_held(modes) || (value > *in_force + half_step)) {
        return answer(FORBIDDEN, 0u);
    }
    *in_force = fminf(value, *in_force);
    return first;
}

struct sb_answer sb_request_trim(struct sb_joints *joints, const struct sb_modes *modes,
                                 const struct snakebot_trim_request_t *request)
{
    const struct sb_answer first = look(joints, modes, request->joint, request->host);
    if (first.result != OK) {
        return first;
    }
    const uint8_t joint = (uint8_t)(request->joint - 1u);
    if ((request->trim_rad > SB_MOST_TRIM) || (request->trim_rad < -SB_MOST_TRIM)) {
        return answer(BAD_VALUE, 0u);
    }
    if (!disarmed(modes)) {
        return answer(FORBIDDEN, 0u);
    }
    if (joints->parameters.trim[joint] != request->trim_rad) {
        joints->parameters.trim[joint] = request->trim_rad;
        hal_parameters_save(&joints->parameters);
    }
    return first;
}

struct sb_answer sb_request_zero(struct sb_joints *joints, const struct sb_modes *modes,
                                 const struct snakebot_zero_request_t *request)
{
    const struct sb_answer first = look(joints, modes, request->joint, request->host);
    if (first.result != OK) {
        return first;
    }
    if (!disarmed(modes)) {
        return answer(FORBIDDEN, 0u);
    }
    const uint8_t joint = (uint8_t)(request->joint - 1u);
    if (joints->parameters.zero_counts[joint] != request->zero_counts) {
        joints->parameters.zero_counts[joint] = request->zero_counts;
        hal_parameters_save(&joints->parameters);
    }
    return first;
}
