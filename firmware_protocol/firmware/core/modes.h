/* What mode the board is in, who holds it, and what its watchdog says: the table of PROTOCOL.md, and nothing else. */
#ifndef SB_MODES_H
#define SB_MODES_H

#include <stdbool.h>
#include <stdint.h>

#include "hal.h"

#define SB_WATCHDOG_US 100000u       /* armed: longest time without an executed set-point */
#define SB_HOLD_PATIENCE_US 1000000u /* holding: longest time without a heartbeat of the holder */
#define SB_RELAX_US 2000000u         /* fault: the joints are frozen this long before they lose power */
#define SB_NOBODY 0u
#define SB_LATCH_MASK 0x3Fu /* what the wire carries of a latch's number */

struct sb_modes {
    uint8_t mode; /* SNAKEBOT_STATE_MODE_... */
    bool powered;
    struct sb_hardware_fault fault; /* code EMERGENCY_STOP or WATCHDOG where that is the reason */
    uint32_t fault_since_us;
    uint8_t latch; /* number of the last one: each fault and each emergency stop raises it */
    uint32_t holder;
    uint32_t fed_us; /* what the watchdog counts from: arming or set-point; holding or heartbeat */
};

struct sb_answer {
    uint8_t result; /* SNAKEBOT_ACKNOWLEDGE_RESULT_... */
    uint8_t detail;
};

/* Armed or holding: somebody has the board. */
bool sb_modes_held(const struct sb_modes *modes);

/* Another host holds the board: requests of this one are not looked at. */
bool sb_modes_held_against(const struct sb_modes *modes, uint32_t host);

/* Go to a mode, if the table lets this host, and the hardware where that would give power. */
struct sb_answer sb_modes_request(struct sb_modes *modes, uint8_t wanted, uint32_t host, uint32_t now_us);

/* Leave `stopped` or `fault`, if this is the latch that is meant: a late request undoes no newer stop. */
struct sb_answer sb_modes_clear(struct sb_modes *modes, uint8_t number, uint32_t host);

/* From anyone, in any mode; each one is a latch of its own. */
void sb_modes_emergency_stop(struct sb_modes *modes, uint32_t now_us);

/* A fault of watchdog or hardware: only a board that is armed or holding has something to freeze. */
bool sb_modes_fail(struct sb_modes *modes, struct sb_hardware_fault fault, uint32_t now_us);

/* A set-point has been executed: the watchdog of an armed board is fed. */
void sb_modes_executed(struct sb_modes *modes, uint32_t now_us);

/* A host's heartbeat: the holder's keeps a holding board from its fault, and does nothing else. */
void sb_modes_heartbeat(struct sb_modes *modes, uint32_t host, uint32_t now_us);

/* When the timer of this mode runs out; false if none runs. */
bool sb_modes_due(const struct sb_modes *modes, uint32_t *due_us);

/* The timer that ran out at `due_us` does its work: true is a fault of the watchdog, false the end of a fault's power. */
bool sb_modes_expire(struct sb_modes *modes, uint32_t due_us);

#endif
