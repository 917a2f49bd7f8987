// SPDX-License-Identifier: Apache-2.0
/// Private to this port: uses of the task notifications of the kernel, limits, and what its files share.
#ifndef OSAL_FREERTOS_PORT_H
#define OSAL_FREERTOS_PORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PORT_NOTIFY_EVENT 0U ///< Entry of a task's notifications: an event was signalled.
#define PORT_NOTIFY_ALARM 1U ///< Its time has come.
#define PORT_NOTIFY_END 2U   ///< A task that it joins has ended.

#define PORT_ARGUMENTS_MAX 16 ///< Of main().
#define PORT_TLS_MAX 64U      ///< Octets of the variables that each task has of its own.

/// arguments.c: split the command line at its spaces. The argument `wire=IN:OUT` is for this port; the others
/// are for main(). Null, or the error text.
const char* port_take_arguments(char* line, char* list[PORT_ARGUMENTS_MAX + 1], int* out_count);
/// clock.c: start the timers, before the first task.
void port_clock_start(void);
/// tls.c: give a task its own variables, in storage of PORT_TLS_MAX octets.
void port_tls_give(void* task, uint64_t storage[PORT_TLS_MAX / sizeof(uint64_t)]);

typedef struct {
    const char* name; ///< Of the task, or "interrupts".
    size_t size;      ///< [octets]
    size_t used;      ///< The most that was ever used [octets].
} port_stack_t;
/// stacks.c: list the stacks of all tasks and of the interrupts. Returns their number.
size_t port_stacks(port_stack_t* list, size_t capacity);
/// An eighth of the stack was never used.
bool port_has_margin(const port_stack_t* stack);
/// Print each stack without that margin.
void port_print_stacks(void);
/// Before the first task: mark the stack of the interrupts as unused.
void port_paint_stack(void);

/// watchdog.c: before the first task: find out whether the watchdog has caused this start.
void port_watchdog_take_note(void);

/// process.c: end the program.
void port_exit(int code) __attribute__((noreturn));

#endif // OSAL_FREERTOS_PORT_H
