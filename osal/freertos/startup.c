// SPDX-License-Identifier: Apache-2.0
// From reset to main(): prepare memory, coprocessor and timers, and start the task that runs main() with the
// arguments of the command line.
#include "osal/freertos/board.h"
#include "osal/freertos/port.h"
#include "osal/freertos/semihosting.h"

#include <FreeRTOS.h>
#include <string.h>
#include <task.h>

#define COPROCESSORS (*(volatile uint32_t*)0xE000ED88U) // CPACR
#define MAIN_STACK_OCTETS 32768U
#define LINE_MAX 512U
#define FAULT_CODE 134 // Exit code as for a failed assertion: SIGABRT.

extern uint64_t port_data_begin[];
extern uint64_t port_data_end[];
extern const uint64_t port_data_values[];
extern uint64_t port_bss_begin[];
extern uint64_t port_bss_end[];
extern uint32_t port_stack_top[];

int main(int argument_count, char* arguments[]);
void port_reset(void) __attribute__((noreturn));
void port_alarm_interrupt(void);
void port_free_interrupt(void);
void port_watchdog_interrupt(void);
void SVC_Handler(void);
void PendSV_Handler(void);
void SysTick_Handler(void);
void vApplicationStackOverflowHook(TaskHandle_t task, char* name);

static StackType_t main_stack[MAIN_STACK_OCTETS / sizeof(StackType_t)] __attribute__((aligned(8)));
static StaticTask_t main_task;
static uint64_t main_tls[PORT_TLS_MAX / sizeof(uint64_t)];
static char line[LINE_MAX];
static char* arguments_of_main[PORT_ARGUMENTS_MAX + 1];

static void fault(void)
{
    semihosting_print("the processor reports a fault\n");
    port_exit(FAULT_CODE);
}

typedef void (*handler_t)(void);
// Exceptions 2 to 15 and the interrupts of the two timers; all others are faults.
__attribute__((section(".vectors"), used)) static const handler_t vectors[16U + BOARD_INTERRUPTS] = {
    (handler_t)(uintptr_t)port_stack_top,
    port_reset,
    port_watchdog_interrupt, // The non-maskable interrupt.
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    fault,
    SVC_Handler,
    fault,
    fault,
    PendSV_Handler,
    SysTick_Handler,
    [16U + BOARD_FREE_TIMER_IRQ]  = port_free_interrupt,
    [16U + BOARD_ALARM_TIMER_IRQ] = port_alarm_interrupt,
};

void vApplicationStackOverflowHook(const TaskHandle_t task, char* const name)
{
    (void)task;
    semihosting_print("the stack of a task is too small: ");
    semihosting_print(name);
    semihosting_print("\n");
    port_exit(FAULT_CODE);
}

static void run_main(void* const context)
{
    (void)context;
    int count               = 0;
    const char* const error = semihosting_command_line(line, sizeof line)
                                  ? port_take_arguments(line, arguments_of_main, &count)
                                  : "the command line has more than 511 characters";
    if (error != NULL) {
        semihosting_print(error);
        semihosting_print("\n");
        port_exit(2);
    }
    const int code = main(count, arguments_of_main);
    port_print_stacks();
    port_exit(code);
}

void port_reset(void)
{
    size_t count = (size_t)(port_data_end - port_data_begin);
    for (size_t i = 0U; i < count; i++) {
        port_data_begin[i] = port_data_values[i];
    }
    count = (size_t)(port_bss_end - port_bss_begin);
    for (size_t i = 0U; i < count; i++) {
        port_bss_begin[i] = 0U;
    }
#ifdef __ARM_FP
    COPROCESSORS |= 0x00F00000U;
    __asm__ volatile("dsb\n isb");
#endif
    port_watchdog_take_note();
    port_paint_stack();
    port_clock_start();
    const TaskHandle_t task = xTaskCreateStatic(run_main, "main", sizeof main_stack / sizeof main_stack[0],
                                                NULL, 1U, main_stack, &main_task);
    port_tls_give(task, main_tls);
    vTaskStartScheduler();
    fault();
    for (;;) {
    }
}
