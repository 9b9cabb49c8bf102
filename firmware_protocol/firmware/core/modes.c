#include "modes.h"

#include "generated/snakebot.h"

#define DISARMED SNAKEBOT_STATE_MODE_DISARMED_CHOICE
#define ARMED SNAKEBOT_STATE_MODE_ARMED_CHOICE
#define HOLDING SNAKEBOT_STATE_MODE_HOLDING_CHOICE
#define STOPPED SNAKEBOT_STATE_MODE_STOPPED_CHOICE
#define FAULT SNAKEBOT_STATE_MODE_FAULT_CHOICE

static const struct sb_hardware_fault no_fault = {SNAKEBOT_FAULT_EVENT_CODE_NONE_CHOICE, 0u, 0};

bool sb_modes_held(const struct sb_modes *modes)
{
    return (modes->mode == ARMED) || (modes->mode == HOLDING);
}

bool sb_modes_held_against(const struct sb_modes *modes, uint32_t host)
{
    return sb_modes_held(modes) && (host != modes->holder);
}

/* The table of PROTOCOL.md: everything may be disarmed, an armed board may hold, only a free one is armed. */
static bool may_enter(uint8_t from, uint8_t wanted)
{
    if (wanted == DISARMED) {
        return true;
    }
    if (wanted == ARMED) {
        return (from == DISARMED) || (from == HOLDING);
    }
    return from == ARMED;
}

struct sb_answer sb_modes_request(struct sb_modes *modes, uint8_t wanted, uint32_t host, uint32_t now_us)
{
    if (sb_modes_held_against(modes, host)) {
        return (struct sb_answer){SNAKEBOT_ACKNOWLEDGE_RESULT_HELD_CHOICE, modes->holder};
    }
    if ((wanted == STOPPED) || (wanted == FAULT) || (host == SB_NOBODY)) {
        return (struct sb_answer){SNAKEBOT_ACKNOWLEDGE_RESULT_BAD_VALUE_CHOICE, 0u};
    }
    if (wanted != modes->mode) {
        if (!may_enter(modes->mode, wanted)) {
            return (struct sb_answer){SNAKEBOT_ACKNOWLEDGE_RESULT_FORBIDDEN_CHOICE, modes->mode};
        }
        if (wanted == DISARMED) {
            modes->holder = SB_NOBODY;
            modes->fault = no_fault;
        } else if (modes->mode == DISARMED) {
            modes->holder = host;
        } else {
            /* between armed and holding the holder stays */
        }
        modes->mode = wanted;
        modes->powered = (wanted != DISARMED);
        modes->fed_us = now_us;
    }
    return (struct sb_answer){SNAKEBOT_ACKNOWLEDGE_RESULT_OK_CHOICE, modes->mode};
}

void sb_modes_emergency_stop(struct sb_modes *modes, uint32_t now_us)
{
    if (modes->mode != STOPPED) {
        modes->fault_since_us = now_us;
    }
    modes->mode = STOPPED;
    modes->fault = (struct sb_hardware_fault){SNAKEBOT_FAULT_EVENT_CODE_EMERGENCY_STOP_CHOICE, 0u, 0};
    modes->powered = false;
}

bool sb_modes_fail(struct sb_modes *modes, struct sb_hardware_fault fault, uint32_t now_us)
{
    if (!sb_modes_held(modes)) {
        return false;
    }
    modes->mode = FAULT;
    modes->fault = fault;
    modes->fault_since_us = now_us;
    return true;
}

void sb_modes_executed(struct sb_modes *modes, uint32_t now_us)
{
    modes->fed_us = now_us;
}

void sb_modes_heartbeat(struct sb_modes *modes, uint32_t host, uint32_t now_us)
{
    if ((modes->mode == HOLDING) && (host == modes->holder)) {
        modes->fed_us = now_us;
    }
}

bool sb_modes_due(const struct sb_modes *modes, uint32_t *due_us)
{
    switch (modes->mode) {
    case ARMED:
        *due_us = modes->fed_us + SB_WATCHDOG_US;
        return true;
    case HOLDING:
        *due_us = modes->fed_us + SB_HOLD_PATIENCE_US;
        return true;
    case FAULT:
        *due_us = modes->fault_since_us + SB_RELAX_US;
        return modes->powered;
    default:
        return false;
    }
}

enum sb_expiry sb_modes_expire(struct sb_modes *modes, uint32_t due_us)
{
    if (modes->mode == FAULT) {
        modes->powered = false;
        return SB_EXPIRY_RELAX;
    }
    const struct sb_hardware_fault watchdog = {SNAKEBOT_FAULT_EVENT_CODE_WATCHDOG_CHOICE, 0u, 0};
    return sb_modes_fail(modes, watchdog, due_us) ? SB_EXPIRY_WATCHDOG : SB_EXPIRY_NONE;
}
