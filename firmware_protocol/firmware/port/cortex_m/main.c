/*
 * The reference board on an ARM MPS2 AN385 (Cortex-M3), as QEMU emulates it: UART 0 is the serial line, the joints are
 * simulated. Other Cortex-M boards differ in the registers below, in hal_servo_* and in hal_encoder_read.
 */
#include <string.h>

#include "core/board.h"
#include "core/crc.h"
#include "core/hal.h"
#include "model/simulated_joints.h"

void systick_handler(void);
void uart0_rx_handler(void);
void uart0_tx_handler(void);
int main(void);

/* CMSDK UART */
struct uart {
    volatile uint32_t data;
    volatile uint32_t state; /* bit 0: transmitter full, bit 1: a byte has come in */
    volatile uint32_t control;
    volatile uint32_t interrupt; /* read: pending; write: clear */
    volatile uint32_t divider;
};

#define UART0 ((struct uart *)0x40004000u)
#define STATE_TX_FULL 1u
#define STATE_RX_FULL 2u
#define CONTROL_TX 1u
#define CONTROL_RX 2u
#define CONTROL_TX_INTERRUPT 4u
#define CONTROL_RX_INTERRUPT 8u
#define INTERRUPT_TX 1u
#define INTERRUPT_RX 2u

/* Time comes from a free-running counter, never from counted interrupts: those get lost. */
#define COUNTER (*(volatile uint32_t *)0x40028018u)
#define PRESCALER (*(volatile uint32_t *)0x4002801Cu)
#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define NVIC_ENABLE (*(volatile uint32_t *)0xE000E100u)

/* CMSDK watchdog: counts down; the first time at zero it raises the NMI, the second time it resets the processor. */
struct watchdog {
    volatile uint32_t load;
    volatile uint32_t value;
    volatile uint32_t control; /* bit 0: NMI and counting on, bit 1: reset on */
    volatile uint32_t clear;   /* any write: back to `load`, the NMI is over */
    uint32_t unused[764];
    volatile uint32_t lock; /* at 0xC00; registers can be written after this has got the key, until it gets another */
};

#define WATCHDOG ((struct watchdog *)0x40008000u)
#define WATCHDOG_NMI 1u
#define WATCHDOG_RESET 2u
#define WATCHDOG_KEY 0x1ACCE551u
/* A hung board holds its joints where they are: shorter than the 2 s after which a fault relaxes them. */
#define WATCHDOG_S_DIVISOR 2u /* half a second */

#define CLOCK_HZ 25000000u
#define COUNTER_HZ 25000000u /* before the prescaler */
#define BAUD 1000000u
#define JOINTS 5u

#define RX_BYTES 1024u /* powers of two; one step takes 256 bytes, so this is four steps of a full line */
#define TX_BYTES 1024u

static volatile uint8_t rx[RX_BYTES];
static volatile uint32_t rx_end; /* counts for ever: the difference is what is there */
static uint32_t rx_begin;
static volatile uint8_t tx[TX_BYTES];
static uint32_t tx_end;
static volatile uint32_t tx_begin;

static struct sb_board board;
static struct sb_config config;
static uint32_t fed_us; /* what the counter showed when the watchdog was fed last */

/* Kept over a reset as long as the supply lasts: this board has no memory that would last longer. */
struct kept {
    struct sb_parameters parameters;
    uint32_t resets;
    uint32_t crc;
};
__attribute__((section(".noinit"))) static struct kept kept;

/* -- interrupts ---------------------------------------------------------------------------------------------------- */

void systick_handler(void)
{
    /* only wakes the main loop */
}

void uart0_rx_handler(void)
{
    UART0->interrupt = INTERRUPT_RX; /* first: clearing after reading loses the byte that comes in between */
    while ((UART0->state & STATE_RX_FULL) != 0u) {
        const uint8_t byte = (uint8_t)UART0->data;
        rx[rx_end % RX_BYTES] = byte;
        rx_end++;
    }
}

static void transmit(void)
{
    while ((tx_begin != tx_end) && ((UART0->state & STATE_TX_FULL) == 0u)) {
        UART0->data = tx[tx_begin % TX_BYTES];
        tx_begin++;
    }
}

void uart0_tx_handler(void)
{
    UART0->interrupt = INTERRUPT_TX;
    transmit();
}

static void interrupts_off(void)
{
    __asm volatile("cpsid i" ::: "memory");
}

static void interrupts_on(void)
{
    __asm volatile("cpsie i" ::: "memory");
}

/* -- the HAL (servos and encoders are in simulated_joints.c) ------------------------------------------------------- */

uint32_t hal_time_us(void)
{
    return COUNTER;
}

/* Different at each reset: how many there were, and how the processor's and the counter's clocks lie to each other. */
uint32_t hal_random(void)
{
    uint32_t mixed = 0x811C9DC5u ^ kept.resets;
    for (uint32_t i = 0u; i < 256u; i++) {
        const uint32_t start = COUNTER;
        uint32_t turns = 0u;
        while (COUNTER == start) {
            turns++;
        }
        mixed = (mixed ^ turns) * 0x01000193u;
        mixed ^= mixed >> 15;
    }
    return mixed;
}

uint32_t hal_serial_read(uint8_t *data, uint32_t most)
{
    const uint32_t there = rx_end - rx_begin;
    if (there > RX_BYTES) { /* the main loop was elsewhere for too long: what was overwritten is gone */
        rx_begin = rx_end - RX_BYTES;
    }
    uint32_t length = 0u;
    while ((length < most) && (rx_begin != rx_end)) {
        data[length] = rx[rx_begin % RX_BYTES];
        length++;
        rx_begin++;
    }
    return length;
}

void hal_serial_write(const uint8_t *data, uint32_t length)
{
    if (length > TX_BYTES - (tx_end - tx_begin)) {
        return;
    }
    for (uint32_t i = 0u; i < length; i++) {
        tx[(tx_end + i) % TX_BYTES] = data[i];
    }
    interrupts_off();
    tx_end += length;
    transmit();
    interrupts_on();
}

bool hal_can_read(struct sb_frame *frame)
{
    (void)frame;
    return false;
}

void hal_can_write(const struct sb_frame *frame)
{
    (void)frame;
}

static uint32_t kept_crc(void)
{
    return sb_crc32((const uint8_t *)&kept, offsetof(struct kept, crc));
}

bool hal_parameters_load(struct sb_parameters *parameters)
{
    *parameters = kept.parameters;
    return true;
}

void hal_parameters_save(const struct sb_parameters *parameters)
{
    kept.parameters = *parameters;
    kept.crc = kept_crc();
}

/* -- the program --------------------------------------------------------------------------------------------------- */

static void start_memory(void)
{
    if (kept.crc != kept_crc()) {
        memset(&kept, 0, sizeof kept);
    }
    kept.resets++;
    kept.crc = kept_crc();
}

static void start_hardware(void)
{
    PRESCALER = COUNTER_HZ / 1000000u - 1u;
    UART0->divider = CLOCK_HZ / BAUD;
    UART0->control = CONTROL_TX | CONTROL_RX | CONTROL_TX_INTERRUPT | CONTROL_RX_INTERRUPT;
    (void)UART0->data; /* the receiver starts with this read */
    NVIC_ENABLE = 3u;
    SYSTICK_RELOAD = CLOCK_HZ / 1000u - 1u;
    SYSTICK_CONTROL = 7u;
}

static void start_watchdog(void)
{
    WATCHDOG->lock = WATCHDOG_KEY;
    WATCHDOG->load = CLOCK_HZ / WATCHDOG_S_DIVISOR;
    WATCHDOG->control = WATCHDOG_NMI | WATCHDOG_RESET;
    WATCHDOG->lock = 0u;
    fed_us = hal_time_us();
}

/* Only where the main loop comes round, time goes on, and all that was due has been done: no interrupt may do it. */
static void feed_watchdog(void)
{
    const uint32_t now_us = hal_time_us();
    if ((now_us == fed_us) || (sb_board_idle_us(&board) == 0u)) {
        return;
    }
    WATCHDOG->lock = WATCHDOG_KEY;
    WATCHDOG->clear = 1u;
    WATCHDOG->lock = 0u;
    fed_us = now_us;
}

int main(void)
{
    static const float straight[SB_MAX_JOINTS];
    start_memory();
    start_hardware();
    config = simulated_board(JOINTS, 385u);
    simulated_joints_start(&config, straight, 0.03f);
    sb_board_reset(&board, &config);
    start_watchdog();
    for (;;) {
        sb_board_step(&board);
        feed_watchdog();
        /* A byte that comes in between the look and the sleep must still wake it: WFI does so with interrupts off. */
        interrupts_off();
        if ((rx_begin == rx_end) && (sb_board_idle_us(&board) > 0u)) {
            __asm volatile("wfi");
        }
        interrupts_on();
    }
}
