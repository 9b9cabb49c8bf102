#include "board.h"

#include <string.h>

#include "generated/catalogue.h"
#include "generated/snakebot.h"
#include "requests.h"
#include "say.h"

#define BEAT_US 100000u /* heartbeats, and samples while nothing streams */
#define SECOND_US 1000000u
#define STALL_US 1000000u /* a beat that is later than this is not made up for */
#define TURN_BYTES 256u   /* taken in by one step: bounded time, whatever the line does */
#define TURN_FRAMES 32u
#define TURN_TIMERS 16u
#define MAX_GAP 4u
#define HALF_RANGE 0x8000u

#define ARMED SNAKEBOT_STATE_MODE_ARMED_CHOICE
#define STOPPED SNAKEBOT_STATE_MODE_STOPPED_CHOICE

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
    if (sb_modes_expire(&board->modes, due_us)) {
        sb_say_fault(board);
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
        sb_say_beat(board);
    } else if (due(board->sample_due_us, now_us)) {
        board->sample_due_us = next(board->sample_due_us, BEAT_US, now_us);
        sb_joints_read(&board->joints);
        sb_say_sample(board, now_us);
    } else if (due(board->second_due_us, now_us)) {
        board->second_due_us = next(board->second_due_us, SECOND_US, now_us);
        sb_say_second(board);
    } else {
        return false;
    }
    return true;
}

static void watch_hardware(struct sb_board *board, uint32_t now_us)
{
    const struct sb_hardware_fault fault = hal_hardware_fault();
    const bool pressed_before = board->button;
    board->button = fault.code == SNAKEBOT_FAULT_EVENT_CODE_EMERGENCY_STOP_CHOICE;
    if (fault.code == SNAKEBOT_FAULT_EVENT_CODE_NONE_CHOICE) {
        return;
    }
    if (board->button) {
        if ((board->modes.mode != STOPPED) || !pressed_before) {
            sb_modes_emergency_stop(&board->modes, now_us);
            sb_joints_power(&board->joints, false);
            sb_say_fault(board);
        }
    } else if (sb_modes_fail(&board->modes, fault, now_us)) {
        sb_say_fault(board);
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

static void take_mode(struct sb_board *board, const struct sb_frame *frame, uint32_t now_us)
{
    struct snakebot_mode_request_t request;
    (void)snakebot_mode_request_unpack(&request, frame->data, frame->length);
    const uint8_t before = board->modes.mode;
    const struct sb_answer answer = sb_modes_request(&board->modes, request.mode, request.host, now_us);
    if (board->modes.mode != before) {
        if (board->modes.mode == ARMED) {
            sb_assembler_reset(&board->assembler);
            sb_limiter_rest(&board->joints.limiter, now_us - board->executed_us);
            board->first = true;
            board->executed_us = now_us;
        }
        sb_joints_power(&board->joints, board->modes.powered);
    }
    sb_say_answer(board, request.token, frame->id, request.host, answer);
    if ((request.mode == ARMED) && (answer.result == SNAKEBOT_ACKNOWLEDGE_RESULT_OK_CHOICE)) {
        sb_say_limits(board); /* after the answer: what the host hears now is in force until it disarms */
    }
}

static void take_clear(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_clear_request_t request;
    (void)snakebot_clear_request_unpack(&request, frame->data, frame->length);
    const struct sb_answer answer = sb_modes_clear(&board->modes, request.number, request.host);
    sb_joints_power(&board->joints, board->modes.powered);
    sb_say_answer(board, request.token, frame->id, request.host, answer);
}

static void take_joint_mode(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_joint_mode_request_t request;
    (void)snakebot_joint_mode_request_unpack(&request, frame->data, frame->length);
    sb_say_answer(board, request.token, frame->id, request.host,
                  sb_request_joint_mode(&board->joints, &board->modes, &request));
}

static void take_limit(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_limit_request_t request;
    (void)snakebot_limit_request_unpack(&request, frame->data, frame->length);
    sb_say_answer(board, request.token, frame->id, request.host,
                  sb_request_limit(&board->joints, &board->modes, &request));
}

static void take_trim(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_trim_request_t request;
    (void)snakebot_trim_request_unpack(&request, frame->data, frame->length);
    sb_say_answer(board, request.token, frame->id, request.host,
                  sb_request_trim(&board->joints, &board->modes, &request));
}

static void take_zero(struct sb_board *board, const struct sb_frame *frame)
{
    struct snakebot_zero_request_t request;
    (void)snakebot_zero_request_unpack(&request, frame->data, frame->length);
    sb_say_answer(board, request.token, frame->id, request.host,
                  sb_request_zero(&board->joints, &board->modes, &request));
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
    sb_say_sample(board, now_us);
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
    sb_say_pong(board, ping.nonce, now_us);
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
        sb_say_fault(board);
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
    case SNAKEBOT_CLEAR_REQUEST_FRAME_ID:
        take_clear(board, frame);
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
        sb_say_info(board);
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
    board->executed_us = now_us;
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
    sb_say_out(board);
}
