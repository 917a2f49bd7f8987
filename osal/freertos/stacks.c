// SPDX-License-Identifier: Apache-2.0
// Use of the stacks. The kernel fills the stack of each task with a known octet, and port_paint_stack that of
// the interrupts; octets that still have this value were never used.
#include "osal/freertos/port.h"

#include "base/assertion.h"
#include "base/text.h"
#include "osal/include/osal/console.h"

#include <FreeRTOS.h>
#include <task.h>

#define TASKS_MAX (PORT_STACKS_MAX - 1U) ///< The last stack is that of the interrupts.
#define LINE_MAX 128U
#define PAINT 0xA5A5A5A5U
#define WORDS_NEAR 32U ///< Words below the frame of port_paint_stack that it may itself use.
#define MARGIN 8U      ///< One part in MARGIN of each stack must stay unused.

extern uint32_t port_stack_top[];
extern uint32_t port_stack_begin[];

void port_paint_stack(void)
{
    const uint32_t* const here = __builtin_frame_address(0);
    for (uint32_t* word = port_stack_begin; word < &here[-(int)WORDS_NEAR]; word++) {
        *word = PAINT;
    }
}

static port_stack_t stack_of_interrupts(void)
{
    const uint32_t* word = port_stack_begin;
    while ((word < port_stack_top) && (*word == PAINT)) {
        word++;
    }
    return (port_stack_t){.name = "interrupts",
                          .size = (size_t)(port_stack_top - port_stack_begin) * sizeof(uint32_t),
                          .used = (size_t)(port_stack_top - word) * sizeof(uint32_t)};
}

size_t port_stacks(port_stack_t list[PORT_STACKS_MAX])
{
    static TaskStatus_t tasks[TASKS_MAX];
    const UBaseType_t count = uxTaskGetSystemState(tasks, TASKS_MAX, NULL);
    FSW_ASSERT(count > 0U); // 0: the kernel has more tasks than the list has room for.
    for (UBaseType_t i = 0U; i < count; i++) {
        const size_t words = (size_t)(tasks[i].pxEndOfStack - tasks[i].pxStackBase) +
                             2U; // pxEndOfStack is the address of the last 8 octets.
        list[i]      = (port_stack_t){.name = tasks[i].pcTaskName, .size = words * sizeof(StackType_t)};
        list[i].used = list[i].size - (tasks[i].usStackHighWaterMark * sizeof(StackType_t));
    }
    list[count] = stack_of_interrupts();
    return (size_t)count + 1U;
}

bool port_has_margin(const port_stack_t* const stack)
{
    return (stack->size - stack->used) >= (stack->size / MARGIN);
}

void port_print_stacks(void)
{
    port_stack_t stacks[PORT_STACKS_MAX];
    const size_t count = port_stacks(stacks);
    for (size_t i = 0U; i < count; i++) {
        char line[LINE_MAX];
        text_t text = text_in(line, sizeof line);
        text_add_pattern(&text, "the stack of % is too small: of # octets it used ", stacks[i].name, NULL,
                         stacks[i].size);
        text_add_unsigned(&text, stacks[i].used);
        if (!port_has_margin(&stacks[i])) {
            osal_console_print_error(line);
        }
    }
}
