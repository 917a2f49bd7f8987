// SPDX-License-Identifier: Apache-2.0
/// Configuration of the kernel FreeRTOS: static memory only, preemptive, a tick of 1 ms.
#ifndef OSAL_FREERTOS_CONFIG_H
#define OSAL_FREERTOS_CONFIG_H

#include "osal/freertos/board.h"

#define configCPU_CLOCK_HZ BOARD_CLOCK_HZ
#define configTICK_RATE_HZ 1000U
#define configUSE_PREEMPTION 1
#define configUSE_TIME_SLICING 1
#define configUSE_PORT_OPTIMISED_TASK_SELECTION 0
#define configMAX_PRIORITIES 32 // osal/task.h has 100 priorities: several of them share one of the kernel.
#define configMINIMAL_STACK_SIZE 256
#define configMAX_TASK_NAME_LEN 12
#define configTICK_TYPE_WIDTH_IN_BITS TICK_TYPE_WIDTH_32_BITS
#define configIDLE_SHOULD_YIELD 1
#define configUSE_TICKLESS_IDLE 0

// All memory is static: the allocator of the kernel is not linked.
#define configSUPPORT_STATIC_ALLOCATION 1
#define configSUPPORT_DYNAMIC_ALLOCATION 0
#define configKERNEL_PROVIDED_STATIC_MEMORY 1

#define configUSE_MUTEXES 1 // With priority inheritance.
#define configUSE_RECURSIVE_MUTEXES 0
#define configUSE_COUNTING_SEMAPHORES 0
#define configUSE_TASK_NOTIFICATIONS 1
#define configTASK_NOTIFICATION_ARRAY_ENTRIES 4 // Their uses are in port.h.
#define configUSE_TIMERS 0
#define configUSE_CO_ROUTINES 0
#define configUSE_QUEUE_SETS 0
#define configQUEUE_REGISTRY_SIZE 0
#define configNUM_THREAD_LOCAL_STORAGE_POINTERS 1
#define configUSE_TRACE_FACILITY 1 // For osal_mutex_holder, which returns the number of a task.
#define configUSE_IDLE_HOOK 0
#define configUSE_TICK_HOOK 0
#define configCHECK_FOR_STACK_OVERFLOW 2
#define configRECORD_STACK_HIGH_ADDRESS 1

#define configKERNEL_INTERRUPT_PRIORITY 255U
#define configMAX_SYSCALL_INTERRUPT_PRIORITY BOARD_SYSCALL_PRIORITY
#define configCHECK_HANDLER_INSTALLATION 1

#define INCLUDE_vTaskDelay 1
#define INCLUDE_vTaskDelete 1
#define INCLUDE_vTaskSuspend 1
#define INCLUDE_vTaskPrioritySet 1
#define INCLUDE_uxTaskPriorityGet 1
#define INCLUDE_xTaskGetCurrentTaskHandle 1
#define INCLUDE_xSemaphoreGetMutexHolder 1
#define INCLUDE_xTaskGetSchedulerState 1
#define INCLUDE_uxTaskGetStackHighWaterMark 1

extern void fsw_assertion_failed(const char* file, int line);
#define configASSERT(condition)                                                                              \
    if (!(condition)) {                                                                                      \
        fsw_assertion_failed(__FILE__, __LINE__);                                                            \
    }

#define vPortSVCHandler SVC_Handler
#define xPortPendSVHandler PendSV_Handler
#define xPortSysTickHandler SysTick_Handler

#endif // OSAL_FREERTOS_CONFIG_H
