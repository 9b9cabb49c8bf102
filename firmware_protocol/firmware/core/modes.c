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

/* The table of PROTOCOL.md: no request for a mode leads out of stopped or fault. */
static bool may_enter(uint8_t from, uint8_t wanted)
{
    if (wanted == DISARMED) {
        return (from == ARMED) || (from == HOLDING);
    }
    if (wanted == ARMED) {
        return (from == DISARMED) || (from == HOLDING);
    }
    return from == ARMED;
}

static struct sb_answer answer(uint8_t result, uint8_t detail)
{
    return (struct sb_answer){result, detail};
}

static void disarm(struct sb_modes *modes)
{
    modes->mode = DISARMED;
    modes->holder = SB_NOBODY;
    modes->fault = no_fault;
    modes->powered = false;
}

static void next_latch(struct sb_modes *modes)
{
    modes->latch = (uint8_t)((modes->latch + 1u) & SB_LATCH_MASK);
}

struct sb_answer sb_modes_request(struct sb_modes *modes, uint8_t wanted, uint32_t host, uint32_t now_us)
{
    if (sb_modes_held_against(modes, host)) {
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_HELD_CHOICE, 0u);
    }
    if ((wanted == STOPPED) || (wanted == FAULT) || (host == SB_NOBODY)) {
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_BAD_VALUE_CHOICE, 0u);
    }
    if (wanted == modes->mode) {
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_OK_CHOICE, 0u);
    }
    if (!may_enter(modes->mode, wanted)) {
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_FORBIDDEN_CHOICE, 0u);
    }
    if (wanted == DISARMED) {
        disarm(modes);
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_OK_CHOICE, 0u);
    }
    const struct sb_hardware_fault broken = hal_hardware_fault();
    if (broken.code != SNAKEBOT_FAULT_EVENT_CODE_NONE_CHOICE) {
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_FAULTY_CHOICE, broken.code);
    }
    if (modes->mode == DISARMED) {
        modes->holder = host; /* between armed and holding the holder stays */
    }
    modes->mode = wanted;
    modes->powered = true;
    modes->fed_us = now_us;
    return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_OK_CHOICE, 0u);
}

struct sb_answer sb_modes_clear(struct sb_modes *modes, uint8_t number, uint32_t host)
{
    if (sb_modes_held_against(modes, host)) {
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_HELD_CHOICE, 0u);
    }
    if (host == SB_NOBODY) {
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_BAD_VALUE_CHOICE, 0u);
    }
    if (number != modes->latch) {
        return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_FORBIDDEN_CHOICE, 0u);
    }
    if ((modes->mode == STOPPED) || (modes->mode == FAULT)) {
        disarm(modes);
    }
    return answer(SNAKEBOT_ACKNOWLEDGE_RESULT_OK_CHOICE, 0u);
}

void sb_modes_emergency_stop(struct sb_modes *modes, uint32_t now_us)
{
    next_latch(modes);
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
    next_latch(modes);
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

bool sb_modes_expire(struct sb_modes *modes, uint32_t due_us)
{
    if (modes->mode == FAULT) {
        modes->powered = false;
        return false;
    }
    const struct sb_hardware_fault watchdog = {SNAKEBOT_FAULT_EVENT_CODE_WATCHDOG_CHOICE, 0u, 0};
    return sb_modes_fail(modes, watchdog, due_us);
}
