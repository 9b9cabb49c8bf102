/* The core as a shared library with time, wires and joints in the caller's hands: for tests. */
#include <string.h>

#include "core/board.h"
#include "core/crc.h"
#include "core/hal.h"
#include "model/simulated_joints.h"

#define WIRE 65536u
#define FRAMES 4096u
#define DRAWS 8u
#define RUBBISH 0x22 /* what nobody stored, as bytes */

static struct sb_board board;
static struct sb_config config;
static uint32_t now_us;
static uint32_t random_state;
static uint8_t in[WIRE];
static uint32_t in_length;
static uint8_t out[WIRE];
static uint32_t out_length;
static struct sb_frame can_in[FRAMES];
static uint32_t can_in_first;
static uint32_t can_in_count;
static struct sb_frame can_out[FRAMES];
static uint32_t can_out_count;
static uint32_t can_out_taken;
static struct sb_parameters stored;
static bool is_stored;
static uint32_t saves;
static uint32_t drawn[DRAWS]; /* what hal_random gives next, last first */
static uint32_t draws;

uint32_t hal_time_us(void)
{
    return now_us;
}

uint32_t hal_random(void)
{
    if (draws > 0u) {
        draws--;
        return drawn[draws];
    }
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8;
}

uint32_t hal_serial_read(uint8_t *data, uint32_t most)
{
    const uint32_t length = (in_length < most) ? in_length : most;
    memcpy(data, in, length);
    memmove(in, &in[length], in_length - length);
    in_length -= length;
    return length;
}

void hal_serial_write(const uint8_t *data, uint32_t length)
{
    if (out_length + length <= WIRE) {
        memcpy(&out[out_length], data, length);
        out_length += length;
    }
}

bool hal_can_read(struct sb_frame *frame)
{
    if (can_in_count == 0u) {
        return false;
    }
    *frame = can_in[can_in_first];
    can_in_first = (can_in_first + 1u) % FRAMES;
    can_in_count--;
    return true;
}

void hal_can_write(const struct sb_frame *frame)
{
    can_out[can_out_count % FRAMES] = *frame;
    can_out_count++;
}

bool hal_parameters_load(struct sb_parameters *parameters)
{
    if (is_stored) {
        *parameters = stored;
    } else {
        memset(parameters, RUBBISH, sizeof *parameters); /* nothing is promised of it */
    }
    return is_stored;
}

void hal_parameters_save(const struct sb_parameters *parameters)
{
    stored = *parameters;
    is_stored = true;
    saves++;
}

/* -- what a test calls --------------------------------------------------------------------------------------------- */

/* A new board with new joints: nothing stored. */
void bench_new(uint8_t joints, uint32_t seed, uint32_t start_us, float angle_rad, float speed_rad_s,
               float acceleration_rad_s2, uint16_t counts_per_rev, float time_constant_s, bool simulated)
{
    static const float straight[SB_MAX_JOINTS];
    now_us = start_us;
    random_state = seed;
    in_length = 0u;
    out_length = 0u;
    can_in_count = 0u;
    can_out_count = 0u;
    can_out_taken = 0u;
    is_stored = false;
    saves = 0u;
    draws = 0u;
    memset(&stored, 0, sizeof stored);
    config = simulated_board(joints, 0xFEDCBA9876543210u);
    config.counts_per_rev = counts_per_rev;
    config.simulated = simulated;
    for (uint32_t i = 0u; i < SB_MAX_JOINTS; i++) {
        config.limits[i] = (struct sb_limits){angle_rad, speed_rad_s, acceleration_rad_s2};
        /* They understand everything; each is mounted in its own way, every other one the other way round. */
        const int32_t slope = 636620 + 5000 * (int32_t)i;
        config.servos[i] = (struct sb_servo){8000000u + 1000u * i, ((i % 2u) == 0u) ? slope : -slope, 1u, 16000000u};
    }
    simulated_joints_start(&config, straight, time_constant_s);
    simulated_joints_fault(0u, 0u, 0);
    simulated_joints_supply(false, 0u, 0, 0);
    sb_board_reset(&board, &config);
}

/* Switch it off and on: what is stored is kept, and so is the place of the joints. */
void bench_reset(void)
{
    sb_board_reset(&board, &config);
}

/* Built-in limits of one joint, from the next reset on. */
void bench_limits(uint8_t joint, float angle_rad, float speed_rad_s, float acceleration_rad_s2)
{
    config.limits[joint] = (struct sb_limits){angle_rad, speed_rad_s, acceleration_rad_s2};
}

/* A number that the random source gives before all others; of several the last one first. */
void bench_draw(uint32_t number)
{
    if (draws < DRAWS) {
        drawn[draws] = number;
        draws++;
    }
}

void bench_time(uint32_t time_us)
{
    now_us = time_us;
}

void bench_serial(const uint8_t *data, uint32_t length)
{
    if (in_length + length <= WIRE) {
        memcpy(&in[in_length], data, length);
        in_length += length;
    }
}

void bench_can(uint16_t id, const uint8_t *data, uint8_t length)
{
    struct sb_frame *frame = &can_in[(can_in_first + can_in_count) % FRAMES];
    if (can_in_count < FRAMES) {
        frame->id = id;
        frame->length = length;
        memset(frame->data, 0, sizeof frame->data);
        memcpy(frame->data, data, length);
        can_in_count++;
    }
}

/* One turn of the main loop, and further ones as long as something waits. */
void bench_step(void)
{
    do {
        sb_board_step(&board);
    } while ((in_length > 0u) || (can_in_count > 0u));
}

uint32_t bench_idle_us(void)
{
    return sb_board_idle_us(&board);
}

uint32_t bench_take(uint8_t *data)
{
    const uint32_t length = out_length;
    memcpy(data, out, length);
    out_length = 0u;
    return length;
}

/* The next frame that it has sent over CAN: its length, or -1 where there is none. */
int32_t bench_take_can(uint16_t *id, uint8_t data[SB_MAX_PAYLOAD])
{
    if (can_out_taken == can_out_count) {
        return -1;
    }
    const struct sb_frame *frame = &can_out[can_out_taken % FRAMES];
    can_out_taken++;
    *id = frame->id;
    memcpy(data, frame->data, frame->length);
    return frame->length;
}

uint32_t bench_can_sent(void)
{
    return can_out_count;
}

/* What a damaged memory, or another firmware, may have left there. */
void bench_store_trim(uint8_t joint, int16_t steps)
{
    stored.trim[joint] = steps;
    is_stored = true;
}

int16_t bench_stored_trim(uint8_t joint)
{
    return stored.trim[joint];
}

uint32_t bench_saves(void)
{
    return saves;
}

uint8_t bench_mode(void)
{
    return board.modes.mode;
}

/* One joint's limiter by itself: what is applied after each of `count` set-points, or NaN where one comes too early. */
void bench_limiter(const float *limits, float start_rad, uint32_t count, const float *target_rad,
                   const uint32_t *declared_us, const uint32_t *elapsed_us, float *applied_rad)
{
    struct sb_limiter limiter = {.joints = 1u};
    limiter.limits[0] = (struct sb_limits){limits[0], limits[1], limits[2]};
    limiter.applied_rad[0] = start_rad;
    sb_limiter_reset(&limiter);
    uint32_t waited_us = 0u;
    for (uint32_t i = 0u; i < count; i++) {
        waited_us += elapsed_us[i];
        const bool executed = sb_limiter_execute(&limiter, &target_rad[i], declared_us[i], waited_us);
        applied_rad[i] = executed ? limiter.applied_rad[0] : __builtin_nanf("");
        waited_us = executed ? 0u : waited_us;
    }
}
