#include "board.h"

#include <stddef.h>
#include <string.h>

#include "generated/catalogue.h"
#include "generated/snakebot.h"
#include "requests.h"

#define BEAT_US 100000u /* heartbeats, and samples while nothing streams */
#define SECOND_US 1000000u
#define STALL_US 1000000u /* a beat that is later than this is not made up for */
#define TURN_BYTES 256u   /* taken in by one step: bounded time, whatever the line does */
#define TURN_FRAMES 32u
#define TURN_TIMERS 16u
#define SAMPLE_MASK 0xFFFu
#define MAX_GAP 4u
#define HALF_RANGE 0x8000u

#define ARMED SNAKEBOT_STATE_MODE_ARMED_CHOICE
#define STOPPED SNAKEBOT_STATE_MODE_STOPPED_CHOICE

/* -- sending ------------------------------------------------------------------------------------------------------- */

static void flush(struct sb_board *board)
{
    if (board->out_length > 0u) {
        hal_serial_write(board->out, board->out_length);
        board->out_length = 0u;
    }
}

static void send(struct sb_board *board, const struct sb_frame *frame)
{
    if (board->out_length + SB_MAX_ENCODED + 2u > SB_OUT_BYTES) {
        flush(board);
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

static void send_fault(struct sb_board *board)
{
    const struct snakebot_fault_event_t event = {
        .code = board->modes.fault.code,
        .joint = board->modes.fault.joint,
        .detail = board->modes.fault.detail,
        .board_time_us = board->modes.fault_since_us,
    };
    SEND(board, fault_event, FAULT_EVENT, event);
}

static void send_beat(struct sb_board *board)
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
        send_fault(board);
    }
}

static void send_info(struct sb_board *board)
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
}

static void send_sample(struct sb_board *board, uint32_t now_us)
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

static void send_second(struct sb_board *board)
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

/* -- time ---------------------------------------------------------------------------------------------------------- */

static int32_t until(uint32_t due_us, uint32_t now_us)
{
    return (int32_t)(due_us - now_us); /* right across the wrap of the clock */
}

static bool due(uint32_t due_us, uint32_t now_us)
{
    return until(due_us, now_us) <= 0;
}

static uint32_t next(uint32_t due_us, uint32_t period_us, uint32_t now_us)
{
    return (until(due_us + STALL_US, now_us) < 0) ? (now_us + period_us) : (due_us + period_us);
}

static void expire(struct sb_board *board, uint32_t due_us)
{
    const enum sb_expiry expiry = sb_modes_expire(&board->modes, due_us);
    if (expiry == SB_EXPIRY_WATCHDOG) {
        send_fault(board);
    } else {
        sb_joints_power(&board->joints, board->modes.powered);
    }
}

/* One timer's work; false if none has run out. The watchdog goes first: it must not wait for a beat. */
static bool run_timer(struct sb_board *board, uint32_t now_us)
{
    uint32_t mode_due_us = 0u;
    if (sb_modes_due(&board->modes, &mode_due_us) && due(mode_due_us, now_us)) {
        expire(board, mode_due_us);
    } else if (due(board->beat_due_us, now_us)) {
        board->beat_due_us = next(board->beat_due_us, BEAT_US, now_us);
        send_beat(board);
    } else if (due(board->sample_due_us, now_us)) {
        board->sample_due_us = next(board->sample_due_us, BEAT_US, now_us);
        sb_joints_read(&board->joints);
        send_sample(board, now_us);
    } else if (due(board->second_due_us, now_us)) {
        board->second_due_us = next(board->second_due_us, SECOND_US, now_us);
        send_second(board);
    } else {
        return false;
    }
    return true;
}

static void watch_hardware(struct sb_board *board, uint32_t now_us)
{
    const struct sb_hardware_fault fault = hal_hardware_fault();
    if (fault.code == SNAKEBOT_FAULT_EVENT_CODE_NONE_CHOICE) {
        return;
    }
    if (fault.code == SNAKEBOT_FAULT_EVENT_CODE_EMERGENCY_STOP_CHOICE) {
        if (board->modes.mode != STOPPED) {
            sb_modes_emergency_stop(&board->modes, now_us);
            sb_joints_power(&board->joints, false);
            send_fault(board);
        }
    } else if (sb_modes_fail(&board->modes, fault, now_us)) {
        send_fault(board);
    } else {
        /* nothing is powered: nothing to freeze */
    }
}

static void run_timers(struct sb_board *board, uint32_t now_us)
{
    watch_hardware(board, now_us);
    for (uint32_t i = 0u; (i < TURN_TIMERS) && run_timer(board, now_us); i++) {
    }
}

uint32_t sb_board_idle_us(const struct sb_board *board)
{
    const uint32_t now_us = hal_time_us();
    const int32_t dues[] = {
        until(board->beat_due_us, now_us),
        until(board->sample_due_us, now_us),
        until(board->second_due_us, now_us),
    };
    uint32_t mode_due_us = 0u;
    int32_t soonest = dues[0];
    if (sb_modes_due(&board->modes, &mode_due_us) && (until(mode_due_us, now_us) < soonest)) {
        soonest = until(mode_due_us, now_us);
    }
    for (uint32_t i = 1u; i < sizeof dues / sizeof dues[0]; i++) {
        soonest = (dues[i] < soonest) ? dues[i] : soonest;
    }
    return (soonest > 0) ? (uint32_t)soonest : 0u;
}

/* -- what comes in ------------------------------------------------------------------------------------------------- */

static void acknowledge(struct sb_board *board, uint8_t token, uint16_t request, struct sb_answer answer)
{
    const struct snakebot_acknowledge_t message = {token, answer.result, request, answer.detail};
    SEND(board, acknowledge, ACKNOWLEDGE, message);
}

static void take_mode(struct sb_board *board, const struct sb_frame *frame, uint32_t now_us)
{
    struct snakebot_mode_request_t request;
    (void)snakebot_mode_request_unpack(&request, frame->data, frame->length);
    const uint8_t before = board->modes.mode;
    const struct sb_answer answer = sb_modes_request(&board->modes, request.mode, request.host, now_us);
    if (board->modes.mode != before) {
        if (board->modes.mode == ARMED) {
            sb_assembler_reset(&board->assembler);
            sb_limiter_reset(&board->joints.limiter);
            board->first = true;
            board->executed_us = now_us;
        }
        sb_joints_power(&board->joints, board->modes.powered);
    }
    acknowledge(board, request.token, frame->id, answer);
}

static void take_joint_mode(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_joint_mode_request_t request;
    (void)snakebot_joint_mode_request_unpack(&request, frame->data, frame->length);
    acknowledge(board, request.token, frame->id, sb_request_joint_mode(&board->joints, &board->modes, &request));
}

static void take_limit(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_limit_request_t request;
    (void)snakebot_limit_request_unpack(&request, frame->data, frame->length);
    acknowledge(board, request.token, frame->id, sb_request_limit(&board->joints, &board->modes, &request));
}

static void take_trim(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_trim_request_t request;
    (void)snakebot_trim_request_unpack(&request, frame->data, frame->length);
    acknowledge(board, request.token, frame->id, sb_request_trim(&board->joints, &board->modes, &request));
}

static void take_zero(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_zero_request_t request;
    (void)snakebot_zero_request_unpack(&request, frame->data, frame->length);
    acknowledge(board, request.token, frame->id, sb_request_zero(&board->joints, &board->modes, &request));
}

/* Execute a complete set-point, if it is newer than the last one and does not come too early. */
static void execute(struct sb_board *board, const struct sb_tick *tick, uint32_t now_us)
{
    uint32_t step = ((uint32_t)tick->sequence - board->sequence) & 0xFFFFu;
    if (board->first) {
        step = 1u;
    }
    if ((step == 0u) || (step >= HALF_RANGE)) {
        board->dropped++;
        return;
    }
    const uint32_t gap = (step < MAX_GAP) ? step : MAX_GAP;
    bool clamped = false;
    sb_joints_read(&board->joints); /* before the joints move: the reading belongs to the set-points before */
    if (!sb_joints_execute(&board->joints, tick, gap, now_us - board->executed_us, &clamped)) {
        board->dropped++;
        return;
    }
    board->first = false;
    board->sequence = tick->sequence;
    board->executed_us = now_us;
    board->clamped = (uint16_t)(board->clamped + (clamped ? 1u : 0u));
    board->sample_due_us = now_us + BEAT_US;
    sb_modes_executed(&board->modes, now_us);
    send_sample(board, now_us);
}

static void take_setpoint(struct sb_board *board, const struct sb_frame *frame, uint32_t now_us)
{
    struct snakebot_setpoint_t group;
    struct sb_tick tick;
    (void)snakebot_setpoint_unpack(&group, frame->data, frame->length);
    if ((board->modes.mode == ARMED) && sb_assembler_group(&board->assembler, &group, &tick)) {
        execute(board, &tick, now_us);
    }
}

static void take_latch(struct sb_board *board, const struct sb_frame *frame, uint32_t now_us)
{
    struct snakebot_latch_t latch;
    struct sb_tick tick;
    (void)snakebot_latch_unpack(&latch, frame->data, frame->length);
    if (board->modes.mode != ARMED) {
        board->dropped++;
    } else if (sb_assembler_latch(&board->assembler, &latch, &tick)) {
        execute(board, &tick, now_us);
    } else {
        /* incomplete so far */
    }
}

static void take_ping(struct sb_board *board, const struct sb_frame *frame, uint32_t now_us)
{
    struct snakebot_ping_t ping;
    (void)snakebot_ping_unpack(&ping, frame->data, frame->length);
    const struct snakebot_pong_t pong = {.nonce = ping.nonce, .board_time_us = now_us};
    SEND(board, pong, PONG, pong);
}

static void take_heartbeat(struct sb_board *board, const struct sb_frame *frame, uint32_t now_us)
{
    struct snakebot_host_heartbeat_t heartbeat;
    (void)snakebot_host_heartbeat_unpack(&heartbeat, frame->data, frame->length);
    sb_modes_heartbeat(&board->modes, heartbeat.host, now_us);
}

static void take(struct sb_board *board, const struct sb_frame *frame, uint32_t now_us)
{
    board->received++;
    if (frame->id == SNAKEBOT_EMERGENCY_STOP_FRAME_ID) { /* whatever its payload, before anything else is looked at */
        sb_modes_emergency_stop(&board->modes, now_us);
        sb_joints_power(&board->joints, false);
        send_fault(board);
        return;
    }
    if (!sb_catalogue_accepts(frame->id, frame->data, frame->length)) {
        board->corrupt++;
        return;
    }
    switch (frame->id) {
    case SNAKEBOT_SETPOINT_FRAME_ID:
        take_setpoint(board, frame, now_us);
        break;
    case SNAKEBOT_LATCH_FRAME_ID:
        take_latch(board, frame, now_us);
        break;
    case SNAKEBOT_HOST_HEARTBEAT_FRAME_ID:
        take_heartbeat(board, frame, now_us);
        break;
    case SNAKEBOT_MODE_REQUEST_FRAME_ID:
        take_mode(board, frame, now_us);
        break;
    case SNAKEBOT_JOINT_MODE_REQUEST_FRAME_ID:
        take_joint_mode(board, frame);
        break;
    case SNAKEBOT_LIMIT_REQUEST_FRAME_ID:
        take_limit(board, frame);
        break;
    case SNAKEBOT_TRIM_REQUEST_FRAME_ID:
        take_trim(board, frame);
        break;
    case SNAKEBOT_ZERO_REQUEST_FRAME_ID:
        take_zero(board, frame);
        break;
    case SNAKEBOT_PING_FRAME_ID:
        take_ping(board, frame, now_us);
        break;
    case SNAKEBOT_INFO_REQUEST_FRAME_ID:
        send_info(board);
        break;
    default:
        break; /* what boards say */
    }
}

void sb_board_reset(struct sb_board *board, const struct sb_config *config)
{
    const uint16_t before = board->boot_id;
    memset(board, 0, sizeof *board);
    sb_joints_reset(&board->joints, config);
    board->assembler.joints = config->joints;
    board->boot_id = (uint16_t)hal_random();
    if ((board->boot_id == before) || (board->boot_id == 0u)) {
        board->boot_id = (uint16_t)((before == 1u) ? 2u : 1u);
    }
    const uint32_t now_us = hal_time_us();
    board->beat_due_us = now_us;
    board->sample_due_us = now_us;
    board->second_due_us = now_us + SECOND_US;
}

void sb_board_step(struct sb_board *board)
{
    uint8_t bytes[TURN_BYTES];
    struct sb_frame frame;
    const uint32_t now_us = hal_time_us();

    /* What has waited in a buffer while the processor was elsewhere must not outrun the watchdog. */
    run_timers(board, now_us);
    const uint32_t length = hal_serial_read(bytes, TURN_BYTES);
    for (uint32_t i = 0u; i < length; i++) {
        if (sb_decoder_feed(&board->decoder, bytes[i], &frame)) {
            take(board, &frame, now_us);
        }
    }
    for (uint32_t i = 0u; (i < TURN_FRAMES) && hal_can_read(&frame); i++) {
        take(board, &frame, now_us);
    }
    flush(board);
}
