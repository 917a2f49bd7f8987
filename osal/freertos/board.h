// SPDX-License-Identifier: Apache-2.0
/// The boards MPS2 of Arm with the images AN385 (Cortex-M3) and AN500 (Cortex-M7): clock, timers, interrupts.
#ifndef OSAL_FREERTOS_BOARD_H
#define OSAL_FREERTOS_BOARD_H

#define BOARD_CLOCK_HZ 25000000U
#define BOARD_CLOCK_NS 40U           ///< One cycle of the clock and of the timers [ns].
#define BOARD_SYSCALL_PRIORITY 0x20U ///< Interrupts that call the kernel have this priority or a lower one.
#define BOARD_TIMER_PRIORITY 0x40U   ///< Priority of the two timers.
#define BOARD_INTERRUPTS 32U

#define BOARD_FREE_TIMER 0x40000000U ///< CMSDK timer 0: free-running, for the monotonic time.
#define BOARD_FREE_TIMER_IRQ 8U
#define BOARD_ALARM_TIMER 0x40001000U ///< CMSDK timer 1: wakes the tasks that wait for a time.
#define BOARD_ALARM_TIMER_IRQ 9U

#define BOARD_I2C 0x4002A000U ///< Arm SBCon of the second shield: lines of a bus I2C.

#define BOARD_WATCHDOG 0x40008000U ///< CMSDK watchdog. Its interrupt is the non-maskable one.

#endif // OSAL_FREERTOS_BOARD_H
