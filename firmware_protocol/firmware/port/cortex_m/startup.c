/* Vectors and what happens before main(): no library needed. */
#include <stdint.h>

extern uint32_t data_load[];
extern uint32_t data_start[];
extern uint32_t data_end[];
extern uint32_t bss_start[];
extern uint32_t bss_end[];
extern uint32_t stack_top;

int main(void);
void reset_handler(void);
void fault_handler(void);
void systick_handler(void);
void uart0_rx_handler(void);
void uart0_tx_handler(void);

#define AIRCR (*(volatile uint32_t *)0xE000ED0Cu)
#define AIRCR_RESET 0x05FA0004u

void reset_handler(void)
{
    const uint32_t data_words = (uint32_t)(((uintptr_t)data_end - (uintptr_t)data_start) / sizeof(uint32_t));
    const uint32_t bss_words = (uint32_t)(((uintptr_t)bss_end - (uintptr_t)bss_start) / sizeof(uint32_t));
    for (uint32_t i = 0u; i < data_words; i++) {
        data_start[i] = data_load[i];
    }
    for (uint32_t i = 0u; i < bss_words; i++) {
        bss_start[i] = 0u;
    }
    (void)main();
    fault_handler();
}

/*
 * A processor that has lost its way restarts: servos off, a new boot id, and the host knows. The NMI is the watchdog's: a
 * main loop that hangs comes here, interrupts off or not. Where even this does not run, the watchdog resets by itself.
 */
void fault_handler(void)
{
    AIRCR = AIRCR_RESET;
    for (;;) {
    }
}

typedef void (*handler)(void);

struct vectors {
    uint32_t *stack;
    handler exceptions[15];
    handler interrupts[32];
};

__attribute__((section(".vectors"), used)) static const struct vectors vectors = {
    .stack = &stack_top,
    .exceptions =
        {
            reset_handler, fault_handler, fault_handler, fault_handler, fault_handler,
            fault_handler, fault_handler, fault_handler, fault_handler, fault_handler,
            fault_handler, fault_handler, fault_handler, fault_handler, systick_handler,
        },
    .interrupts =
        {
            [0] = uart0_rx_handler, [1] = uart0_tx_handler, [2] = fault_handler,  [3] = fault_handler,
            [4] = fault_handler,    [5] = fault_handler,    [6] = fault_handler,  [7] = fault_handler,
            [8] = fault_handler,    [9] = fault_handler,    [10] = fault_handler, [11] = fault_handler,
            [12] = fault_handler,   [13] = fault_handler,   [14] = fault_handler, [15] = fault_handler,
            [16] = fault_handler,   [17] = fault_handler,   [18] = fault_handler, [19] = fault_handler,
            [20] = fault_handler,   [21] = fault_handler,   [22] = fault_handler, [23] = fault_handler,
            [24] = fault_handler,   [25] = fault_handler,   [26] = fault_handler, [27] = fault_handler,
            [28] = fault_handler,   [29] = fault_handler,   [30] = fault_handler, [31] = fault_handler,
        },
};
