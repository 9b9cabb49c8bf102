/**
 * @file snakebot.h
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

#ifndef SNAKEBOT_H
#define SNAKEBOT_H

#ifdef __cplusplus
extern "C" {
#endif

#include <stdint.h>
#include <stdbool.h>
#include <stddef.h>

#ifndef EINVAL
#    define EINVAL 22
#endif

/* Frame ids. */
#define SNAKEBOT_EMERGENCY_STOP_FRAME_ID (0x01u)
#define SNAKEBOT_FAULT_EVENT_FRAME_ID (0x02u)
#define SNAKEBOT_SETPOINT_FRAME_ID (0x10u)
#define SNAKEBOT_LATCH_FRAME_ID (0x11u)
#define SNAKEBOT_STATE_FRAME_ID (0x20u)
#define SNAKEBOT_MEASURED_FRAME_ID (0x21u)
#define SNAKEBOT_APPLIED_FRAME_ID (0x22u)
#define SNAKEBOT_HOST_HEARTBEAT_FRAME_ID (0x30u)
#define SNAKEBOT_BOARD_HEARTBEAT_FRAME_ID (0x31u)
#define SNAKEBOT_MODE_REQUEST_FRAME_ID (0x40u)
#define SNAKEBOT_JOINT_MODE_REQUEST_FRAME_ID (0x41u)
#define SNAKEBOT_LIMIT_REQUEST_FRAME_ID (0x42u)
#define SNAKEBOT_TRIM_REQUEST_FRAME_ID (0x43u)
#define SNAKEBOT_ZERO_REQUEST_FRAME_ID (0x44u)
#define SNAKEBOT_CLEAR_REQUEST_FRAME_ID (0x45u)
#define SNAKEBOT_JOINT_LIMITS_FRAME_ID (0x4eu)
#define SNAKEBOT_ACKNOWLEDGE_FRAME_ID (0x4fu)
#define SNAKEBOT_PING_FRAME_ID (0x50u)
#define SNAKEBOT_PONG_FRAME_ID (0x51u)
#define SNAKEBOT_INFO_REQUEST_FRAME_ID (0x58u)
#define SNAKEBOT_INFO_PROTOCOL_FRAME_ID (0x59u)
#define SNAKEBOT_INFO_FIRMWARE_FRAME_ID (0x5au)
#define SNAKEBOT_INFO_SERIAL_FRAME_ID (0x5bu)
#define SNAKEBOT_SUPPLY_FRAME_ID (0x60u)
#define SNAKEBOT_JOINT_SUPPLY_FRAME_ID (0x61u)
#define SNAKEBOT_COUNTERS_FRAME_ID (0x68u)
#define SNAKEBOT_POSE_POSITION_FRAME_ID (0x70u)
#define SNAKEBOT_POSE_MOTION_FRAME_ID (0x71u)

/* Frame lengths in bytes. */
#define SNAKEBOT_EMERGENCY_STOP_LENGTH (5u)
#define SNAKEBOT_FAULT_EVENT_LENGTH (8u)
#define SNAKEBOT_SETPOINT_LENGTH (8u)
#define SNAKEBOT_LATCH_LENGTH (8u)
#define SNAKEBOT_STATE_LENGTH (8u)
#define SNAKEBOT_MEASURED_LENGTH (8u)
#define SNAKEBOT_APPLIED_LENGTH (8u)
#define SNAKEBOT_HOST_HEARTBEAT_LENGTH (6u)
#define SNAKEBOT_BOARD_HEARTBEAT_LENGTH (8u)
#define SNAKEBOT_MODE_REQUEST_LENGTH (6u)
#define SNAKEBOT_JOINT_MODE_REQUEST_LENGTH (8u)
#define SNAKEBOT_LIMIT_REQUEST_LENGTH (8u)
#define SNAKEBOT_TRIM_REQUEST_LENGTH (8u)
#define SNAKEBOT_ZERO_REQUEST_LENGTH (8u)
#define SNAKEBOT_CLEAR_REQUEST_LENGTH (6u)
#define SNAKEBOT_JOINT_LIMITS_LENGTH (7u)
#define SNAKEBOT_ACKNOWLEDGE_LENGTH (8u)
#define SNAKEBOT_PING_LENGTH (4u)
#define SNAKEBOT_PONG_LENGTH (8u)
#define SNAKEBOT_INFO_REQUEST_LENGTH (4u)
#define SNAKEBOT_INFO_PROTOCOL_LENGTH (8u)
#define SNAKEBOT_INFO_FIRMWARE_LENGTH (8u)
#define SNAKEBOT_INFO_SERIAL_LENGTH (8u)
#define SNAKEBOT_SUPPLY_LENGTH (6u)
#define SNAKEBOT_JOINT_SUPPLY_LENGTH (6u)
#define SNAKEBOT_COUNTERS_LENGTH (8u)
#define SNAKEBOT_POSE_POSITION_LENGTH (8u)
#define SNAKEBOT_POSE_MOTION_LENGTH (8u)

/* Extended or standard frame types. */
#define SNAKEBOT_EMERGENCY_STOP_IS_EXTENDED (0)
#define SNAKEBOT_FAULT_EVENT_IS_EXTENDED (0)
#define SNAKEBOT_SETPOINT_IS_EXTENDED (0)
#define SNAKEBOT_LATCH_IS_EXTENDED (0)
#define SNAKEBOT_STATE_IS_EXTENDED (0)
#define SNAKEBOT_MEASURED_IS_EXTENDED (0)
#define SNAKEBOT_APPLIED_IS_EXTENDED (0)
#define SNAKEBOT_HOST_HEARTBEAT_IS_EXTENDED (0)
#define SNAKEBOT_BOARD_HEARTBEAT_IS_EXTENDED (0)
#define SNAKEBOT_MODE_REQUEST_IS_EXTENDED (0)
#define SNAKEBOT_JOINT_MODE_REQUEST_IS_EXTENDED (0)
#define SNAKEBOT_LIMIT_REQUEST_IS_EXTENDED (0)
#define SNAKEBOT_TRIM_REQUEST_IS_EXTENDED (0)
#define SNAKEBOT_ZERO_REQUEST_IS_EXTENDED (0)
#define SNAKEBOT_CLEAR_REQUEST_IS_EXTENDED (0)
#define SNAKEBOT_JOINT_LIMITS_IS_EXTENDED (0)
#define SNAKEBOT_ACKNOWLEDGE_IS_EXTENDED (0)
#define SNAKEBOT_PING_IS_EXTENDED (0)
#define SNAKEBOT_PONG_IS_EXTENDED (0)
#define SNAKEBOT_INFO_REQUEST_IS_EXTENDED (0)
#define SNAKEBOT_INFO_PROTOCOL_IS_EXTENDED (0)
#define SNAKEBOT_INFO_FIRMWARE_IS_EXTENDED (0)
#define SNAKEBOT_INFO_SERIAL_IS_EXTENDED (0)
#define SNAKEBOT_SUPPLY_IS_EXTENDED (0)
#define SNAKEBOT_JOINT_SUPPLY_IS_EXTENDED (0)
#define SNAKEBOT_COUNTERS_IS_EXTENDED (0)
#define SNAKEBOT_POSE_POSITION_IS_EXTENDED (0)
#define SNAKEBOT_POSE_MOTION_IS_EXTENDED (0)

/* Frame cycle times in milliseconds. */


/* Signal choices. */
#define SNAKEBOT_EMERGENCY_STOP_REASON_USER_CHOICE (0u)
#define SNAKEBOT_EMERGENCY_STOP_REASON_LATE_CHOICE (1u)
#define SNAKEBOT_EMERGENCY_STOP_REASON_EXCEPTION_CHOICE (2u)
#define SNAKEBOT_EMERGENCY_STOP_REASON_EXTERNAL_CHOICE (3u)

#define SNAKEBOT_FAULT_EVENT_CODE_NONE_CHOICE (0u)
#define SNAKEBOT_FAULT_EVENT_CODE_WATCHDOG_CHOICE (1u)
#define SNAKEBOT_FAULT_EVENT_CODE_EMERGENCY_STOP_CHOICE (2u)
#define SNAKEBOT_FAULT_EVENT_CODE_SERVO_CHOICE (3u)
#define SNAKEBOT_FAULT_EVENT_CODE_UNDERVOLTAGE_CHOICE (4u)
#define SNAKEBOT_FAULT_EVENT_CODE_OVERCURRENT_CHOICE (5u)
#define SNAKEBOT_FAULT_EVENT_CODE_OVERTEMPERATURE_CHOICE (6u)
#define SNAKEBOT_FAULT_EVENT_CODE_ENCODER_CHOICE (7u)
#define SNAKEBOT_FAULT_EVENT_CODE_INTERNAL_CHOICE (8u)

#define SNAKEBOT_STATE_MODE_DISARMED_CHOICE (0u)
#define SNAKEBOT_STATE_MODE_ARMED_CHOICE (1u)
#define SNAKEBOT_STATE_MODE_HOLDING_CHOICE (2u)
#define SNAKEBOT_STATE_MODE_STOPPED_CHOICE (3u)
#define SNAKEBOT_STATE_MODE_FAULT_CHOICE (4u)

#define SNAKEBOT_BOARD_HEARTBEAT_MODE_DISARMED_CHOICE (0u)
#define SNAKEBOT_BOARD_HEARTBEAT_MODE_ARMED_CHOICE (1u)
#define SNAKEBOT_BOARD_HEARTBEAT_MODE_HOLDING_CHOICE (2u)
#define SNAKEBOT_BOARD_HEARTBEAT_MODE_STOPPED_CHOICE (3u)
#define SNAKEBOT_BOARD_HEARTBEAT_MODE_FAULT_CHOICE (4u)

#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_NONE_CHOICE (0u)
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_WATCHDOG_CHOICE (1u)
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_EMERGENCY_STOP_CHOICE (2u)
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_SERVO_CHOICE (3u)
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_UNDERVOLTAGE_CHOICE (4u)
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_OVERCURRENT_CHOICE (5u)
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_OVERTEMPERATURE_CHOICE (6u)
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_ENCODER_CHOICE (7u)
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_INTERNAL_CHOICE (8u)

#define SNAKEBOT_MODE_REQUEST_MODE_DISARMED_CHOICE (0u)
#define SNAKEBOT_MODE_REQUEST_MODE_ARMED_CHOICE (1u)
#define SNAKEBOT_MODE_REQUEST_MODE_HOLDING_CHOICE (2u)
#define SNAKEBOT_MODE_REQUEST_MODE_STOPPED_CHOICE (3u)
#define SNAKEBOT_MODE_REQUEST_MODE_FAULT_CHOICE (4u)

#define SNAKEBOT_JOINT_MODE_REQUEST_MODE_ACTIVE_CHOICE (0u)
#define SNAKEBOT_JOINT_MODE_REQUEST_MODE_FREE_CHOICE (1u)
#define SNAKEBOT_JOINT_MODE_REQUEST_MODE_RIGID_CHOICE (2u)
#define SNAKEBOT_JOINT_MODE_REQUEST_MODE_RIGID_HERE_CHOICE (3u)

#define SNAKEBOT_LIMIT_REQUEST_KIND_ANGLE_CHOICE (0u)
#define SNAKEBOT_LIMIT_REQUEST_KIND_SPEED_CHOICE (1u)
#define SNAKEBOT_LIMIT_REQUEST_KIND_ACCELERATION_CHOICE (2u)

#define SNAKEBOT_ACKNOWLEDGE_RESULT_OK_CHOICE (0u)
#define SNAKEBOT_ACKNOWLEDGE_RESULT_BAD_VALUE_CHOICE (1u)
#define SNAKEBOT_ACKNOWLEDGE_RESULT_BAD_JOINT_CHOICE (2u)
#define SNAKEBOT_ACKNOWLEDGE_RESULT_FORBIDDEN_CHOICE (3u)
#define SNAKEBOT_ACKNOWLEDGE_RESULT_HELD_CHOICE (4u)
#define SNAKEBOT_ACKNOWLEDGE_RESULT_UNSUPPORTED_CHOICE (5u)
#define SNAKEBOT_ACKNOWLEDGE_RESULT_FAULTY_CHOICE (6u)

#define SNAKEBOT_ACKNOWLEDGE_MODE_DISARMED_CHOICE (0u)
#define SNAKEBOT_ACKNOWLEDGE_MODE_ARMED_CHOICE (1u)
#define SNAKEBOT_ACKNOWLEDGE_MODE_HOLDING_CHOICE (2u)
#define SNAKEBOT_ACKNOWLEDGE_MODE_STOPPED_CHOICE (3u)
#define SNAKEBOT_ACKNOWLEDGE_MODE_FAULT_CHOICE (4u)

/* Frame Names. */
#define SNAKEBOT_EMERGENCY_STOP_NAME "EmergencyStop"
#define SNAKEBOT_FAULT_EVENT_NAME "FaultEvent"
#define SNAKEBOT_SETPOINT_NAME "Setpoint"
#define SNAKEBOT_LATCH_NAME "Latch"
#define SNAKEBOT_STATE_NAME "State"
#define SNAKEBOT_MEASURED_NAME "Measured"
#define SNAKEBOT_APPLIED_NAME "Applied"
#define SNAKEBOT_HOST_HEARTBEAT_NAME "HostHeartbeat"
#define SNAKEBOT_BOARD_HEARTBEAT_NAME "BoardHeartbeat"
#define SNAKEBOT_MODE_REQUEST_NAME "ModeRequest"
#define SNAKEBOT_JOINT_MODE_REQUEST_NAME "JointModeRequest"
#define SNAKEBOT_LIMIT_REQUEST_NAME "LimitRequest"
#define SNAKEBOT_TRIM_REQUEST_NAME "TrimRequest"
#define SNAKEBOT_ZERO_REQUEST_NAME "ZeroRequest"
#define SNAKEBOT_CLEAR_REQUEST_NAME "ClearRequest"
#define SNAKEBOT_JOINT_LIMITS_NAME "JointLimits"
#define SNAKEBOT_ACKNOWLEDGE_NAME "Acknowledge"
#define SNAKEBOT_PING_NAME "Ping"
#define SNAKEBOT_PONG_NAME "Pong"
#define SNAKEBOT_INFO_REQUEST_NAME "InfoRequest"
#define SNAKEBOT_INFO_PROTOCOL_NAME "InfoProtocol"
#define SNAKEBOT_INFO_FIRMWARE_NAME "InfoFirmware"
#define SNAKEBOT_INFO_SERIAL_NAME "InfoSerial"
#define SNAKEBOT_SUPPLY_NAME "Supply"
#define SNAKEBOT_JOINT_SUPPLY_NAME "JointSupply"
#define SNAKEBOT_COUNTERS_NAME "Counters"
#define SNAKEBOT_POSE_POSITION_NAME "PosePosition"
#define SNAKEBOT_POSE_MOTION_NAME "PoseMotion"

/* Signal Names. */
#define SNAKEBOT_EMERGENCY_STOP_REASON_NAME "reason"
#define SNAKEBOT_EMERGENCY_STOP_HOST_NAME "host"
#define SNAKEBOT_FAULT_EVENT_CODE_NAME "code"
#define SNAKEBOT_FAULT_EVENT_JOINT_NAME "joint"
#define SNAKEBOT_FAULT_EVENT_NUMBER_NAME "number"
#define SNAKEBOT_FAULT_EVENT_DETAIL_NAME "detail"
#define SNAKEBOT_FAULT_EVENT_BOARD_TIME_US_NAME "board_time_us"
#define SNAKEBOT_SETPOINT_SEQUENCE_NAME "sequence"
#define SNAKEBOT_SETPOINT_GROUP_NAME "group"
#define SNAKEBOT_SETPOINT_FIRST_RAD_NAME "first_rad"
#define SNAKEBOT_SETPOINT_SECOND_RAD_NAME "second_rad"
#define SNAKEBOT_SETPOINT_THIRD_RAD_NAME "third_rad"
#define SNAKEBOT_LATCH_SEQUENCE_NAME "sequence"
#define SNAKEBOT_LATCH_JOINTS_NAME "joints"
#define SNAKEBOT_LATCH_INTERVAL_S_NAME "interval_s"
#define SNAKEBOT_LATCH_CRC32_NAME "crc32"
#define SNAKEBOT_STATE_SEQUENCE_NAME "sequence"
#define SNAKEBOT_STATE_SAMPLE_NAME "sample"
#define SNAKEBOT_STATE_MODE_NAME "mode"
#define SNAKEBOT_STATE_BOARD_TIME_US_NAME "board_time_us"
#define SNAKEBOT_MEASURED_SAMPLE_NAME "sample"
#define SNAKEBOT_MEASURED_GROUP_NAME "group"
#define SNAKEBOT_MEASURED_FIRST_COUNTS_NAME "first_counts"
#define SNAKEBOT_MEASURED_SECOND_COUNTS_NAME "second_counts"
#define SNAKEBOT_MEASURED_THIRD_COUNTS_NAME "third_counts"
#define SNAKEBOT_APPLIED_SAMPLE_NAME "sample"
#define SNAKEBOT_APPLIED_GROUP_NAME "group"
#define SNAKEBOT_APPLIED_FIRST_RAD_NAME "first_rad"
#define SNAKEBOT_APPLIED_SECOND_RAD_NAME "second_rad"
#define SNAKEBOT_APPLIED_THIRD_RAD_NAME "third_rad"
#define SNAKEBOT_HOST_HEARTBEAT_HOST_NAME "host"
#define SNAKEBOT_HOST_HEARTBEAT_COUNTER_NAME "counter"
#define SNAKEBOT_BOARD_HEARTBEAT_BOOT_ID_NAME "boot_id"
#define SNAKEBOT_BOARD_HEARTBEAT_MODE_NAME "mode"
#define SNAKEBOT_BOARD_HEARTBEAT_POWERED_NAME "powered"
#define SNAKEBOT_BOARD_HEARTBEAT_SIMULATED_NAME "simulated"
#define SNAKEBOT_BOARD_HEARTBEAT_FAULT_NAME "fault"
#define SNAKEBOT_BOARD_HEARTBEAT_HOLDER_NAME "holder"
#define SNAKEBOT_MODE_REQUEST_TOKEN_NAME "token"
#define SNAKEBOT_MODE_REQUEST_MODE_NAME "mode"
#define SNAKEBOT_MODE_REQUEST_HOST_NAME "host"
#define SNAKEBOT_JOINT_MODE_REQUEST_TOKEN_NAME "token"
#define SNAKEBOT_JOINT_MODE_REQUEST_JOINT_NAME "joint"
#define SNAKEBOT_JOINT_MODE_REQUEST_MODE_NAME "mode"
#define SNAKEBOT_JOINT_MODE_REQUEST_ANGLE_RAD_NAME "angle_rad"
#define SNAKEBOT_JOINT_MODE_REQUEST_HOST_NAME "host"
#define SNAKEBOT_LIMIT_REQUEST_TOKEN_NAME "token"
#define SNAKEBOT_LIMIT_REQUEST_JOINT_NAME "joint"
#define SNAKEBOT_LIMIT_REQUEST_KIND_NAME "kind"
#define SNAKEBOT_LIMIT_REQUEST_VALUE_NAME "value"
#define SNAKEBOT_LIMIT_REQUEST_HOST_NAME "host"
#define SNAKEBOT_TRIM_REQUEST_TOKEN_NAME "token"
#define SNAKEBOT_TRIM_REQUEST_JOINT_NAME "joint"
#define SNAKEBOT_TRIM_REQUEST_TRIM_RAD_NAME "trim_rad"
#define SNAKEBOT_TRIM_REQUEST_HOST_NAME "host"
#define SNAKEBOT_ZERO_REQUEST_TOKEN_NAME "token"
#define SNAKEBOT_ZERO_REQUEST_JOINT_NAME "joint"
#define SNAKEBOT_ZERO_REQUEST_ZERO_COUNTS_NAME "zero_counts"
#define SNAKEBOT_ZERO_REQUEST_HOST_NAME "host"
#define SNAKEBOT_CLEAR_REQUEST_TOKEN_NAME "token"
#define SNAKEBOT_CLEAR_REQUEST_NUMBER_NAME "number"
#define SNAKEBOT_CLEAR_REQUEST_HOST_NAME "host"
#define SNAKEBOT_JOINT_LIMITS_JOINT_NAME "joint"
#define SNAKEBOT_JOINT_LIMITS_ANGLE_RAD_NAME "angle_rad"
#define SNAKEBOT_JOINT_LIMITS_SPEED_RAD_S_NAME "speed_rad_s"
#define SNAKEBOT_JOINT_LIMITS_ACCELERATION_RAD_S2_NAME "acceleration_rad_s2"
#define SNAKEBOT_ACKNOWLEDGE_TOKEN_NAME "token"
#define SNAKEBOT_ACKNOWLEDGE_RESULT_NAME "result"
#define SNAKEBOT_ACKNOWLEDGE_MODE_NAME "mode"
#define SNAKEBOT_ACKNOWLEDGE_REQUEST_NAME "request"
#define SNAKEBOT_ACKNOWLEDGE_DETAIL_NAME "detail"
#define SNAKEBOT_ACKNOWLEDGE_HOST_NAME "host"
#define SNAKEBOT_PING_NONCE_NAME "nonce"
#define SNAKEBOT_PONG_NONCE_NAME "nonce"
#define SNAKEBOT_PONG_BOARD_TIME_US_NAME "board_time_us"
#define SNAKEBOT_INFO_REQUEST_HOST_NAME "host"
#define SNAKEBOT_INFO_PROTOCOL_PROTOCOL_MAJOR_NAME "protocol_major"
#define SNAKEBOT_INFO_PROTOCOL_PROTOCOL_MINOR_NAME "protocol_minor"
#define SNAKEBOT_INFO_PROTOCOL_JOINTS_NAME "joints"
#define SNAKEBOT_INFO_PROTOCOL_SIMULATED_NAME "simulated"
#define SNAKEBOT_INFO_PROTOCOL_CATALOGUE_HASH_NAME "catalogue_hash"
#define SNAKEBOT_INFO_FIRMWARE_FIRMWARE_MAJOR_NAME "firmware_major"
#define SNAKEBOT_INFO_FIRMWARE_FIRMWARE_MINOR_NAME "firmware_minor"
#define SNAKEBOT_INFO_FIRMWARE_FIRMWARE_PATCH_NAME "firmware_patch"
#define SNAKEBOT_INFO_FIRMWARE_WATCHDOG_MS_NAME "watchdog_ms"
#define SNAKEBOT_INFO_FIRMWARE_COUNTS_PER_REV_NAME "counts_per_rev"
#define SNAKEBOT_INFO_FIRMWARE_BOOT_ID_NAME "boot_id"
#define SNAKEBOT_INFO_SERIAL_SERIAL_NUMBER_NAME "serial_number"
#define SNAKEBOT_SUPPLY_VOLTAGE_V_NAME "voltage_v"
#define SNAKEBOT_SUPPLY_CURRENT_A_NAME "current_a"
#define SNAKEBOT_SUPPLY_TEMPERATURE_C_NAME "temperature_c"
#define SNAKEBOT_JOINT_SUPPLY_JOINT_NAME "joint"
#define SNAKEBOT_JOINT_SUPPLY_CURRENT_A_NAME "current_a"
#define SNAKEBOT_JOINT_SUPPLY_TEMPERATURE_C_NAME "temperature_c"
#define SNAKEBOT_COUNTERS_RECEIVED_NAME "received"
#define SNAKEBOT_COUNTERS_CORRUPT_NAME "corrupt"
#define SNAKEBOT_COUNTERS_DROPPED_NAME "dropped"
#define SNAKEBOT_COUNTERS_CLAMPED_NAME "clamped"
#define SNAKEBOT_POSE_POSITION_SAMPLE_NAME "sample"
#define SNAKEBOT_POSE_POSITION_X_M_NAME "x_m"
#define SNAKEBOT_POSE_POSITION_Y_M_NAME "y_m"
#define SNAKEBOT_POSE_MOTION_SAMPLE_NAME "sample"
#define SNAKEBOT_POSE_MOTION_HEADING_RAD_NAME "heading_rad"
#define SNAKEBOT_POSE_MOTION_SPEED_M_S_NAME "speed_m_s"

/**
 * Signals in message EmergencyStop.
 *
 * Every joint is to lose power at once. Obeyed from anyone, in any state, whatever the payload.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_emergency_stop_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t reason;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message FaultEvent.
 *
 * Sent once when a fault is entered and at each emergency stop, and again with every board heartbeat while it is latched. number: of the latch; a ClearRequest names it.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_fault_event_t {
    /**
     * Range: 0..31 (0..31 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t code;

    /**
     * Range: 0..16 (0..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joint;

    /**
     * Range: 0..63 (0..63 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t number;

    /**
     * Range: -32768..32767 (-32768..32767 -)
     * Scale: 1
     * Offset: 0
     */
    int16_t detail;

    /**
     * Range: 0..4294967295 (0..4294967295 us)
     * Scale: 1
     * Offset: 0
     */
    uint32_t board_time_us;
};

/**
 * Signals in message Setpoint.
 *
 * Set-points of three joints: joints 3 group + 1 to 3 group + 3. Takes effect only with its Latch.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_setpoint_t {
    /**
     * Range: 0..4095 (0..4095 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t sequence;

    /**
     * Range: 0..5 (0..5 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t group;

    /**
     * Range: -32768..32767 (-3.2768..3.2767 rad)
     * Scale: 0.0001
     * Offset: 0
     */
    int16_t first_rad;

    /**
     * Range: -32768..32767 (-3.2768..3.2767 rad)
     * Scale: 0.0001
     * Offset: 0
     */
    int16_t second_rad;

    /**
     * Range: -32768..32767 (-3.2768..3.2767 rad)
     * Scale: 0.0001
     * Offset: 0
     */
    int16_t third_rad;
};

/**
 * Signals in message Latch.
 *
 * All set-points of this sequence number take effect at once, if every group has arrived and the CRC-32 over (sequence u16, joints u8, joints x i16 raw, little-endian) agrees.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_latch_t {
    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t sequence;

    /**
     * Range: 1..16 (1..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joints;

    /**
     * Range: 1..255 (0.0005..0.1275 s)
     * Scale: 0.0005
     * Offset: 0
     */
    uint8_t interval_s;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t crc32;
};

/**
 * Signals in message State.
 *
 * Answers a Latch, or is sent on the board's own beat while nothing streams. Opens a sample: Measured and Applied frames with the same sample number belong to it.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_state_t {
    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t sequence;

    /**
     * Range: 0..4095 (0..4095 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t sample;

    /**
     * Range: 0..15 (0..15 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t mode;

    /**
     * Range: 0..4294967295 (0..4294967295 us)
     * Scale: 1
     * Offset: 0
     */
    uint32_t board_time_us;
};

/**
 * Signals in message Measured.
 *
 * Encoder counts from the joint's zero; -32768 means no reading.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_measured_t {
    /**
     * Range: 0..4095 (0..4095 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t sample;

    /**
     * Range: 0..5 (0..5 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t group;

    /**
     * Range: -32768..32767 (-32768..32767 counts)
     * Scale: 1
     * Offset: 0
     */
    int16_t first_counts;

    /**
     * Range: -32768..32767 (-32768..32767 counts)
     * Scale: 1
     * Offset: 0
     */
    int16_t second_counts;

    /**
     * Range: -32768..32767 (-32768..32767 counts)
     * Scale: 1
     * Offset: 0
     */
    int16_t third_counts;
};

/**
 * Signals in message Applied.
 *
 * The set-points that the board is executing, after its own limits.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_applied_t {
    /**
     * Range: 0..4095 (0..4095 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t sample;

    /**
     * Range: 0..5 (0..5 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t group;

    /**
     * Range: -32768..32767 (-3.2768..3.2767 rad)
     * Scale: 0.0001
     * Offset: 0
     */
    int16_t first_rad;

    /**
     * Range: -32768..32767 (-3.2768..3.2767 rad)
     * Scale: 0.0001
     * Offset: 0
     */
    int16_t second_rad;

    /**
     * Range: -32768..32767 (-3.2768..3.2767 rad)
     * Scale: 0.0001
     * Offset: 0
     */
    int16_t third_rad;
};

/**
 * Signals in message HostHeartbeat.
 *
 * Keeps a holding board from relaxing. Does not feed the watchdog of an armed board: only set-points do.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_host_heartbeat_t {
    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;

    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t counter;
};

/**
 * Signals in message BoardHeartbeat.
 *
 * Ten times a second in every mode. holder is the host that armed the board, or 0.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_board_heartbeat_t {
    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t boot_id;

    /**
     * Range: 0..15 (0..15 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t mode;

    /**
     * Range: 0..1 (0..1 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t powered;

    /**
     * Range: 0..1 (0..1 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t simulated;

    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t fault;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t holder;
};

/**
 * Signals in message ModeRequest.
 *
 * Configuration: acknowledged, retried by the host with the same token.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_mode_request_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t token;

    /**
     * Range: 0..15 (0..15 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t mode;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message JointModeRequest.
 *
 * Makes a joint active, free (unpowered) or rigid (held at angle_rad, or where it is).
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_joint_mode_request_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t token;

    /**
     * Range: 1..16 (1..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joint;

    /**
     * Range: 0..7 (0..7 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t mode;

    /**
     * Range: -32768..32767 (-3.2768..3.2767 rad)
     * Scale: 0.0001
     * Offset: 0
     */
    int16_t angle_rad;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message LimitRequest.
 *
 * Sets one limit of one joint. Only tightens while armed.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_limit_request_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t token;

    /**
     * Range: 1..16 (1..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joint;

    /**
     * Range: 0..3 (0..3 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t kind;

    /**
     * Range: 0..131071 (0..262.142 rad, rad/s or rad/s2 by kind)
     * Scale: 0.002
     * Offset: 0
     */
    uint32_t value;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message TrimRequest.
 *
 * Added to the set-point before the limits, at most 0.3 rad: the sum is what the servo is told.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_trim_request_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t token;

    /**
     * Range: 1..16 (1..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joint;

    /**
     * Range: -32768..32767 (-3.2768..3.2767 rad)
     * Scale: 0.0001
     * Offset: 0
     */
    int16_t trim_rad;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message ZeroRequest.
 *
 * Encoder counts that are taken as zero.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_zero_request_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t token;

    /**
     * Range: 1..16 (1..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joint;

    /**
     * Range: -32768..32767 (-32768..32767 counts)
     * Scale: 1
     * Offset: 0
     */
    int16_t zero_counts;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message ClearRequest.
 *
 * The only way out of stopped and fault: clears the latch of this number, and no newer one.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_clear_request_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t token;

    /**
     * Range: 0..63 (0..63 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t number;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message JointLimits.
 *
 * The limits in force of one joint, to half a step: sent for every joint when armed is requested and granted, and after an InfoRequest.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_joint_limits_t {
    /**
     * Range: 1..16 (1..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joint;

    /**
     * Range: 0..131071 (0..262.142 rad)
     * Scale: 0.002
     * Offset: 0
     */
    uint32_t angle_rad;

    /**
     * Range: 0..131071 (0..262.142 rad/s)
     * Scale: 0.002
     * Offset: 0
     */
    uint32_t speed_rad_s;

    /**
     * Range: 0..131071 (0..262.142 rad/s2)
     * Scale: 0.002
     * Offset: 0
     */
    uint32_t acceleration_rad_s2;
};

/**
 * Signals in message Acknowledge.
 *
 * Answers a request of this host. mode: the board's, now. detail: the number of joints where the result is bad_joint, the fault's code where it is faulty, else 0.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_acknowledge_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t token;

    /**
     * Range: 0..15 (0..15 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t result;

    /**
     * Range: 0..15 (0..15 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t mode;

    /**
     * Range: 0..2047 (0..2047 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t request;

    /**
     * Range: 0..31 (0..31 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t detail;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message Ping.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_ping_t {
    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t nonce;
};

/**
 * Signals in message Pong.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_pong_t {
    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t nonce;

    /**
     * Range: 0..4294967295 (0..4294967295 us)
     * Scale: 1
     * Offset: 0
     */
    uint32_t board_time_us;
};

/**
 * Signals in message InfoRequest.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_info_request_t {
    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t host;
};

/**
 * Signals in message InfoProtocol.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_info_protocol_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t protocol_major;

    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t protocol_minor;

    /**
     * Range: 1..16 (1..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joints;

    /**
     * Range: 0..1 (0..1 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t simulated;

    /**
     * Range: 0..4294967295 (0..4294967295 -)
     * Scale: 1
     * Offset: 0
     */
    uint32_t catalogue_hash;
};

/**
 * Signals in message InfoFirmware.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_info_firmware_t {
    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t firmware_major;

    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t firmware_minor;

    /**
     * Range: 0..255 (0..255 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t firmware_patch;

    /**
     * Range: 1..255 (1..255 ms)
     * Scale: 1
     * Offset: 0
     */
    uint8_t watchdog_ms;

    /**
     * Range: 16..65535 (16..65535 counts)
     * Scale: 1
     * Offset: 0
     */
    uint16_t counts_per_rev;

    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t boot_id;
};

/**
 * Signals in message InfoSerial.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_info_serial_t {
    /**
     * Range: 0..18446744073709551615 (0..18446744073709551615 -)
     * Scale: 1
     * Offset: 0
     */
    uint64_t serial_number;
};

/**
 * Signals in message Supply.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_supply_t {
    /**
     * Range: 0..65535 (0..65.535 V)
     * Scale: 0.001
     * Offset: 0
     */
    uint16_t voltage_v;

    /**
     * Range: -32768..32767 (-32.768..32.767 A)
     * Scale: 0.001
     * Offset: 0
     */
    int16_t current_a;

    /**
     * Range: -32768..32767 (-3276.8..3276.7 degC)
     * Scale: 0.1
     * Offset: 0
     */
    int16_t temperature_c;
};

/**
 * Signals in message JointSupply.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_joint_supply_t {
    /**
     * Range: 1..16 (1..16 -)
     * Scale: 1
     * Offset: 0
     */
    uint8_t joint;

    /**
     * Range: -32768..32767 (-32.768..32.767 A)
     * Scale: 0.001
     * Offset: 0
     */
    int16_t current_a;

    /**
     * Range: -32768..32767 (-3276.8..3276.7 degC)
     * Scale: 0.1
     * Offset: 0
     */
    int16_t temperature_c;
};

/**
 * Signals in message Counters.
 *
 * Wrap at 16 bits. dropped: set-points that were incomplete, stale or too early; clamped: set-points changed by a limit.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_counters_t {
    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t received;

    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t corrupt;

    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t dropped;

    /**
     * Range: 0..65535 (0..65535 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t clamped;
};

/**
 * Signals in message PosePosition.
 *
 * Ground truth of a simulated board, or a tracking system's pose: centre of mass.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_pose_position_t {
    /**
     * Range: 0..4095 (0..4095 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t sample;

    /**
     * Range: -8388608..8388607 (-838.8608..838.8607 m)
     * Scale: 0.0001
     * Offset: 0
     */
    int32_t x_m;

    /**
     * Range: -8388608..8388607 (-838.8608..838.8607 m)
     * Scale: 0.0001
     * Offset: 0
     */
    int32_t y_m;
};

/**
 * Signals in message PoseMotion.
 *
 * Mean angle of the links, unwrapped, and speed of the centre of mass.
 *
 * All signal values are as on the CAN bus.
 */
struct snakebot_pose_motion_t {
    /**
     * Range: 0..4095 (0..4095 -)
     * Scale: 1
     * Offset: 0
     */
    uint16_t sample;

    /**
     * Range: -8388608..8388607 (-83.88608..83.88607 rad)
     * Scale: 1e-05
     * Offset: 0
     */
    int32_t heading_rad;

    /**
     * Range: -8388608..8388607 (-83.88608..83.88607 m/s)
     * Scale: 1e-05
     * Offset: 0
     */
    int32_t speed_m_s;
};

/**
 * Pack message EmergencyStop.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_emergency_stop_pack(
    uint8_t *dst_p,
    const struct snakebot_emergency_stop_t *src_p,
    size_t size);

/**
 * Unpack message EmergencyStop.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_emergency_stop_unpack(
    struct snakebot_emergency_stop_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from EmergencyStop.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_emergency_stop_init(struct snakebot_emergency_stop_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_emergency_stop_reason_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_emergency_stop_reason_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_emergency_stop_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_emergency_stop_host_is_in_phys_range(double value);

/**
 * Pack message FaultEvent.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_fault_event_pack(
    uint8_t *dst_p,
    const struct snakebot_fault_event_t *src_p,
    size_t size);

/**
 * Unpack message FaultEvent.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_fault_event_unpack(
    struct snakebot_fault_event_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from FaultEvent.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_fault_event_init(struct snakebot_fault_event_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_code_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_code_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_joint_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_joint_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_number_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_number_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_detail_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_detail_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_board_time_us_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_fault_event_board_time_us_is_in_phys_range(double value);

/**
 * Pack message Setpoint.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_setpoint_pack(
    uint8_t *dst_p,
    const struct snakebot_setpoint_t *src_p,
    size_t size);

/**
 * Unpack message Setpoint.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_setpoint_unpack(
    struct snakebot_setpoint_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Setpoint.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_setpoint_init(struct snakebot_setpoint_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_sequence_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_sequence_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_group_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_group_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_first_rad_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_first_rad_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_second_rad_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_second_rad_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_third_rad_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_setpoint_third_rad_is_in_phys_range(double value);

/**
 * Pack message Latch.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_latch_pack(
    uint8_t *dst_p,
    const struct snakebot_latch_t *src_p,
    size_t size);

/**
 * Unpack message Latch.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_latch_unpack(
    struct snakebot_latch_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Latch.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_latch_init(struct snakebot_latch_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_latch_sequence_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_latch_sequence_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_latch_joints_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_latch_joints_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_latch_interval_s_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_latch_interval_s_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_latch_crc32_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_latch_crc32_is_in_phys_range(double value);

/**
 * Pack message State.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_state_pack(
    uint8_t *dst_p,
    const struct snakebot_state_t *src_p,
    size_t size);

/**
 * Unpack message State.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_state_unpack(
    struct snakebot_state_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from State.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_state_init(struct snakebot_state_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_state_sequence_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_state_sequence_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_state_sample_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_state_sample_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_state_mode_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_state_mode_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_state_board_time_us_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_state_board_time_us_is_in_phys_range(double value);

/**
 * Pack message Measured.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_measured_pack(
    uint8_t *dst_p,
    const struct snakebot_measured_t *src_p,
    size_t size);

/**
 * Unpack message Measured.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_measured_unpack(
    struct snakebot_measured_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Measured.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_measured_init(struct snakebot_measured_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_sample_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_sample_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_group_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_group_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_first_counts_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_first_counts_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_second_counts_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_second_counts_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_third_counts_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_measured_third_counts_is_in_phys_range(double value);

/**
 * Pack message Applied.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_applied_pack(
    uint8_t *dst_p,
    const struct snakebot_applied_t *src_p,
    size_t size);

/**
 * Unpack message Applied.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_applied_unpack(
    struct snakebot_applied_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Applied.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_applied_init(struct snakebot_applied_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_sample_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_sample_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_group_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_group_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_first_rad_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_first_rad_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_second_rad_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_second_rad_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_third_rad_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_applied_third_rad_is_in_phys_range(double value);

/**
 * Pack message HostHeartbeat.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_host_heartbeat_pack(
    uint8_t *dst_p,
    const struct snakebot_host_heartbeat_t *src_p,
    size_t size);

/**
 * Unpack message HostHeartbeat.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_host_heartbeat_unpack(
    struct snakebot_host_heartbeat_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from HostHeartbeat.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_host_heartbeat_init(struct snakebot_host_heartbeat_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_host_heartbeat_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_host_heartbeat_host_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_host_heartbeat_counter_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_host_heartbeat_counter_is_in_phys_range(double value);

/**
 * Pack message BoardHeartbeat.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_board_heartbeat_pack(
    uint8_t *dst_p,
    const struct snakebot_board_heartbeat_t *src_p,
    size_t size);

/**
 * Unpack message BoardHeartbeat.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_board_heartbeat_unpack(
    struct snakebot_board_heartbeat_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from BoardHeartbeat.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_board_heartbeat_init(struct snakebot_board_heartbeat_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_boot_id_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_boot_id_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_mode_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_mode_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_powered_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_powered_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_simulated_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_simulated_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_fault_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_fault_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_holder_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_board_heartbeat_holder_is_in_phys_range(double value);

/**
 * Pack message ModeRequest.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_mode_request_pack(
    uint8_t *dst_p,
    const struct snakebot_mode_request_t *src_p,
    size_t size);

/**
 * Unpack message ModeRequest.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_mode_request_unpack(
    struct snakebot_mode_request_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from ModeRequest.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_mode_request_init(struct snakebot_mode_request_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_mode_request_token_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_mode_request_token_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_mode_request_mode_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_mode_request_mode_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_mode_request_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_mode_request_host_is_in_phys_range(double value);

/**
 * Pack message JointModeRequest.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_joint_mode_request_pack(
    uint8_t *dst_p,
    const struct snakebot_joint_mode_request_t *src_p,
    size_t size);

/**
 * Unpack message JointModeRequest.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_joint_mode_request_unpack(
    struct snakebot_joint_mode_request_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from JointModeRequest.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_joint_mode_request_init(struct snakebot_joint_mode_request_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_token_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_token_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_joint_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_joint_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_mode_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_mode_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_angle_rad_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_angle_rad_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_mode_request_host_is_in_phys_range(double value);

/**
 * Pack message LimitRequest.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_limit_request_pack(
    uint8_t *dst_p,
    const struct snakebot_limit_request_t *src_p,
    size_t size);

/**
 * Unpack message LimitRequest.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_limit_request_unpack(
    struct snakebot_limit_request_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from LimitRequest.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_limit_request_init(struct snakebot_limit_request_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_token_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_token_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_joint_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_joint_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_kind_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_kind_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_value_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_value_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_limit_request_host_is_in_phys_range(double value);

/**
 * Pack message TrimRequest.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_trim_request_pack(
    uint8_t *dst_p,
    const struct snakebot_trim_request_t *src_p,
    size_t size);

/**
 * Unpack message TrimRequest.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_trim_request_unpack(
    struct snakebot_trim_request_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from TrimRequest.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_trim_request_init(struct snakebot_trim_request_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_trim_request_token_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_trim_request_token_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_trim_request_joint_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_trim_request_joint_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_trim_request_trim_rad_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_trim_request_trim_rad_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_trim_request_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_trim_request_host_is_in_phys_range(double value);

/**
 * Pack message ZeroRequest.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_zero_request_pack(
    uint8_t *dst_p,
    const struct snakebot_zero_request_t *src_p,
    size_t size);

/**
 * Unpack message ZeroRequest.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_zero_request_unpack(
    struct snakebot_zero_request_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from ZeroRequest.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_zero_request_init(struct snakebot_zero_request_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_zero_request_token_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_zero_request_token_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_zero_request_joint_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_zero_request_joint_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_zero_request_zero_counts_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_zero_request_zero_counts_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_zero_request_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_zero_request_host_is_in_phys_range(double value);

/**
 * Pack message ClearRequest.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_clear_request_pack(
    uint8_t *dst_p,
    const struct snakebot_clear_request_t *src_p,
    size_t size);

/**
 * Unpack message ClearRequest.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_clear_request_unpack(
    struct snakebot_clear_request_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from ClearRequest.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_clear_request_init(struct snakebot_clear_request_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_clear_request_token_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_clear_request_token_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_clear_request_number_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_clear_request_number_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_clear_request_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_clear_request_host_is_in_phys_range(double value);

/**
 * Pack message JointLimits.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_joint_limits_pack(
    uint8_t *dst_p,
    const struct snakebot_joint_limits_t *src_p,
    size_t size);

/**
 * Unpack message JointLimits.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_joint_limits_unpack(
    struct snakebot_joint_limits_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from JointLimits.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_joint_limits_init(struct snakebot_joint_limits_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_limits_joint_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_limits_joint_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_limits_angle_rad_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_limits_angle_rad_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_limits_speed_rad_s_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_limits_speed_rad_s_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_limits_acceleration_rad_s2_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_limits_acceleration_rad_s2_is_in_phys_range(double value);

/**
 * Pack message Acknowledge.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_acknowledge_pack(
    uint8_t *dst_p,
    const struct snakebot_acknowledge_t *src_p,
    size_t size);

/**
 * Unpack message Acknowledge.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_acknowledge_unpack(
    struct snakebot_acknowledge_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Acknowledge.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_acknowledge_init(struct snakebot_acknowledge_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_token_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_token_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_result_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_result_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_mode_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_mode_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_request_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_request_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_detail_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_detail_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_acknowledge_host_is_in_phys_range(double value);

/**
 * Pack message Ping.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_ping_pack(
    uint8_t *dst_p,
    const struct snakebot_ping_t *src_p,
    size_t size);

/**
 * Unpack message Ping.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_ping_unpack(
    struct snakebot_ping_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Ping.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_ping_init(struct snakebot_ping_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_ping_nonce_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_ping_nonce_is_in_phys_range(double value);

/**
 * Pack message Pong.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_pong_pack(
    uint8_t *dst_p,
    const struct snakebot_pong_t *src_p,
    size_t size);

/**
 * Unpack message Pong.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_pong_unpack(
    struct snakebot_pong_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Pong.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_pong_init(struct snakebot_pong_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pong_nonce_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pong_nonce_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pong_board_time_us_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pong_board_time_us_is_in_phys_range(double value);

/**
 * Pack message InfoRequest.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_info_request_pack(
    uint8_t *dst_p,
    const struct snakebot_info_request_t *src_p,
    size_t size);

/**
 * Unpack message InfoRequest.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_info_request_unpack(
    struct snakebot_info_request_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from InfoRequest.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_info_request_init(struct snakebot_info_request_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_request_host_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_request_host_is_in_phys_range(double value);

/**
 * Pack message InfoProtocol.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_info_protocol_pack(
    uint8_t *dst_p,
    const struct snakebot_info_protocol_t *src_p,
    size_t size);

/**
 * Unpack message InfoProtocol.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_info_protocol_unpack(
    struct snakebot_info_protocol_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from InfoProtocol.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_info_protocol_init(struct snakebot_info_protocol_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_protocol_major_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_protocol_major_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_protocol_minor_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_protocol_minor_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_joints_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_joints_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_simulated_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_simulated_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_catalogue_hash_is_in_range(uint32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_protocol_catalogue_hash_is_in_phys_range(double value);

/**
 * Pack message InfoFirmware.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_info_firmware_pack(
    uint8_t *dst_p,
    const struct snakebot_info_firmware_t *src_p,
    size_t size);

/**
 * Unpack message InfoFirmware.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_info_firmware_unpack(
    struct snakebot_info_firmware_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from InfoFirmware.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_info_firmware_init(struct snakebot_info_firmware_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_firmware_major_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_firmware_major_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_firmware_minor_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_firmware_minor_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_firmware_patch_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_firmware_patch_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_watchdog_ms_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_watchdog_ms_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_counts_per_rev_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_counts_per_rev_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_boot_id_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_firmware_boot_id_is_in_phys_range(double value);

/**
 * Pack message InfoSerial.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_info_serial_pack(
    uint8_t *dst_p,
    const struct snakebot_info_serial_t *src_p,
    size_t size);

/**
 * Unpack message InfoSerial.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_info_serial_unpack(
    struct snakebot_info_serial_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from InfoSerial.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_info_serial_init(struct snakebot_info_serial_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_serial_serial_number_is_in_range(uint64_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_info_serial_serial_number_is_in_phys_range(double value);

/**
 * Pack message Supply.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_supply_pack(
    uint8_t *dst_p,
    const struct snakebot_supply_t *src_p,
    size_t size);

/**
 * Unpack message Supply.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_supply_unpack(
    struct snakebot_supply_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Supply.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_supply_init(struct snakebot_supply_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_supply_voltage_v_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_supply_voltage_v_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_supply_current_a_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_supply_current_a_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_supply_temperature_c_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_supply_temperature_c_is_in_phys_range(double value);

/**
 * Pack message JointSupply.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_joint_supply_pack(
    uint8_t *dst_p,
    const struct snakebot_joint_supply_t *src_p,
    size_t size);

/**
 * Unpack message JointSupply.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_joint_supply_unpack(
    struct snakebot_joint_supply_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from JointSupply.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_joint_supply_init(struct snakebot_joint_supply_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_supply_joint_is_in_range(uint8_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_supply_joint_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_supply_current_a_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_supply_current_a_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_supply_temperature_c_is_in_range(int16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_joint_supply_temperature_c_is_in_phys_range(double value);

/**
 * Pack message Counters.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_counters_pack(
    uint8_t *dst_p,
    const struct snakebot_counters_t *src_p,
    size_t size);

/**
 * Unpack message Counters.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_counters_unpack(
    struct snakebot_counters_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from Counters.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_counters_init(struct snakebot_counters_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_counters_received_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_counters_received_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_counters_corrupt_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_counters_corrupt_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_counters_dropped_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_counters_dropped_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_counters_clamped_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_counters_clamped_is_in_phys_range(double value);

/**
 * Pack message PosePosition.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_pose_position_pack(
    uint8_t *dst_p,
    const struct snakebot_pose_position_t *src_p,
    size_t size);

/**
 * Unpack message PosePosition.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_pose_position_unpack(
    struct snakebot_pose_position_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from PosePosition.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_pose_position_init(struct snakebot_pose_position_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_position_sample_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_position_sample_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_position_x_m_is_in_range(int32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_position_x_m_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_position_y_m_is_in_range(int32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_position_y_m_is_in_phys_range(double value);

/**
 * Pack message PoseMotion.
 *
 * @param[out] dst_p Buffer to pack the message into.
 * @param[in] src_p Data to pack.
 * @param[in] size Size of dst_p.
 *
 * @return Size of packed data, or negative error code.
 */
int snakebot_pose_motion_pack(
    uint8_t *dst_p,
    const struct snakebot_pose_motion_t *src_p,
    size_t size);

/**
 * Unpack message PoseMotion.
 *
 * @param[out] dst_p Object to unpack the message into.
 * @param[in] src_p Message to unpack.
 * @param[in] size Size of src_p.
 *
 * @return zero(0) or negative error code.
 */
int snakebot_pose_motion_unpack(
    struct snakebot_pose_motion_t *dst_p,
    const uint8_t *src_p,
    size_t size);

/**
 * Init message fields to default values from PoseMotion.
 *
 * @param[in] msg_p Message to init.
 *
 * @return zero(0) on success or (-1) in case of nullptr argument.
 */
int snakebot_pose_motion_init(struct snakebot_pose_motion_t *msg_p);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_motion_sample_is_in_range(uint16_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_motion_sample_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_motion_heading_rad_is_in_range(int32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_motion_heading_rad_is_in_phys_range(double value);

/**
 * Check that given signal is in allowed range.
 *
 * @param[in] value Signal to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_motion_speed_m_s_is_in_range(int32_t value);

/**
 * Check that given physical value is in allowed range before encoding.
 *
 * Use this BEFORE calling _encode() to avoid silent integer overflow:
 *   encode(-1.0) on a [0,100] signal wraps to 255 and passes is_in_range().
 *   is_in_phys_range(-1.0) correctly returns false.
 *
 * @param[in] value Physical signal value to check.
 *
 * @return true if in range, false otherwise.
 */
bool snakebot_pose_motion_speed_m_s_is_in_phys_range(double value);


#ifdef __cplusplus
}
#endif

#endif
