/**
 * @file snakebot.c
 *
 * @brief Generated from snakebot.dbc.
 *
 * @copyright Copyright (c) 2018-2019 Erik Moqvist
 *
 * @par License
 * The MIT License (MIT)
 *
 * Permission is hereby granted, free of charge, to any person
 * obtaining a copy of this software and associated documentation
 * files (the "Software"), to deal in the Software without
 * restriction, including without limitation the rights to use, copy,
 * modify, merge, publish, distribute, sublicense, and/or sell copies
 * of the Software, and to permit persons to whom the Software is
 * furnished to do so, subject to the following conditions:
 *
 * The above copyright notice and this permission notice shall be
 * included in all copies or substantial portions of the Software.
 *
 * THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND,
 * EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE WARRANTIES OF
 * MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND
 * NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR COPYRIGHT HOLDERS
 * BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN
 * ACTION OF CONTRACT, TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN
 * CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
 * SOFTWARE.
 */

#include <string.h>

#include "snakebot.h"

static inline uint8_t pack_left_shift_u8(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value << shift) & mask);
}

static inline uint8_t pack_left_shift_u16(
    uint16_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value << shift) & mask);
}

static inline uint8_t pack_left_shift_u32(
    uint32_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value << shift) & mask);
}

static inline uint8_t pack_left_shift_u64(
    uint64_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value << shift) & mask);
}

static inline uint8_t pack_right_shift_u8(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value >> shift) & mask);
}

static inline uint8_t pack_right_shift_u16(
    uint16_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value >> shift) & mask);
}

static inline uint8_t pack_right_shift_u32(
    uint32_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value >> shift) & mask);
}

static inline uint8_t pack_right_shift_u64(
    uint64_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value >> shift) & mask);
}

static inline uint8_t unpack_left_shift_u8(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value & mask) << shift);
}

static inline uint16_t unpack_left_shift_u16(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint16_t)((uint16_t)(value & mask) << shift);
}

static inline uint32_t unpack_left_shift_u32(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint32_t)((uint32_t)(value & mask) << shift);
}

static inline uint64_t unpack_left_shift_u64(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint64_t)((uint64_t)(value & mask) << shift);
}

static inline uint8_t unpack_right_shift_u8(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint8_t)((uint8_t)(value & mask) >> shift);
}

static inline uint16_t unpack_right_shift_u16(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint16_t)((uint16_t)(value & mask) >> shift);
}

static inline uint32_t unpack_right_shift_u32(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint32_t)((uint32_t)(value & mask) >> shift);
}

static inline uint64_t unpack_right_shift_u64(
    uint8_t value,
    uint8_t shift,
    uint8_t mask)
{
    return (uint64_t)((uint64_t)(value & mask) >> shift);
}

int snakebot_emergency_stop_pack(
    uint8_t *dst_p,
    const struct snakebot_emergency_stop_t *src_p,
    size_t size)
{
    if (size < 5u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 5);

    dst_p[0] |= pack_left_shift_u8(src_p->reason, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[2] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[4] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (5);
}

int snakebot_emergency_stop_unpack(
    struct snakebot_emergency_stop_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 5u) {
        return (-EINVAL);
    }

    dst_p->reason = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->host = unpack_right_shift_u32(src_p[1], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[2], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[3], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[4], 24u, 0xffu);

    return (0);
}

int snakebot_emergency_stop_init(struct snakebot_emergency_stop_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_emergency_stop_t));

    return 0;
}

bool snakebot_emergency_stop_reason_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_emergency_stop_reason_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_emergency_stop_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_emergency_stop_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_fault_event_pack(
    uint8_t *dst_p,
    const struct snakebot_fault_event_t *src_p,
    size_t size)
{
    uint16_t detail;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u8(src_p->code, 0u, 0x1fu);
    dst_p[0] |= pack_left_shift_u8(src_p->joint, 5u, 0xe0u);
    dst_p[1] |= pack_right_shift_u8(src_p->joint, 3u, 0x03u);
    dst_p[1] |= pack_left_shift_u8(src_p->number, 2u, 0xfcu);
    detail = (uint16_t)src_p->detail;
    dst_p[2] |= pack_left_shift_u16(detail, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(detail, 8u, 0xffu);
    dst_p[4] |= pack_left_shift_u32(src_p->board_time_us, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->board_time_us, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->board_time_us, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->board_time_us, 24u, 0xffu);

    return (8);
}

int snakebot_fault_event_unpack(
    struct snakebot_fault_event_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t detail;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->code = unpack_right_shift_u8(src_p[0], 0u, 0x1fu);
    dst_p->joint = unpack_right_shift_u8(src_p[0], 5u, 0xe0u);
    dst_p->joint |= unpack_left_shift_u8(src_p[1], 3u, 0x03u);
    dst_p->number = unpack_right_shift_u8(src_p[1], 2u, 0xfcu);
    detail = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    detail |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->detail = (int16_t)detail;
    dst_p->board_time_us = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_fault_event_init(struct snakebot_fault_event_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_fault_event_t));

    return 0;
}

bool snakebot_fault_event_code_is_in_range(uint8_t value)
{
    return (value <= 31u);
}

bool snakebot_fault_event_code_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 31.0));
}

bool snakebot_fault_event_joint_is_in_range(uint8_t value)
{
    return (value <= 16u);
}

bool snakebot_fault_event_joint_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 16.0));
}

bool snakebot_fault_event_number_is_in_range(uint8_t value)
{
    return (value <= 63u);
}

bool snakebot_fault_event_number_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 63.0));
}

bool snakebot_fault_event_detail_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_fault_event_detail_is_in_phys_range(double value)
{
    return ((value >= -32768.0) && (value <= 32767.0));
}

bool snakebot_fault_event_board_time_us_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_fault_event_board_time_us_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_setpoint_pack(
    uint8_t *dst_p,
    const struct snakebot_setpoint_t *src_p,
    size_t size)
{
    uint16_t first_rad;
    uint16_t second_rad;
    uint16_t third_rad;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->sequence, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->sequence, 8u, 0x0fu);
    dst_p[1] |= pack_left_shift_u8(src_p->group, 4u, 0xf0u);
    first_rad = (uint16_t)src_p->first_rad;
    dst_p[2] |= pack_left_shift_u16(first_rad, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(first_rad, 8u, 0xffu);
    second_rad = (uint16_t)src_p->second_rad;
    dst_p[4] |= pack_left_shift_u16(second_rad, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u16(second_rad, 8u, 0xffu);
    third_rad = (uint16_t)src_p->third_rad;
    dst_p[6] |= pack_left_shift_u16(third_rad, 0u, 0xffu);
    dst_p[7] |= pack_right_shift_u16(third_rad, 8u, 0xffu);

    return (8);
}

int snakebot_setpoint_unpack(
    struct snakebot_setpoint_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t first_rad;
    uint16_t second_rad;
    uint16_t third_rad;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->sequence = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->sequence |= unpack_left_shift_u16(src_p[1], 8u, 0x0fu);
    dst_p->group = unpack_right_shift_u8(src_p[1], 4u, 0xf0u);
    first_rad = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    first_rad |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->first_rad = (int16_t)first_rad;
    second_rad = unpack_right_shift_u16(src_p[4], 0u, 0xffu);
    second_rad |= unpack_left_shift_u16(src_p[5], 8u, 0xffu);
    dst_p->second_rad = (int16_t)second_rad;
    third_rad = unpack_right_shift_u16(src_p[6], 0u, 0xffu);
    third_rad |= unpack_left_shift_u16(src_p[7], 8u, 0xffu);
    dst_p->third_rad = (int16_t)third_rad;

    return (0);
}

int snakebot_setpoint_init(struct snakebot_setpoint_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_setpoint_t));

    return 0;
}

bool snakebot_setpoint_sequence_is_in_range(uint16_t value)
{
    return (value <= 4095u);
}

bool snakebot_setpoint_sequence_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4095.0));
}

bool snakebot_setpoint_group_is_in_range(uint8_t value)
{
    return (value <= 5u);
}

bool snakebot_setpoint_group_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 5.0));
}

bool snakebot_setpoint_first_rad_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_setpoint_first_rad_is_in_phys_range(double value)
{
    return ((value >= -3.2768) && (value <= 3.2767));
}

bool snakebot_setpoint_second_rad_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_setpoint_second_rad_is_in_phys_range(double value)
{
    return ((value >= -3.2768) && (value <= 3.2767));
}

bool snakebot_setpoint_third_rad_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_setpoint_third_rad_is_in_phys_range(double value)
{
    return ((value >= -3.2768) && (value <= 3.2767));
}

int snakebot_latch_pack(
    uint8_t *dst_p,
    const struct snakebot_latch_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->sequence, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->sequence, 8u, 0xffu);
    dst_p[2] |= pack_left_shift_u8(src_p->joints, 0u, 0xffu);
    dst_p[3] |= pack_left_shift_u8(src_p->interval_s, 0u, 0xffu);
    dst_p[4] |= pack_left_shift_u32(src_p->crc32, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->crc32, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->crc32, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->crc32, 24u, 0xffu);

    return (8);
}

int snakebot_latch_unpack(
    struct snakebot_latch_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->sequence = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->sequence |= unpack_left_shift_u16(src_p[1], 8u, 0xffu);
    dst_p->joints = unpack_right_shift_u8(src_p[2], 0u, 0xffu);
    dst_p->interval_s = unpack_right_shift_u8(src_p[3], 0u, 0xffu);
    dst_p->crc32 = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->crc32 |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->crc32 |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->crc32 |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_latch_init(struct snakebot_latch_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_latch_t));

    return 0;
}

bool snakebot_latch_sequence_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_latch_sequence_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

bool snakebot_latch_joints_is_in_range(uint8_t value)
{
    return ((value >= 1u) && (value <= 16u));
}

bool snakebot_latch_joints_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 16.0));
}

bool snakebot_latch_interval_s_is_in_range(uint8_t value)
{
    return (value >= 1u);
}

bool snakebot_latch_interval_s_is_in_phys_range(double value)
{
    return ((value >= 0.0005) && (value <= 0.1275));
}

bool snakebot_latch_crc32_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_latch_crc32_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_state_pack(
    uint8_t *dst_p,
    const struct snakebot_state_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->sequence, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->sequence, 8u, 0xffu);
    dst_p[2] |= pack_left_shift_u16(src_p->sample, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(src_p->sample, 8u, 0x0fu);
    dst_p[3] |= pack_left_shift_u8(src_p->mode, 4u, 0xf0u);
    dst_p[4] |= pack_left_shift_u32(src_p->board_time_us, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->board_time_us, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->board_time_us, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->board_time_us, 24u, 0xffu);

    return (8);
}

int snakebot_state_unpack(
    struct snakebot_state_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->sequence = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->sequence |= unpack_left_shift_u16(src_p[1], 8u, 0xffu);
    dst_p->sample = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    dst_p->sample |= unpack_left_shift_u16(src_p[3], 8u, 0x0fu);
    dst_p->mode = unpack_right_shift_u8(src_p[3], 4u, 0xf0u);
    dst_p->board_time_us = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_state_init(struct snakebot_state_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_state_t));

    return 0;
}

bool snakebot_state_sequence_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_state_sequence_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

bool snakebot_state_sample_is_in_range(uint16_t value)
{
    return (value <= 4095u);
}

bool snakebot_state_sample_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4095.0));
}

bool snakebot_state_mode_is_in_range(uint8_t value)
{
    return (value <= 15u);
}

bool snakebot_state_mode_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 15.0));
}

bool snakebot_state_board_time_us_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_state_board_time_us_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_measured_pack(
    uint8_t *dst_p,
    const struct snakebot_measured_t *src_p,
    size_t size)
{
    uint16_t first_counts;
    uint16_t second_counts;
    uint16_t third_counts;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->sample, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->sample, 8u, 0x0fu);
    dst_p[1] |= pack_left_shift_u8(src_p->group, 4u, 0xf0u);
    first_counts = (uint16_t)src_p->first_counts;
    dst_p[2] |= pack_left_shift_u16(first_counts, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(first_counts, 8u, 0xffu);
    second_counts = (uint16_t)src_p->second_counts;
    dst_p[4] |= pack_left_shift_u16(second_counts, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u16(second_counts, 8u, 0xffu);
    third_counts = (uint16_t)src_p->third_counts;
    dst_p[6] |= pack_left_shift_u16(third_counts, 0u, 0xffu);
    dst_p[7] |= pack_right_shift_u16(third_counts, 8u, 0xffu);

    return (8);
}

int snakebot_measured_unpack(
    struct snakebot_measured_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t first_counts;
    uint16_t second_counts;
    uint16_t third_counts;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->sample = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->sample |= unpack_left_shift_u16(src_p[1], 8u, 0x0fu);
    dst_p->group = unpack_right_shift_u8(src_p[1], 4u, 0xf0u);
    first_counts = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    first_counts |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->first_counts = (int16_t)first_counts;
    second_counts = unpack_right_shift_u16(src_p[4], 0u, 0xffu);
    second_counts |= unpack_left_shift_u16(src_p[5], 8u, 0xffu);
    dst_p->second_counts = (int16_t)second_counts;
    third_counts = unpack_right_shift_u16(src_p[6], 0u, 0xffu);
    third_counts |= unpack_left_shift_u16(src_p[7], 8u, 0xffu);
    dst_p->third_counts = (int16_t)third_counts;

    return (0);
}

int snakebot_measured_init(struct snakebot_measured_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_measured_t));

    return 0;
}

bool snakebot_measured_sample_is_in_range(uint16_t value)
{
    return (value <= 4095u);
}

bool snakebot_measured_sample_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4095.0));
}

bool snakebot_measured_group_is_in_range(uint8_t value)
{
    return (value <= 5u);
}

bool snakebot_measured_group_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 5.0));
}

bool snakebot_measured_first_counts_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_measured_first_counts_is_in_phys_range(double value)
{
    return ((value >= -32768.0) && (value <= 32767.0));
}

bool snakebot_measured_second_counts_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_measured_second_counts_is_in_phys_range(double value)
{
    return ((value >= -32768.0) && (value <= 32767.0));
}

bool snakebot_measured_third_counts_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_measured_third_counts_is_in_phys_range(double value)
{
    return ((value >= -32768.0) && (value <= 32767.0));
}

int snakebot_applied_pack(
    uint8_t *dst_p,
    const struct snakebot_applied_t *src_p,
    size_t size)
{
    uint16_t first_rad;
    uint16_t second_rad;
    uint16_t third_rad;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->sample, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->sample, 8u, 0x0fu);
    dst_p[1] |= pack_left_shift_u8(src_p->group, 4u, 0xf0u);
    first_rad = (uint16_t)src_p->first_rad;
    dst_p[2] |= pack_left_shift_u16(first_rad, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(first_rad, 8u, 0xffu);
    second_rad = (uint16_t)src_p->second_rad;
    dst_p[4] |= pack_left_shift_u16(second_rad, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u16(second_rad, 8u, 0xffu);
    third_rad = (uint16_t)src_p->third_rad;
    dst_p[6] |= pack_left_shift_u16(third_rad, 0u, 0xffu);
    dst_p[7] |= pack_right_shift_u16(third_rad, 8u, 0xffu);

    return (8);
}

int snakebot_applied_unpack(
    struct snakebot_applied_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t first_rad;
    uint16_t second_rad;
    uint16_t third_rad;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->sample = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->sample |= unpack_left_shift_u16(src_p[1], 8u, 0x0fu);
    dst_p->group = unpack_right_shift_u8(src_p[1], 4u, 0xf0u);
    first_rad = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    first_rad |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->first_rad = (int16_t)first_rad;
    second_rad = unpack_right_shift_u16(src_p[4], 0u, 0xffu);
    second_rad |= unpack_left_shift_u16(src_p[5], 8u, 0xffu);
    dst_p->second_rad = (int16_t)second_rad;
    third_rad = unpack_right_shift_u16(src_p[6], 0u, 0xffu);
    third_rad |= unpack_left_shift_u16(src_p[7], 8u, 0xffu);
    dst_p->third_rad = (int16_t)third_rad;

    return (0);
}

int snakebot_applied_init(struct snakebot_applied_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_applied_t));

    return 0;
}

bool snakebot_applied_sample_is_in_range(uint16_t value)
{
    return (value <= 4095u);
}

bool snakebot_applied_sample_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4095.0));
}

bool snakebot_applied_group_is_in_range(uint8_t value)
{
    return (value <= 5u);
}

bool snakebot_applied_group_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 5.0));
}

bool snakebot_applied_first_rad_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_applied_first_rad_is_in_phys_range(double value)
{
    return ((value >= -3.2768) && (value <= 3.2767));
}

bool snakebot_applied_second_rad_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_applied_second_rad_is_in_phys_range(double value)
{
    return ((value >= -3.2768) && (value <= 3.2767));
}

bool snakebot_applied_third_rad_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_applied_third_rad_is_in_phys_range(double value)
{
    return ((value >= -3.2768) && (value <= 3.2767));
}

int snakebot_host_heartbeat_pack(
    uint8_t *dst_p,
    const struct snakebot_host_heartbeat_t *src_p,
    size_t size)
{
    if (size < 6u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 6);

    dst_p[0] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[2] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);
    dst_p[4] |= pack_left_shift_u16(src_p->counter, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u16(src_p->counter, 8u, 0xffu);

    return (6);
}

int snakebot_host_heartbeat_unpack(
    struct snakebot_host_heartbeat_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 6u) {
        return (-EINVAL);
    }

    dst_p->host = unpack_right_shift_u32(src_p[0], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[1], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[2], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[3], 24u, 0xffu);
    dst_p->counter = unpack_right_shift_u16(src_p[4], 0u, 0xffu);
    dst_p->counter |= unpack_left_shift_u16(src_p[5], 8u, 0xffu);

    return (0);
}

int snakebot_host_heartbeat_init(struct snakebot_host_heartbeat_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_host_heartbeat_t));

    return 0;
}

bool snakebot_host_heartbeat_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_host_heartbeat_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

bool snakebot_host_heartbeat_counter_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_host_heartbeat_counter_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

int snakebot_board_heartbeat_pack(
    uint8_t *dst_p,
    const struct snakebot_board_heartbeat_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->boot_id, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->boot_id, 8u, 0xffu);
    dst_p[2] |= pack_left_shift_u8(src_p->mode, 0u, 0x0fu);
    dst_p[2] |= pack_left_shift_u8(src_p->powered, 4u, 0x10u);
    dst_p[2] |= pack_left_shift_u8(src_p->simulated, 5u, 0x20u);
    dst_p[3] |= pack_left_shift_u8(src_p->fault, 0u, 0xffu);
    dst_p[4] |= pack_left_shift_u32(src_p->holder, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->holder, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->holder, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->holder, 24u, 0xffu);

    return (8);
}

int snakebot_board_heartbeat_unpack(
    struct snakebot_board_heartbeat_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->boot_id = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->boot_id |= unpack_left_shift_u16(src_p[1], 8u, 0xffu);
    dst_p->mode = unpack_right_shift_u8(src_p[2], 0u, 0x0fu);
    dst_p->powered = unpack_right_shift_u8(src_p[2], 4u, 0x10u);
    dst_p->simulated = unpack_right_shift_u8(src_p[2], 5u, 0x20u);
    dst_p->fault = unpack_right_shift_u8(src_p[3], 0u, 0xffu);
    dst_p->holder = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->holder |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->holder |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->holder |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_board_heartbeat_init(struct snakebot_board_heartbeat_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_board_heartbeat_t));

    return 0;
}

bool snakebot_board_heartbeat_boot_id_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_board_heartbeat_boot_id_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

bool snakebot_board_heartbeat_mode_is_in_range(uint8_t value)
{
    return (value <= 15u);
}

bool snakebot_board_heartbeat_mode_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 15.0));
}

bool snakebot_board_heartbeat_powered_is_in_range(uint8_t value)
{
    return (value <= 1u);
}

bool snakebot_board_heartbeat_powered_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 1.0));
}

bool snakebot_board_heartbeat_simulated_is_in_range(uint8_t value)
{
    return (value <= 1u);
}

bool snakebot_board_heartbeat_simulated_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 1.0));
}

bool snakebot_board_heartbeat_fault_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_board_heartbeat_fault_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_board_heartbeat_holder_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_board_heartbeat_holder_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_mode_request_pack(
    uint8_t *dst_p,
    const struct snakebot_mode_request_t *src_p,
    size_t size)
{
    if (size < 6u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 6);

    dst_p[0] |= pack_left_shift_u8(src_p->token, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->mode, 0u, 0xffu);
    dst_p[2] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[4] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (6);
}

int snakebot_mode_request_unpack(
    struct snakebot_mode_request_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 6u) {
        return (-EINVAL);
    }

    dst_p->token = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->mode = unpack_right_shift_u8(src_p[1], 0u, 0xffu);
    dst_p->host = unpack_right_shift_u32(src_p[2], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[3], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[4], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[5], 24u, 0xffu);

    return (0);
}

int snakebot_mode_request_init(struct snakebot_mode_request_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_mode_request_t));

    return 0;
}

bool snakebot_mode_request_token_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_mode_request_token_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_mode_request_mode_is_in_range(uint8_t value)
{
    return (value <= 15u);
}

bool snakebot_mode_request_mode_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 15.0));
}

bool snakebot_mode_request_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_mode_request_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_joint_mode_request_pack(
    uint8_t *dst_p,
    const struct snakebot_joint_mode_request_t *src_p,
    size_t size)
{
    uint16_t angle_rad;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u8(src_p->token, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->joint, 0u, 0x1fu);
    dst_p[1] |= pack_left_shift_u8(src_p->mode, 5u, 0xe0u);
    angle_rad = (uint16_t)src_p->angle_rad;
    dst_p[2] |= pack_left_shift_u16(angle_rad, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(angle_rad, 8u, 0xffu);
    dst_p[4] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (8);
}

int snakebot_joint_mode_request_unpack(
    struct snakebot_joint_mode_request_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t angle_rad;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->token = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->joint = unpack_right_shift_u8(src_p[1], 0u, 0x1fu);
    dst_p->mode = unpack_right_shift_u8(src_p[1], 5u, 0xe0u);
    angle_rad = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    angle_rad |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->angle_rad = (int16_t)angle_rad;
    dst_p->host = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_joint_mode_request_init(struct snakebot_joint_mode_request_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_joint_mode_request_t));

    return 0;
}

bool snakebot_joint_mode_request_token_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_joint_mode_request_token_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_joint_mode_request_joint_is_in_range(uint8_t value)
{
    return ((value >= 1u) && (value <= 16u));
}

bool snakebot_joint_mode_request_joint_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 16.0));
}

bool snakebot_joint_mode_request_mode_is_in_range(uint8_t value)
{
    return (value <= 7u);
}

bool snakebot_joint_mode_request_mode_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 7.0));
}

bool snakebot_joint_mode_request_angle_rad_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_joint_mode_request_angle_rad_is_in_phys_range(double value)
{
    return ((value >= -3.2768) && (value <= 3.2767));
}

bool snakebot_joint_mode_request_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_joint_mode_request_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_limit_request_pack(
    uint8_t *dst_p,
    const struct snakebot_limit_request_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u8(src_p->token, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->joint, 0u, 0x1fu);
    dst_p[1] |= pack_left_shift_u8(src_p->kind, 5u, 0x60u);
    dst_p[1] |= pack_left_shift_u32(src_p->value, 7u, 0x80u);
    dst_p[2] |= pack_right_shift_u32(src_p->value, 1u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(src_p->value, 9u, 0xffu);
    dst_p[4] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (8);
}

int snakebot_limit_request_unpack(
    struct snakebot_limit_request_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->token = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->joint = unpack_right_shift_u8(src_p[1], 0u, 0x1fu);
    dst_p->kind = unpack_right_shift_u8(src_p[1], 5u, 0x60u);
    dst_p->value = unpack_right_shift_u32(src_p[1], 7u, 0x80u);
    dst_p->value |= unpack_left_shift_u32(src_p[2], 1u, 0xffu);
    dst_p->value |= unpack_left_shift_u32(src_p[3], 9u, 0xffu);
    dst_p->host = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_limit_request_init(struct snakebot_limit_request_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_limit_request_t));

    return 0;
}

bool snakebot_limit_request_token_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_limit_request_token_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_limit_request_joint_is_in_range(uint8_t value)
{
    return ((value >= 1u) && (value <= 16u));
}

bool snakebot_limit_request_joint_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 16.0));
}

bool snakebot_limit_request_kind_is_in_range(uint8_t value)
{
    return (value <= 3u);
}

bool snakebot_limit_request_kind_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 3.0));
}

bool snakebot_limit_request_value_is_in_range(uint32_t value)
{
    return (value <= 131071u);
}

bool snakebot_limit_request_value_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 262.142));
}

bool snakebot_limit_request_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_limit_request_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_trim_request_pack(
    uint8_t *dst_p,
    const struct snakebot_trim_request_t *src_p,
    size_t size)
{
    uint16_t trim_rad;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u8(src_p->token, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->joint, 0u, 0x1fu);
    trim_rad = (uint16_t)src_p->trim_rad;
    dst_p[2] |= pack_left_shift_u16(trim_rad, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(trim_rad, 8u, 0xffu);
    dst_p[4] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (8);
}

int snakebot_trim_request_unpack(
    struct snakebot_trim_request_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t trim_rad;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->token = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->joint = unpack_right_shift_u8(src_p[1], 0u, 0x1fu);
    trim_rad = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    trim_rad |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->trim_rad = (int16_t)trim_rad;
    dst_p->host = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_trim_request_init(struct snakebot_trim_request_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_trim_request_t));

    return 0;
}

bool snakebot_trim_request_token_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_trim_request_token_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_trim_request_joint_is_in_range(uint8_t value)
{
    return ((value >= 1u) && (value <= 16u));
}

bool snakebot_trim_request_joint_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 16.0));
}

bool snakebot_trim_request_trim_rad_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_trim_request_trim_rad_is_in_phys_range(double value)
{
    return ((value >= -3.2768) && (value <= 3.2767));
}

bool snakebot_trim_request_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_trim_request_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_zero_request_pack(
    uint8_t *dst_p,
    const struct snakebot_zero_request_t *src_p,
    size_t size)
{
    uint16_t zero_counts;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u8(src_p->token, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->joint, 0u, 0x1fu);
    zero_counts = (uint16_t)src_p->zero_counts;
    dst_p[2] |= pack_left_shift_u16(zero_counts, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(zero_counts, 8u, 0xffu);
    dst_p[4] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (8);
}

int snakebot_zero_request_unpack(
    struct snakebot_zero_request_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t zero_counts;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->token = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->joint = unpack_right_shift_u8(src_p[1], 0u, 0x1fu);
    zero_counts = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    zero_counts |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->zero_counts = (int16_t)zero_counts;
    dst_p->host = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_zero_request_init(struct snakebot_zero_request_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_zero_request_t));

    return 0;
}

bool snakebot_zero_request_token_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_zero_request_token_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_zero_request_joint_is_in_range(uint8_t value)
{
    return ((value >= 1u) && (value <= 16u));
}

bool snakebot_zero_request_joint_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 16.0));
}

bool snakebot_zero_request_zero_counts_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_zero_request_zero_counts_is_in_phys_range(double value)
{
    return ((value >= -32768.0) && (value <= 32767.0));
}

bool snakebot_zero_request_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_zero_request_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_clear_request_pack(
    uint8_t *dst_p,
    const struct snakebot_clear_request_t *src_p,
    size_t size)
{
    if (size < 6u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 6);

    dst_p[0] |= pack_left_shift_u8(src_p->token, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->number, 0u, 0x3fu);
    dst_p[2] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[4] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (6);
}

int snakebot_clear_request_unpack(
    struct snakebot_clear_request_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 6u) {
        return (-EINVAL);
    }

    dst_p->token = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->number = unpack_right_shift_u8(src_p[1], 0u, 0x3fu);
    dst_p->host = unpack_right_shift_u32(src_p[2], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[3], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[4], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[5], 24u, 0xffu);

    return (0);
}

int snakebot_clear_request_init(struct snakebot_clear_request_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_clear_request_t));

    return 0;
}

bool snakebot_clear_request_token_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_clear_request_token_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_clear_request_number_is_in_range(uint8_t value)
{
    return (value <= 63u);
}

bool snakebot_clear_request_number_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 63.0));
}

bool snakebot_clear_request_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_clear_request_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_joint_limits_pack(
    uint8_t *dst_p,
    const struct snakebot_joint_limits_t *src_p,
    size_t size)
{
    if (size < 7u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 7);

    dst_p[0] |= pack_left_shift_u8(src_p->joint, 0u, 0x1fu);
    dst_p[0] |= pack_left_shift_u32(src_p->angle_rad, 5u, 0xe0u);
    dst_p[1] |= pack_right_shift_u32(src_p->angle_rad, 3u, 0xffu);
    dst_p[2] |= pack_right_shift_u32(src_p->angle_rad, 11u, 0x3fu);
    dst_p[2] |= pack_left_shift_u32(src_p->speed_rad_s, 6u, 0xc0u);
    dst_p[3] |= pack_right_shift_u32(src_p->speed_rad_s, 2u, 0xffu);
    dst_p[4] |= pack_right_shift_u32(src_p->speed_rad_s, 10u, 0x7fu);
    dst_p[4] |= pack_left_shift_u32(src_p->acceleration_rad_s2, 7u, 0x80u);
    dst_p[5] |= pack_right_shift_u32(src_p->acceleration_rad_s2, 1u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->acceleration_rad_s2, 9u, 0xffu);

    return (7);
}

int snakebot_joint_limits_unpack(
    struct snakebot_joint_limits_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 7u) {
        return (-EINVAL);
    }

    dst_p->joint = unpack_right_shift_u8(src_p[0], 0u, 0x1fu);
    dst_p->angle_rad = unpack_right_shift_u32(src_p[0], 5u, 0xe0u);
    dst_p->angle_rad |= unpack_left_shift_u32(src_p[1], 3u, 0xffu);
    dst_p->angle_rad |= unpack_left_shift_u32(src_p[2], 11u, 0x3fu);
    dst_p->speed_rad_s = unpack_right_shift_u32(src_p[2], 6u, 0xc0u);
    dst_p->speed_rad_s |= unpack_left_shift_u32(src_p[3], 2u, 0xffu);
    dst_p->speed_rad_s |= unpack_left_shift_u32(src_p[4], 10u, 0x7fu);
    dst_p->acceleration_rad_s2 = unpack_right_shift_u32(src_p[4], 7u, 0x80u);
    dst_p->acceleration_rad_s2 |= unpack_left_shift_u32(src_p[5], 1u, 0xffu);
    dst_p->acceleration_rad_s2 |= unpack_left_shift_u32(src_p[6], 9u, 0xffu);

    return (0);
}

int snakebot_joint_limits_init(struct snakebot_joint_limits_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_joint_limits_t));

    return 0;
}

bool snakebot_joint_limits_joint_is_in_range(uint8_t value)
{
    return ((value >= 1u) && (value <= 16u));
}

bool snakebot_joint_limits_joint_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 16.0));
}

bool snakebot_joint_limits_angle_rad_is_in_range(uint32_t value)
{
    return (value <= 131071u);
}

bool snakebot_joint_limits_angle_rad_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 262.142));
}

bool snakebot_joint_limits_speed_rad_s_is_in_range(uint32_t value)
{
    return (value <= 131071u);
}

bool snakebot_joint_limits_speed_rad_s_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 262.142));
}

bool snakebot_joint_limits_acceleration_rad_s2_is_in_range(uint32_t value)
{
    return (value <= 131071u);
}

bool snakebot_joint_limits_acceleration_rad_s2_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 262.142));
}

int snakebot_acknowledge_pack(
    uint8_t *dst_p,
    const struct snakebot_acknowledge_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u8(src_p->token, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->result, 0u, 0x0fu);
    dst_p[1] |= pack_left_shift_u8(src_p->mode, 4u, 0xf0u);
    dst_p[2] |= pack_left_shift_u16(src_p->request, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(src_p->request, 8u, 0x07u);
    dst_p[3] |= pack_left_shift_u8(src_p->detail, 3u, 0xf8u);
    dst_p[4] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (8);
}

int snakebot_acknowledge_unpack(
    struct snakebot_acknowledge_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->token = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->result = unpack_right_shift_u8(src_p[1], 0u, 0x0fu);
    dst_p->mode = unpack_right_shift_u8(src_p[1], 4u, 0xf0u);
    dst_p->request = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    dst_p->request |= unpack_left_shift_u16(src_p[3], 8u, 0x07u);
    dst_p->detail = unpack_right_shift_u8(src_p[3], 3u, 0xf8u);
    dst_p->host = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_acknowledge_init(struct snakebot_acknowledge_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_acknowledge_t));

    return 0;
}

bool snakebot_acknowledge_token_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_acknowledge_token_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_acknowledge_result_is_in_range(uint8_t value)
{
    return (value <= 15u);
}

bool snakebot_acknowledge_result_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 15.0));
}

bool snakebot_acknowledge_mode_is_in_range(uint8_t value)
{
    return (value <= 15u);
}

bool snakebot_acknowledge_mode_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 15.0));
}

bool snakebot_acknowledge_request_is_in_range(uint16_t value)
{
    return (value <= 2047u);
}

bool snakebot_acknowledge_request_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 2047.0));
}

bool snakebot_acknowledge_detail_is_in_range(uint8_t value)
{
    return (value <= 31u);
}

bool snakebot_acknowledge_detail_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 31.0));
}

bool snakebot_acknowledge_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_acknowledge_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_ping_pack(
    uint8_t *dst_p,
    const struct snakebot_ping_t *src_p,
    size_t size)
{
    if (size < 4u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 4);

    dst_p[0] |= pack_left_shift_u32(src_p->nonce, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u32(src_p->nonce, 8u, 0xffu);
    dst_p[2] |= pack_right_shift_u32(src_p->nonce, 16u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(src_p->nonce, 24u, 0xffu);

    return (4);
}

int snakebot_ping_unpack(
    struct snakebot_ping_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 4u) {
        return (-EINVAL);
    }

    dst_p->nonce = unpack_right_shift_u32(src_p[0], 0u, 0xffu);
    dst_p->nonce |= unpack_left_shift_u32(src_p[1], 8u, 0xffu);
    dst_p->nonce |= unpack_left_shift_u32(src_p[2], 16u, 0xffu);
    dst_p->nonce |= unpack_left_shift_u32(src_p[3], 24u, 0xffu);

    return (0);
}

int snakebot_ping_init(struct snakebot_ping_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_ping_t));

    return 0;
}

bool snakebot_ping_nonce_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_ping_nonce_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_pong_pack(
    uint8_t *dst_p,
    const struct snakebot_pong_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u32(src_p->nonce, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u32(src_p->nonce, 8u, 0xffu);
    dst_p[2] |= pack_right_shift_u32(src_p->nonce, 16u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(src_p->nonce, 24u, 0xffu);
    dst_p[4] |= pack_left_shift_u32(src_p->board_time_us, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->board_time_us, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->board_time_us, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->board_time_us, 24u, 0xffu);

    return (8);
}

int snakebot_pong_unpack(
    struct snakebot_pong_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->nonce = unpack_right_shift_u32(src_p[0], 0u, 0xffu);
    dst_p->nonce |= unpack_left_shift_u32(src_p[1], 8u, 0xffu);
    dst_p->nonce |= unpack_left_shift_u32(src_p[2], 16u, 0xffu);
    dst_p->nonce |= unpack_left_shift_u32(src_p[3], 24u, 0xffu);
    dst_p->board_time_us = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->board_time_us |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_pong_init(struct snakebot_pong_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_pong_t));

    return 0;
}

bool snakebot_pong_nonce_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_pong_nonce_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

bool snakebot_pong_board_time_us_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_pong_board_time_us_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_info_request_pack(
    uint8_t *dst_p,
    const struct snakebot_info_request_t *src_p,
    size_t size)
{
    if (size < 4u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 4);

    dst_p[0] |= pack_left_shift_u32(src_p->host, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u32(src_p->host, 8u, 0xffu);
    dst_p[2] |= pack_right_shift_u32(src_p->host, 16u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(src_p->host, 24u, 0xffu);

    return (4);
}

int snakebot_info_request_unpack(
    struct snakebot_info_request_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 4u) {
        return (-EINVAL);
    }

    dst_p->host = unpack_right_shift_u32(src_p[0], 0u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[1], 8u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[2], 16u, 0xffu);
    dst_p->host |= unpack_left_shift_u32(src_p[3], 24u, 0xffu);

    return (0);
}

int snakebot_info_request_init(struct snakebot_info_request_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_info_request_t));

    return 0;
}

bool snakebot_info_request_host_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_request_host_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_info_protocol_pack(
    uint8_t *dst_p,
    const struct snakebot_info_protocol_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u8(src_p->protocol_major, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->protocol_minor, 0u, 0xffu);
    dst_p[2] |= pack_left_shift_u8(src_p->joints, 0u, 0xffu);
    dst_p[3] |= pack_left_shift_u8(src_p->simulated, 0u, 0x01u);
    dst_p[4] |= pack_left_shift_u32(src_p->catalogue_hash, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u32(src_p->catalogue_hash, 8u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(src_p->catalogue_hash, 16u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(src_p->catalogue_hash, 24u, 0xffu);

    return (8);
}

int snakebot_info_protocol_unpack(
    struct snakebot_info_protocol_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->protocol_major = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->protocol_minor = unpack_right_shift_u8(src_p[1], 0u, 0xffu);
    dst_p->joints = unpack_right_shift_u8(src_p[2], 0u, 0xffu);
    dst_p->simulated = unpack_right_shift_u8(src_p[3], 0u, 0x01u);
    dst_p->catalogue_hash = unpack_right_shift_u32(src_p[4], 0u, 0xffu);
    dst_p->catalogue_hash |= unpack_left_shift_u32(src_p[5], 8u, 0xffu);
    dst_p->catalogue_hash |= unpack_left_shift_u32(src_p[6], 16u, 0xffu);
    dst_p->catalogue_hash |= unpack_left_shift_u32(src_p[7], 24u, 0xffu);

    return (0);
}

int snakebot_info_protocol_init(struct snakebot_info_protocol_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_info_protocol_t));

    return 0;
}

bool snakebot_info_protocol_protocol_major_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_protocol_protocol_major_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_info_protocol_protocol_minor_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_protocol_protocol_minor_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_info_protocol_joints_is_in_range(uint8_t value)
{
    return ((value >= 1u) && (value <= 16u));
}

bool snakebot_info_protocol_joints_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 16.0));
}

bool snakebot_info_protocol_simulated_is_in_range(uint8_t value)
{
    return (value <= 1u);
}

bool snakebot_info_protocol_simulated_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 1.0));
}

bool snakebot_info_protocol_catalogue_hash_is_in_range(uint32_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_protocol_catalogue_hash_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4294967295.0));
}

int snakebot_info_firmware_pack(
    uint8_t *dst_p,
    const struct snakebot_info_firmware_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u8(src_p->firmware_major, 0u, 0xffu);
    dst_p[1] |= pack_left_shift_u8(src_p->firmware_minor, 0u, 0xffu);
    dst_p[2] |= pack_left_shift_u8(src_p->firmware_patch, 0u, 0xffu);
    dst_p[3] |= pack_left_shift_u8(src_p->watchdog_ms, 0u, 0xffu);
    dst_p[4] |= pack_left_shift_u16(src_p->counts_per_rev, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u16(src_p->counts_per_rev, 8u, 0xffu);
    dst_p[6] |= pack_left_shift_u16(src_p->boot_id, 0u, 0xffu);
    dst_p[7] |= pack_right_shift_u16(src_p->boot_id, 8u, 0xffu);

    return (8);
}

int snakebot_info_firmware_unpack(
    struct snakebot_info_firmware_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->firmware_major = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    dst_p->firmware_minor = unpack_right_shift_u8(src_p[1], 0u, 0xffu);
    dst_p->firmware_patch = unpack_right_shift_u8(src_p[2], 0u, 0xffu);
    dst_p->watchdog_ms = unpack_right_shift_u8(src_p[3], 0u, 0xffu);
    dst_p->counts_per_rev = unpack_right_shift_u16(src_p[4], 0u, 0xffu);
    dst_p->counts_per_rev |= unpack_left_shift_u16(src_p[5], 8u, 0xffu);
    dst_p->boot_id = unpack_right_shift_u16(src_p[6], 0u, 0xffu);
    dst_p->boot_id |= unpack_left_shift_u16(src_p[7], 8u, 0xffu);

    return (0);
}

int snakebot_info_firmware_init(struct snakebot_info_firmware_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_info_firmware_t));

    return 0;
}

bool snakebot_info_firmware_firmware_major_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_firmware_firmware_major_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_info_firmware_firmware_minor_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_firmware_firmware_minor_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_info_firmware_firmware_patch_is_in_range(uint8_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_firmware_firmware_patch_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 255.0));
}

bool snakebot_info_firmware_watchdog_ms_is_in_range(uint8_t value)
{
    return (value >= 1u);
}

bool snakebot_info_firmware_watchdog_ms_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 255.0));
}

bool snakebot_info_firmware_counts_per_rev_is_in_range(uint16_t value)
{
    return (value >= 16u);
}

bool snakebot_info_firmware_counts_per_rev_is_in_phys_range(double value)
{
    return ((value >= 16.0) && (value <= 65535.0));
}

bool snakebot_info_firmware_boot_id_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_firmware_boot_id_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

int snakebot_info_serial_pack(
    uint8_t *dst_p,
    const struct snakebot_info_serial_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u64(src_p->serial_number, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u64(src_p->serial_number, 8u, 0xffu);
    dst_p[2] |= pack_right_shift_u64(src_p->serial_number, 16u, 0xffu);
    dst_p[3] |= pack_right_shift_u64(src_p->serial_number, 24u, 0xffu);
    dst_p[4] |= pack_right_shift_u64(src_p->serial_number, 32u, 0xffu);
    dst_p[5] |= pack_right_shift_u64(src_p->serial_number, 40u, 0xffu);
    dst_p[6] |= pack_right_shift_u64(src_p->serial_number, 48u, 0xffu);
    dst_p[7] |= pack_right_shift_u64(src_p->serial_number, 56u, 0xffu);

    return (8);
}

int snakebot_info_serial_unpack(
    struct snakebot_info_serial_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->serial_number = unpack_right_shift_u64(src_p[0], 0u, 0xffu);
    dst_p->serial_number |= unpack_left_shift_u64(src_p[1], 8u, 0xffu);
    dst_p->serial_number |= unpack_left_shift_u64(src_p[2], 16u, 0xffu);
    dst_p->serial_number |= unpack_left_shift_u64(src_p[3], 24u, 0xffu);
    dst_p->serial_number |= unpack_left_shift_u64(src_p[4], 32u, 0xffu);
    dst_p->serial_number |= unpack_left_shift_u64(src_p[5], 40u, 0xffu);
    dst_p->serial_number |= unpack_left_shift_u64(src_p[6], 48u, 0xffu);
    dst_p->serial_number |= unpack_left_shift_u64(src_p[7], 56u, 0xffu);

    return (0);
}

int snakebot_info_serial_init(struct snakebot_info_serial_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_info_serial_t));

    return 0;
}

bool snakebot_info_serial_serial_number_is_in_range(uint64_t value)
{
    (void)value;

    return (true);
}

bool snakebot_info_serial_serial_number_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 1.8446744073709552e+19));
}

int snakebot_supply_pack(
    uint8_t *dst_p,
    const struct snakebot_supply_t *src_p,
    size_t size)
{
    uint16_t current_a;
    uint16_t temperature_c;

    if (size < 6u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 6);

    dst_p[0] |= pack_left_shift_u16(src_p->voltage_v, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->voltage_v, 8u, 0xffu);
    current_a = (uint16_t)src_p->current_a;
    dst_p[2] |= pack_left_shift_u16(current_a, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(current_a, 8u, 0xffu);
    temperature_c = (uint16_t)src_p->temperature_c;
    dst_p[4] |= pack_left_shift_u16(temperature_c, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u16(temperature_c, 8u, 0xffu);

    return (6);
}

int snakebot_supply_unpack(
    struct snakebot_supply_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t current_a;
    uint16_t temperature_c;

    if (size < 6u) {
        return (-EINVAL);
    }

    dst_p->voltage_v = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->voltage_v |= unpack_left_shift_u16(src_p[1], 8u, 0xffu);
    current_a = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    current_a |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->current_a = (int16_t)current_a;
    temperature_c = unpack_right_shift_u16(src_p[4], 0u, 0xffu);
    temperature_c |= unpack_left_shift_u16(src_p[5], 8u, 0xffu);
    dst_p->temperature_c = (int16_t)temperature_c;

    return (0);
}

int snakebot_supply_init(struct snakebot_supply_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_supply_t));

    return 0;
}

bool snakebot_supply_voltage_v_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_supply_voltage_v_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65.535));
}

bool snakebot_supply_current_a_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_supply_current_a_is_in_phys_range(double value)
{
    return ((value >= -32.768) && (value <= 32.767));
}

bool snakebot_supply_temperature_c_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_supply_temperature_c_is_in_phys_range(double value)
{
    return ((value >= -3276.8) && (value <= 3276.7));
}

int snakebot_joint_supply_pack(
    uint8_t *dst_p,
    const struct snakebot_joint_supply_t *src_p,
    size_t size)
{
    uint16_t current_a;
    uint16_t temperature_c;

    if (size < 6u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 6);

    dst_p[0] |= pack_left_shift_u8(src_p->joint, 0u, 0xffu);
    current_a = (uint16_t)src_p->current_a;
    dst_p[2] |= pack_left_shift_u16(current_a, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(current_a, 8u, 0xffu);
    temperature_c = (uint16_t)src_p->temperature_c;
    dst_p[4] |= pack_left_shift_u16(temperature_c, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u16(temperature_c, 8u, 0xffu);

    return (6);
}

int snakebot_joint_supply_unpack(
    struct snakebot_joint_supply_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint16_t current_a;
    uint16_t temperature_c;

    if (size < 6u) {
        return (-EINVAL);
    }

    dst_p->joint = unpack_right_shift_u8(src_p[0], 0u, 0xffu);
    current_a = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    current_a |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->current_a = (int16_t)current_a;
    temperature_c = unpack_right_shift_u16(src_p[4], 0u, 0xffu);
    temperature_c |= unpack_left_shift_u16(src_p[5], 8u, 0xffu);
    dst_p->temperature_c = (int16_t)temperature_c;

    return (0);
}

int snakebot_joint_supply_init(struct snakebot_joint_supply_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_joint_supply_t));

    return 0;
}

bool snakebot_joint_supply_joint_is_in_range(uint8_t value)
{
    return ((value >= 1u) && (value <= 16u));
}

bool snakebot_joint_supply_joint_is_in_phys_range(double value)
{
    return ((value >= 1.0) && (value <= 16.0));
}

bool snakebot_joint_supply_current_a_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_joint_supply_current_a_is_in_phys_range(double value)
{
    return ((value >= -32.768) && (value <= 32.767));
}

bool snakebot_joint_supply_temperature_c_is_in_range(int16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_joint_supply_temperature_c_is_in_phys_range(double value)
{
    return ((value >= -3276.8) && (value <= 3276.7));
}

int snakebot_counters_pack(
    uint8_t *dst_p,
    const struct snakebot_counters_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->received, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->received, 8u, 0xffu);
    dst_p[2] |= pack_left_shift_u16(src_p->corrupt, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u16(src_p->corrupt, 8u, 0xffu);
    dst_p[4] |= pack_left_shift_u16(src_p->dropped, 0u, 0xffu);
    dst_p[5] |= pack_right_shift_u16(src_p->dropped, 8u, 0xffu);
    dst_p[6] |= pack_left_shift_u16(src_p->clamped, 0u, 0xffu);
    dst_p[7] |= pack_right_shift_u16(src_p->clamped, 8u, 0xffu);

    return (8);
}

int snakebot_counters_unpack(
    struct snakebot_counters_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->received = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->received |= unpack_left_shift_u16(src_p[1], 8u, 0xffu);
    dst_p->corrupt = unpack_right_shift_u16(src_p[2], 0u, 0xffu);
    dst_p->corrupt |= unpack_left_shift_u16(src_p[3], 8u, 0xffu);
    dst_p->dropped = unpack_right_shift_u16(src_p[4], 0u, 0xffu);
    dst_p->dropped |= unpack_left_shift_u16(src_p[5], 8u, 0xffu);
    dst_p->clamped = unpack_right_shift_u16(src_p[6], 0u, 0xffu);
    dst_p->clamped |= unpack_left_shift_u16(src_p[7], 8u, 0xffu);

    return (0);
}

int snakebot_counters_init(struct snakebot_counters_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_counters_t));

    return 0;
}

bool snakebot_counters_received_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_counters_received_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

bool snakebot_counters_corrupt_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_counters_corrupt_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

bool snakebot_counters_dropped_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_counters_dropped_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

bool snakebot_counters_clamped_is_in_range(uint16_t value)
{
    (void)value;

    return (true);
}

bool snakebot_counters_clamped_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 65535.0));
}

int snakebot_pose_position_pack(
    uint8_t *dst_p,
    const struct snakebot_pose_position_t *src_p,
    size_t size)
{
    uint32_t x_m;
    uint32_t y_m;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->sample, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->sample, 8u, 0x0fu);
    x_m = (uint32_t)src_p->x_m;
    dst_p[2] |= pack_left_shift_u32(x_m, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(x_m, 8u, 0xffu);
    dst_p[4] |= pack_right_shift_u32(x_m, 16u, 0xffu);
    y_m = (uint32_t)src_p->y_m;
    dst_p[5] |= pack_left_shift_u32(y_m, 0u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(y_m, 8u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(y_m, 16u, 0xffu);

    return (8);
}

int snakebot_pose_position_unpack(
    struct snakebot_pose_position_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint32_t x_m;
    uint32_t y_m;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->sample = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->sample |= unpack_left_shift_u16(src_p[1], 8u, 0x0fu);
    x_m = unpack_right_shift_u32(src_p[2], 0u, 0xffu);
    x_m |= unpack_left_shift_u32(src_p[3], 8u, 0xffu);
    x_m |= unpack_left_shift_u32(src_p[4], 16u, 0xffu);

    if ((x_m & (1u << 23)) != 0u) {
        x_m |= 0xff000000u;
    }

    dst_p->x_m = (int32_t)x_m;
    y_m = unpack_right_shift_u32(src_p[5], 0u, 0xffu);
    y_m |= unpack_left_shift_u32(src_p[6], 8u, 0xffu);
    y_m |= unpack_left_shift_u32(src_p[7], 16u, 0xffu);

    if ((y_m & (1u << 23)) != 0u) {
        y_m |= 0xff000000u;
    }

    dst_p->y_m = (int32_t)y_m;

    return (0);
}

int snakebot_pose_position_init(struct snakebot_pose_position_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_pose_position_t));

    return 0;
}

bool snakebot_pose_position_sample_is_in_range(uint16_t value)
{
    return (value <= 4095u);
}

bool snakebot_pose_position_sample_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4095.0));
}

bool snakebot_pose_position_x_m_is_in_range(int32_t value)
{
    return ((value >= -8388608) && (value <= 8388607));
}

bool snakebot_pose_position_x_m_is_in_phys_range(double value)
{
    return ((value >= -838.8608) && (value <= 838.8607));
}

bool snakebot_pose_position_y_m_is_in_range(int32_t value)
{
    return ((value >= -8388608) && (value <= 8388607));
}

bool snakebot_pose_position_y_m_is_in_phys_range(double value)
{
    return ((value >= -838.8608) && (value <= 838.8607));
}

int snakebot_pose_motion_pack(
    uint8_t *dst_p,
    const struct snakebot_pose_motion_t *src_p,
    size_t size)
{
    uint32_t heading_rad;
    uint32_t speed_m_s;

    if (size < 8u) {
        return (-EINVAL);
    }

    memset(&dst_p[0], 0, 8);

    dst_p[0] |= pack_left_shift_u16(src_p->sample, 0u, 0xffu);
    dst_p[1] |= pack_right_shift_u16(src_p->sample, 8u, 0x0fu);
    heading_rad = (uint32_t)src_p->heading_rad;
    dst_p[2] |= pack_left_shift_u32(heading_rad, 0u, 0xffu);
    dst_p[3] |= pack_right_shift_u32(heading_rad, 8u, 0xffu);
    dst_p[4] |= pack_right_shift_u32(heading_rad, 16u, 0xffu);
    speed_m_s = (uint32_t)src_p->speed_m_s;
    dst_p[5] |= pack_left_shift_u32(speed_m_s, 0u, 0xffu);
    dst_p[6] |= pack_right_shift_u32(speed_m_s, 8u, 0xffu);
    dst_p[7] |= pack_right_shift_u32(speed_m_s, 16u, 0xffu);

    return (8);
}

int snakebot_pose_motion_unpack(
    struct snakebot_pose_motion_t *dst_p,
    const uint8_t *src_p,
    size_t size)
{
    uint32_t heading_rad;
    uint32_t speed_m_s;

    if (size < 8u) {
        return (-EINVAL);
    }

    dst_p->sample = unpack_right_shift_u16(src_p[0], 0u, 0xffu);
    dst_p->sample |= unpack_left_shift_u16(src_p[1], 8u, 0x0fu);
    heading_rad = unpack_right_shift_u32(src_p[2], 0u, 0xffu);
    heading_rad |= unpack_left_shift_u32(src_p[3], 8u, 0xffu);
    heading_rad |= unpack_left_shift_u32(src_p[4], 16u, 0xffu);

    if ((heading_rad & (1u << 23)) != 0u) {
        heading_rad |= 0xff000000u;
    }

    dst_p->heading_rad = (int32_t)heading_rad;
    speed_m_s = unpack_right_shift_u32(src_p[5], 0u, 0xffu);
    speed_m_s |= unpack_left_shift_u32(src_p[6], 8u, 0xffu);
    speed_m_s |= unpack_left_shift_u32(src_p[7], 16u, 0xffu);

    if ((speed_m_s & (1u << 23)) != 0u) {
        speed_m_s |= 0xff000000u;
    }

    dst_p->speed_m_s = (int32_t)speed_m_s;

    return (0);
}

int snakebot_pose_motion_init(struct snakebot_pose_motion_t *msg_p)
{
    if (msg_p == NULL) return -1;

    memset(msg_p, 0, sizeof(struct snakebot_pose_motion_t));

    return 0;
}

bool snakebot_pose_motion_sample_is_in_range(uint16_t value)
{
    return (value <= 4095u);
}

bool snakebot_pose_motion_sample_is_in_phys_range(double value)
{
    return ((value >= 0.0) && (value <= 4095.0));
}

bool snakebot_pose_motion_heading_rad_is_in_range(int32_t value)
{
    return ((value >= -8388608) && (value <= 8388607));
}

bool snakebot_pose_motion_heading_rad_is_in_phys_range(double value)
{
    return ((value >= -83.88608) && (value <= 83.88607));
}

bool snakebot_pose_motion_speed_m_s_is_in_range(int32_t value)
{
    return ((value >= -8388608) && (value <= 8388607));
}

bool snakebot_pose_motion_speed_m_s_is_in_phys_range(double value)
{
    return ((value >= -83.88608) && (value <= 83.88607));
}
