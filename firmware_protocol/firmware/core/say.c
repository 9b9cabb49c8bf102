#include "say.h"

#include <math.h>
#include <stddef.h>

#include "generated/catalogue.h"
#include "generated/snakebot.h"

#define SAMPLE_MASK 0xFFFu
#define MOST_LIMIT_STEPS 131071.0f /* 17 bits */

void sb_say_out(struct sb_board *board)
{
    if (board->out_length > 0u) {
        hal_serial_write(board->out, board->out_length);
        board->out_length = 0u;
    }
}

static void send(struct sb_board *board, const struct sb_frame *frame)
{
    if (board->out_length + SB_MAX_ENCODED + 2u > SB_OUT_BYTES) {
        sb_say_out(board);
    }
    if (board->out_length == 0u) {
        board->out[0] = 0u; /* closes whatever noise stands on the line */
        board->out_length = 1u;
    }
    board->out_length += sb_pack(frame, &board->out[board->out_length]);
    hal_can_write(frame);
}

/* Packs a message's struct into a frame and sends it. */
#define SEND(board, name, NAME, message)                                                          \
    do {                                                                                          \
        struct sb_frame frame_ = {SNAKEBOT_##NAME##_FRAME_ID, SNAKEBOT_##NAME##_LENGTH, {0u}};    \
        (void)snakebot_##name##_pack(frame_.data, &(message), sizeof frame_.data);                \
        send((board), &frame_);                                                                   \
    } while (false)

void sb_say_fault(struct sb_board *board)
{
    const struct snakebot_fault_event_t event = {
        .code = board->modes.fault.code,
        .joint = board->modes.fault.joint,
        .number = board->modes.latch,
        .detail = board->modes.fault.detail,
        .board_time_us = board->modes.fault_since_us,
    };
    SEND(board, fault_event, FAULT_EVENT, event);
}

void sb_say_beat(struct sb_board *board)
{
    const struct snakebot_board_heartbeat_t beat = {
        .boot_id = board->boot_id,
        .mode = board->modes.mode,
        .powered = board->modes.powered ? 1u : 0u,
        .simulated = board->joints.config->simulated ? 1u : 0u,
        .fault = board->modes.fault.code,
        .holder = board->modes.holder,
    };
    SEND(board, board_heartbeat, BOARD_HEARTBEAT, beat);
    if (board->modes.fault.code != SNAKEBOT_FAULT_EVENT_CODE_NONE_CHOICE) {
        sb_say_fault(board);
    }
}

/* A limit in steps of the wire. */
static uint32_t limit_steps(float value)
{
    return (uint32_t)lroundf(fminf(value / SB_LIMIT_STEP, MOST_LIMIT_STEPS));
}

void sb_say_limits(struct sb_board *board)
{
    for (uint8_t i = 0u; i < board->joints.config->joints; i++) {
        const struct sb_limits *limits = &board->joints.limiter.limits[i];
        const struct snakebot_joint_limits_t message = {
            .joint = (uint8_t)(i + 1u),
            .angle_rad = limit_steps(limits->angle_rad),
            .speed_rad_s = limit_steps(limits->speed_rad_s),
            .acceleration_rad_s2 = limit_steps(limits->acceleration_rad_s2),
        };
        SEND(board, joint_limits, JOINT_LIMITS, message);
    }
}

void sb_say_info(struct sb_board *board)
{
    const struct sb_config *config = board->joints.config;
    const struct snakebot_info_protocol_t protocol = {
        .protocol_major = SB_PROTOCOL_MAJOR,
        .protocol_minor = SB_PROTOCOL_MINOR,
        .joints = config->joints,
        .simulated = config->simulated ? 1u : 0u,
        .catalogue_hash = SB_CATALOGUE_HASH,
    };
    const struct snakebot_info_firmware_t firmware = {
        .firmware_major = SB_FIRMWARE_MAJOR,
        .firmware_minor = SB_FIRMWARE_MINOR,
        .firmware_patch = SB_FIRMWARE_PATCH,
        .watchdog_ms = SB_WATCHDOG_US / 1000u,
        .counts_per_rev = config->counts_per_rev,
        .boot_id = board->boot_id,
    };
    const struct snakebot_info_serial_t serial = {.serial_number = config->serial_number};
    SEND(board, info_protocol, INFO_PROTOCOL, protocol);
    SEND(board, info_firmware, INFO_FIRMWARE, firmware);
    SEND(board, info_serial, INFO_SERIAL, serial);
    sb_say_limits(board);
}

void sb_say_sample(struct sb_board *board, uint32_t now_us)
{
    const struct sb_joints *joints = &board->joints;
    const uint8_t groups = sb_groups(joints->config->joints);
    int16_t measured[SB_MAX_GROUPS * SB_GROUP];
    int16_t applied[SB_MAX_GROUPS * SB_GROUP];
    for (uint8_t i = 0u; i < groups * SB_GROUP; i++) {
        const bool exists = i < joints->config->joints;
        measured[i] = (int16_t)(exists ? sb_joints_measured(joints, i) : INT16_MIN);
        applied[i] = (int16_t)(exists ? sb_joints_applied(joints, i) : 0);
    }
    const struct snakebot_state_t state = {
        .sequence = board->sequence,
        .sample = board->sample,
        .mode = board->modes.mode,
        .board_time_us = now_us,
    };
    SEND(board, state, STATE, state);
    for (uint8_t group = 0u; group < groups; group++) {
        const int16_t *part = &measured[(size_t)SB_GROUP * group];
        const struct snakebot_measured_t message = {board->sample, group, part[0], part[1], part[2]};
        SEND(board, measured, MEASURED, message);
    }
    for (uint8_t group = 0u; group < groups; group++) {
        const int16_t *part = &applied[(size_t)SB_GROUP * group];
        const struct snakebot_applied_t message = {board->sample, group, part[0], part[1], part[2]};
        SEND(board, applied, APPLIED, message);
    }
    board->sample = (uint16_t)((board->sample + 1u) & SAMPLE_MASK);
}

static void send_supplies(struct sb_board *board)
{
    struct sb_supply supply = {0u, 0, 0};
    if (hal_supply_read(-1, &supply)) {
        const struct snakebot_supply_t message = {supply.voltage_mv, supply.current_ma, supply.temperature_dc};
        SEND(board, supply, SUPPLY, message);
    }
    for (uint8_t i = 0u; i < board->joints.config->joints; i++) {
        if (hal_supply_read((int8_t)i, &supply)) {
            const struct snakebot_joint_supply_t message = {(uint8_t)(i + 1u), supply.current_ma,
                                                            supply.temperature_dc};
            SEND(board, joint_supply, JOINT_SUPPLY, message);
        }
    }
}

void sb_say_second(struct sb_board *board)
{
    const struct snakebot_counters_t counters = {
        .received = board->received,
        .corrupt = (uint16_t)(board->corrupt + board->decoder.corrupt),
        .dropped = (uint16_t)(board->dropped + board->assembler.dropped),
        .clamped = board->clamped,
    };
    SEND(board, counters, COUNTERS, counters);
    send_supplies(board);
}

void sb_say_answer(struct sb_board *board, uint8_t token, uint16_t request, uint32_t host, struct sb_answer answer)
{
    const struct snakebot_acknowledge_t message = {token,   answer.result, board->modes.mode,
                                                   request, answer.detail, host};
    SEND(board, acknowledge, ACKNOWLEDGE, message);
}

void sb_say_pong(struct sb_board *board, uint32_t nonce, uint32_t now_us)
{
    const struct snakebot_pong_t pong = {.nonce = nonce, .board_time_us = now_us};
    SEND(board, pong, PONG, pong);
}
