/*
 * What a port writes: everything that differs from one microcontroller to the next.
 *
 * All functions return at once; none may wait for a peer or a bus. They are called from one thread of execution (the
 * main loop). Joints count from 0 here. docs/build-your-board.md explains each one.
 */
#ifndef SB_HAL_H
#define SB_HAL_H

#include <stdbool.h>
#include <stdint.h>

#include "frame.h"

#define SB_MAX_JOINTS 16u

/* What is kept over a reset. Plain data: a port may store it as bytes. */
struct sb_parameters {
    int16_t trim[SB_MAX_JOINTS]; /* in steps of the wire, 1e-4 rad */
    int16_t zero_counts[SB_MAX_JOINTS];
};

struct sb_supply {
    uint16_t voltage_mv; /* of the board's supply only */
    int16_t current_ma;
    int16_t temperature_dc; /* tenths of a degree Celsius */
};

struct sb_hardware_fault {
    uint8_t code;  /* SNAKEBOT_FAULT_EVENT_CODE_...; NONE while all is well */
    uint8_t joint; /* from 1; 0: not one joint's */
    int16_t detail;
};

/* Free-running microseconds; wraps at 32 bits. Must never go back. */
uint32_t hal_time_us(void);

/* A number that differs from one reset to the next. */
uint32_t hal_random(void);

/* Keep sending pulses of this length to the servo (50 to 330 Hz), from its next period on. */
void hal_servo_pulse(uint8_t joint, uint32_t pulse_ns);

/* No more pulses: the servo loses its torque. Must work whatever went before. */
void hal_servo_off(uint8_t joint);

/* The encoder's count since power-up (32 bits, signed); false where there is no reading. */
bool hal_encoder_read(uint8_t joint, int32_t *counts);

/* What has come in over the serial line: up to `most` bytes, and how many. */
uint32_t hal_serial_read(uint8_t *data, uint32_t most);

/* Queue bytes for the serial line; where they do not all fit, drop them all. */
void hal_serial_write(const uint8_t *data, uint32_t length);

/* The next frame that has come in over CAN; false if there is none. */
bool hal_can_read(struct sb_frame *frame);

/* Queue a frame for CAN; where it does not fit, drop it. */
void hal_can_write(const struct sb_frame *frame);

/*
 * Read what was stored last; false if nothing was, or it is damaged. A port that finds something damaged reports a fault
 * of the hardware (internal) as long as it lasts: without its trims and zeros a board must not be armed.
 */
bool hal_parameters_load(struct sb_parameters *parameters);

/* Store it. Called only while the servos have no power, and only when something has changed. */
void hal_parameters_save(const struct sb_parameters *parameters);

/* Measured supply of the board (joint -1) or of a joint; false where it is not measured. */
bool hal_supply_read(int8_t joint, struct sb_supply *supply);

/* The worst that is wrong with the hardware now. EMERGENCY_STOP: a button is pressed. */
struct sb_hardware_fault hal_hardware_fault(void);

#endif
