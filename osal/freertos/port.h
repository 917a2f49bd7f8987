// SPDX-License-Identifier: Apache-2.0
/// Private to this port: uses of the kernel's task notifications, limits, and functions that its files share.
#ifndef OSAL_FREERTOS_PORT_H
#define OSAL_FREERTOS_PORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PORT_NOTIFY_EVENT 0U ///< Entry of a task's notifications: an event was signalled.
#define PORT_NOTIFY_ALARM 1U ///< Entry of a task's notifications: the time for which the task waits has come.
#define PORT_NOTIFY_END 2U   ///< Entry of a task's notifications: a task that it joins has ended.
#define PORT_NOTIFY_GRANT 3U ///< Entry of a task's notifications: the scheduler of stepped time wakes it.

#define PORT_ARGUMENTS_MAX 16 ///< Arguments of main().
#define PORT_TLS_MAX 64U      ///< Octets of the thread-local variables of one task.

/// arguments.c: split the command line at its spaces. Takes the argument `wire=IN:OUT` for this port; the
/// list has the other arguments, which are for main(). Returns null, or the text of an error.
const char* port_take_arguments(char* line, char* list[PORT_ARGUMENTS_MAX + 1], int* out_count);
/// clock.c: start the timers, before the first task.
void port_clock_start(void);
/// tls.c: give a task its thread-local variables, in storage of PORT_TLS_MAX octets.
void port_tls_give(void* task, uint64_t storage[PORT_TLS_MAX / sizeof(uint64_t)]);

typedef struct {
    const char* name; ///< Name of the task, or "interrupts".
    size_t size;      ///< [octets]
    size_t used;      ///< Largest use since the start [octets].
} port_stack_t;
/// Tasks that osal_task_start can start at the same time.
#define PORT_STARTED_MAX 12U
/// Stacks of these tasks, of main, IDLE and the interrupts: there are no others.
#define PORT_STACKS_MAX (PORT_STARTED_MAX + 3U)
/// stacks.c: list the stacks of all tasks and of the interrupts. Returns their number. A task that was
/// started without osal_task_start is a coding error if there is no room for it: no stack is left out.
size_t port_stacks(port_stack_t list[PORT_STACKS_MAX]);
/// True if at least an eighth of the stack was never used.
bool port_has_margin(const port_stack_t* stack);
/// Print each stack for which port_has_margin is false.
void port_print_stacks(void);
/// stacks.c: mark the stack of the interrupts as unused. Called before the first task starts.
void port_paint_stack(void);

/// watchdog.c: find out whether the watchdog has caused this start. Called before the first task starts.
void port_watchdog_take_note(void);

/// process.c: end the program.
void port_exit(int code) __attribute__((noreturn));

#endif // OSAL_FREERTOS_PORT_H
