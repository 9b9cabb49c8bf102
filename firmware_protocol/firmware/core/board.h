/* The board: frames and time in, frames out. A port calls `sb_board_reset` once and `sb_board_step` for ever after. */
#ifndef SB_BOARD_H
#define SB_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "framing.h"
#include "joints.h"
#include "modes.h"
#include "setpoint.h"

#define SB_PROTOCOL_MAJOR 2u
#define SB_PROTOCOL_MINOR 0u
#define SB_FIRMWARE_MAJOR 2u
#define SB_FIRMWARE_MINOR 0u
#define SB_FIRMWARE_PATCH 0u

#define SB_OUT_BYTES 384u /* the largest answer: a sample of 16 joints, and everything that is due with it */

struct sb_board {
    struct sb_joints joints;
    struct sb_modes modes;
    struct sb_assembler assembler;
    struct sb_decoder decoder;
    uint16_t boot_id;
    uint16_t sequence; /* of the set-point that was executed last */
    bool first;        /* since arming */
    bool button;       /* the hardware's emergency stop was pressed when it was looked at last */
    uint32_t executed_us; /* or armed, or reset */
    uint16_t sample;
    uint16_t received;
    uint16_t corrupt; /* frames; the decoder counts packets */
    uint16_t dropped; /* set-points; the assembler counts its own */
    uint16_t clamped;
    uint32_t beat_due_us;
    uint32_t sample_due_us;
    uint32_t second_due_us;
    uint32_t out_length;
    uint8_t out[SB_OUT_BYTES];
};

/* Everything a reset forgets is forgotten; the servos are off. `config` must outlive the board. */
void sb_board_reset(struct sb_board *board, const struct sb_config *config);

/* Do what is due, take what has come in, send what is to be said. Call it at least every millisecond. */
void sb_board_step(struct sb_board *board);

/* How long nothing is due, if nothing comes in: a port may sleep that long (us; 0: now). */
uint32_t sb_board_idle_us(const struct sb_board *board);

#endif
