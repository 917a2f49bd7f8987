// SPDX-License-Identifier: Apache-2.0
// Thread-local variables (`__thread`): the compiler calls __aeabi_read_tp for their address.
#include "osal/freertos/port.h"

#include "base/assertion.h"

#include <FreeRTOS.h>
#include <string.h>
#include <task.h>

#define HEADER_OCTETS 8U // Octets before the variables, which the ABI of Arm reserves.

extern const uint8_t port_tls_begin[]; // Initial values of the variables that have some.
// Symbols of the linker script whose addresses are sizes [octets]: of the initial values, of all variables.
extern const uint8_t port_tls_values[];
extern const uint8_t port_tls_size[];

void* port_tls_of_task(void);
void* __aeabi_read_tp(void);

void port_tls_give(void* const task, uint64_t storage[PORT_TLS_MAX / sizeof(uint64_t)])
{
    const size_t values = (size_t)(uintptr_t)port_tls_values;
    const size_t size   = (size_t)(uintptr_t)port_tls_size;
    FSW_ASSERT((HEADER_OCTETS + size) <= PORT_TLS_MAX);
    (void)memset(storage, 0, PORT_TLS_MAX);
    (void)memcpy((uint8_t*)storage + HEADER_OCTETS, port_tls_begin, values);
    vTaskSetThreadLocalStoragePointer(task, 0, storage);
}

__attribute__((used)) void* port_tls_of_task(void)
{
    return pvTaskGetThreadLocalStoragePointer(NULL, 0);
}

/// The ABI permits this function to change r0 only, so it saves the other registers that a C function may
/// change.
__attribute__((naked)) void* __aeabi_read_tp(void)
{
    __asm__ volatile("push {r1-r3, r12, lr}\n"
                     "sub sp, #4\n" // The ABI requires a stack that is aligned to 8 octets.
                     "bl port_tls_of_task\n"
                     "add sp, #4\n"
                     "pop {r1-r3, r12, pc}\n");
}
