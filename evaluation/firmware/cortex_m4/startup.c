/*
 * Vector table and reset handler for an emulated Cortex-M4 (QEMU machine mps2-an386).
 * Switches the floating-point unit on and hands over to newlib's semihosting start-up.
 */
#include <stdint.h>

extern void _start(void);
extern uint32_t stack_top[];

void reset_handler(void);
void fault_handler(void);

typedef union {
    void (*handler)(void);
    uint32_t *stack;
} vector;

__attribute__((section(".vectors"), used)) static const vector vectors[16] = {
    {.stack = stack_top},        {.handler = reset_handler}, {.handler = fault_handler},
    {.handler = fault_handler}, {.handler = fault_handler}, {.handler = fault_handler},
    {.handler = fault_handler},
};

void reset_handler(void)
{
    /* CPACR: full access to coprocessors 10 and 11, which are the floating-point unit. */
    *(volatile uint32_t *)0xE000ED88U |= 0xFU << 20U;
    __asm volatile("dsb\n isb");
    _start();
}

void fault_handler(void)
{
    /* Semihosting SYS_EXIT with ADP_Stopped_RunTimeErrorUnknown: the emulator ends with 1. */
    __asm volatile("mov r0, #0x18\n ldr r1, =0x20023\n bkpt 0xAB");
    for (;;) {
    }
}
