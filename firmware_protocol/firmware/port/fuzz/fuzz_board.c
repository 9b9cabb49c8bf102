/*
 * libFuzzer target: the whole board, fed with noise, frames and time; what must hold in every state is checked after
 * every step. The input is a script: a byte says what comes next.
 *
 *   0x00-0x7F  time passes: 4 s, 0.25 to 15.75 ms in quarters, 20 to 83 ms
 *   0x80-0xBF  a frame: one of the host's identifiers, and the next 8 bytes as its payload
 *   0xC0-0xDF  as many bytes on the serial line
 *   0xE0-0xEF  a set-point of one group for one tick, complete, with its CRC, at the next two bytes' angle
 *   0xF0-0xF7  a joint is turned by hand; an encoder fails, or comes back
 *   0xF8-0xFF  a fault of the hardware
 */
#include <math.h>
#include <stdlib.h>

#include "bench/bench.c"
#include "core/generated/catalogue.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define CLEAR 69u

static const uint16_t ids[16] = {
    1u, 16u, 17u, 48u, 64u, 65u, 66u, 67u, 68u, 80u, 88u, 32u, 49u, 79u, CLEAR, 0x7FFu,
};

static void check(bool right)
{
    if (!right) {
        abort();
    }
}

static struct sb_decoder listener;

/* Every byte that the board says belongs to a frame of the catalogue. */
static void check_wire(void)
{
    struct sb_frame frame;
    for (uint32_t i = 0u; i < out_length; i++) {
        if (sb_decoder_feed(&listener, out[i], &frame)) {
            check(sb_catalogue_accepts(frame.id, frame.data, frame.length));
        }
    }
    out_length = 0u;
    check(listener.corrupt == 0u);
}

static void check_state(void)
{
    const uint8_t mode = board.modes.mode;
    const bool held = (mode == 1u) || (mode == 2u);
    check(mode <= 4u);
    check(!held || board.modes.powered);
    check(((mode != 0u) && (mode != 3u)) || !board.modes.powered);
    check((mode != 3u) || (board.modes.fault.code == 2u));
    check((mode < 3u) == (board.modes.fault.code == 0u));
    check(!held || (board.modes.holder != 0u));
    for (uint32_t i = 0u; i < config.joints; i++) {
        const float applied = board.joints.limiter.applied_rad[i];
        const struct sb_path slow = board.joints.limiter.slow[i];
        const struct sb_path fast = board.joints.limiter.fast[i];
        check(isfinite(applied) && isfinite(slow.angle_rad) && isfinite(fast.angle_rad));
        check(slow.speed_rad_s <= fast.speed_rad_s); /* so neither is NaN */
        check(fabsf(slow.angle_rad - applied) < 2.1e-4f && fabsf(fast.angle_rad - applied) < 2.1e-4f);
        check(board.modes.powered || !board.joints.powered[i]);
        check(board.joints.powered[i] != isnan(simulated_joints_target((uint8_t)i)));
        check(board.joints.limiter.limits[i].angle_rad <= config.limits[i].angle_rad);
        check(board.joints.limiter.limits[i].angle_rad > 0.0f);
        check(abs(board.joints.trim[i]) <= SB_MOST_TRIM);
    }
    check(sb_board_idle_us(&board) <= 1000000u);
}

static void tick(int16_t angle)
{
    static uint8_t bytes[3u + 2u * SB_MAX_JOINTS];
    static uint16_t sequence;
    sequence++;
    for (uint8_t group = 0u; group < sb_groups(config.joints); group++) {
        const struct snakebot_setpoint_t part = {sequence & 0xFFFu, group, angle, angle, angle};
        uint8_t payload[8];
        (void)snakebot_setpoint_pack(payload, &part, sizeof payload);
        bench_can(16u, payload, 8u);
    }
    bytes[0] = (uint8_t)(sequence & 0xFFu);
    bytes[1] = (uint8_t)(sequence >> 8);
    bytes[2] = config.joints;
    for (uint32_t i = 0u; i < config.joints; i++) {
        bytes[3u + 2u * i] = (uint8_t)((uint16_t)angle & 0xFFu);
        bytes[4u + 2u * i] = (uint8_t)((uint16_t)angle >> 8);
    }
    const struct snakebot_latch_t latch = {sequence, config.joints, 20u, sb_crc32(bytes, 3u + 2u * config.joints)};
    uint8_t payload[8];
    (void)snakebot_latch_pack(payload, &latch, sizeof payload);
    bench_can(17u, payload, 8u);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 2u) {
        return 0;
    }
    memset(&listener, 0, sizeof listener);
    const uint8_t joints = (uint8_t)((data[0] < 0xF0u) ? (1u + data[0] % 4u) : SB_MAX_JOINTS); /* small ones are fast */
    bench_new(joints, data[1], 0xFFFFFFFFu - 4096u * data[1], 1.658f, 8.0f, 60.0f, 8192u,
              0.03f, true);
    size_t at = 2u;
    while (at < size) {
        const uint8_t what = data[at];
        const uint8_t mode_before = board.modes.mode;
        bool may_clear = (what >= 0xC0u) && (what < 0xE0u); /* bytes may be a packet of any kind */
        const size_t left = size - at - 1u;
        const uint8_t *next = &data[at + 1u];
        at++;
        if (what < 0x80u) {
            now_us += (what == 0u) ? 4000000u : ((what < 0x40u) ? (what * 250u) : ((what - 44u) * 1000u));
        } else if (what < 0xC0u) {
            const size_t length = (left < 8u) ? left : 8u;
            uint8_t payload[8] = {0u};
            memcpy(payload, next, length);
            may_clear = ids[what & 15u] == CLEAR;
            /* the right length mostly, any length sometimes */
            static const uint8_t lengths[16] = {5u, 8u, 8u, 6u, 6u, 8u, 8u, 8u, 8u, 4u, 4u, 8u, 8u, 8u, 6u, 0u};
            bench_can(ids[what & 15u], payload, (what < 0xB0u) ? lengths[what & 15u] : (uint8_t)(payload[7] % 9u));
            at += length;
        } else if (what < 0xE0u) {
            const size_t wanted = (size_t)(what & 0x1Fu) + 1u;
            const size_t length = (left < wanted) ? left : wanted;
            bench_serial(next, (uint32_t)length);
            at += length;
        } else if (what < 0xF0u) {
            tick((int16_t)((left >= 2u) ? (next[0] | (next[1] << 8)) : 0));
            at += (left >= 2u) ? 2u : left;
        } else if (what < 0xF8u) {
            const uint8_t joint = (uint8_t)((what & 7u) % config.joints);
            simulated_joints_place(joint, (left > 0u) ? ((float)next[0] - 128.0f) / 16.0f : 0.0f);
            simulated_joints_encoder_lost(joint, (left > 0u) && (next[0] % 5u == 0u));
            at += (left > 0u) ? 1u : 0u;
        } else {
            simulated_joints_fault((uint8_t)(what & 7u), what & 3u, 7);
            simulated_joints_supply((what & 1u) != 0u, 7400u, -100, 250);
        }
        bench_step();
        simulated_joints_fault(0u, 0u, 0);
        check_wire();
        check_state();
        check((mode_before < 3u) || (board.modes.mode >= 3u) || may_clear);
    }
    return 0;
}
