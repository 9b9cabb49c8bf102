/* Joints that are not there: first-order servos and ideal encoders behind the HAL, for ports without hardware. */
#ifndef SIMULATED_JOINTS_H
#define SIMULATED_JOINTS_H

#include "core/joints.h"

/* Joints at rest at `start_rad`. Servos approach their pulse with `time_constant_s` (0: at once). */
void simulated_joints_start(const struct sb_config *config, const float *start_rad, float time_constant_s);

/* Turn a joint by hand. */
void simulated_joints_place(uint8_t joint, float angle_rad);

/* The angle that the servo's last pulse asks for; NaN while it has no power. */
float simulated_joints_target(uint8_t joint);

/* What the hardware is to report from now on. */
void simulated_joints_fault(uint8_t code, uint8_t joint, int16_t detail);
/* Joint j (from 1) measures j mA and 2 j tenths of a degree more than that. */
void simulated_joints_supply(bool measured, uint16_t voltage_mv, int16_t current_ma, int16_t temperature_dc);
void simulated_joints_encoder_lost(uint8_t joint, bool lost);

/* A board with that many hobby servos: 1500 us at 0, 2000/pi us a radian, 8192 counts a turn. */
struct sb_config simulated_board(uint8_t joint_count, uint64_t serial_number);

#endif
