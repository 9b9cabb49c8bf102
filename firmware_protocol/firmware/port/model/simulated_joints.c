#include "simulated_joints.h"

#include <math.h>

#include "core/hal.h"

#define PI 3.14159265359f

struct joint {
    float angle_rad;
    float target_rad;
    bool powered;
    bool lost; /* the encoder gives no reading */
    uint32_t since_us; /* of angle_rad */
};

static const struct sb_config *board;
static float lag_s;
static struct joint joints[SB_MAX_JOINTS];
static struct sb_hardware_fault fault;
static struct sb_supply supply;
static bool supply_measured;

void simulated_joints_start(const struct sb_config *config, const float *start_rad, float time_constant_s)
{
    board = config;
    lag_s = time_constant_s;
    for (uint8_t i = 0u; i < SB_MAX_JOINTS; i++) {
        joints[i] = (struct joint){start_rad[i], start_rad[i], false, false, hal_time_us()};
    }
}

/* Bring a joint to now. */
static void settle(struct joint *joint)
{
    const uint32_t now_us = hal_time_us();
    const float passed_s = (float)(now_us - joint->since_us) * 1e-6f;
    if (joint->powered && (passed_s > 0.0f)) {
        const float left = (lag_s > 0.0f) ? expf(-passed_s / lag_s) : 0.0f;
        joint->angle_rad = joint->target_rad + (joint->angle_rad - joint->target_rad) * left;
    }
    joint->since_us = now_us;
}

void simulated_joints_place(uint8_t joint, float angle_rad)
{
    settle(&joints[joint]);
    joints[joint].angle_rad = angle_rad;
}

float simulated_joints_target(uint8_t joint)
{
    return joints[joint].powered ? joints[joint].target_rad : NAN;
}

void simulated_joints_fault(uint8_t code, uint8_t joint, int16_t detail)
{
    fault = (struct sb_hardware_fault){code, joint, detail};
}

void simulated_joints_supply(bool measured, uint16_t voltage_mv, int16_t current_ma, int16_t temperature_dc)
{
    supply_measured = measured;
    supply = (struct sb_supply){voltage_mv, current_ma, temperature_dc};
}

void simulated_joints_encoder_lost(uint8_t joint, bool lost)
{
    joints[joint].lost = lost;
}

void hal_servo_pulse(uint8_t joint, uint32_t pulse_ns)
{
    const struct sb_servo *servo = &board->servos[joint];
    settle(&joints[joint]);
    joints[joint].target_rad = ((float)pulse_ns - (float)servo->centre_ns) / (float)servo->ns_per_rad;
    joints[joint].powered = true;
}

void hal_servo_off(uint8_t joint)
{
    settle(&joints[joint]);
    joints[joint].powered = false;
}

bool hal_encoder_read(uint8_t joint, int32_t *counts)
{
    settle(&joints[joint]);
    *counts = (int32_t)lroundf(joints[joint].angle_rad / (2.0f * PI) * (float)board->counts_per_rev);
    return !joints[joint].lost;
}

bool hal_supply_read(int8_t joint, struct sb_supply *measured)
{
    *measured = supply;
    measured->current_ma = (int16_t)(measured->current_ma + joint + 1); /* of the board (-1) nothing more */
    measured->temperature_dc = (int16_t)(measured->temperature_dc + 2 * (joint + 1));
    return supply_measured;
}

struct sb_hardware_fault hal_hardware_fault(void)
{
    return fault;
}

struct sb_config simulated_board(uint8_t joint_count, uint64_t serial_number)
{
    struct sb_config config = {
        .joints = joint_count, .simulated = true, .counts_per_rev = 8192u, .serial_number = serial_number};
    for (uint8_t i = 0u; i < SB_MAX_JOINTS; i++) {
        config.limits[i] = (struct sb_limits){95.0f * PI / 180.0f, 8.0f, 60.0f};
        config.servos[i] = (struct sb_servo){1500000u, (int32_t)(2e6f / PI), 400000u, 2600000u};
    }
    return config;
}
