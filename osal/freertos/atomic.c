// SPDX-License-Identifier: Apache-2.0
// Atomic accesses to 64 bits. The processor has no instruction for them, so interrupts are disabled during
// each access. GCC generates calls of these functions for __atomic_load_n and similar built-in functions.
#include "osal/freertos/port.h"

#include <FreeRTOS.h>
#include <task.h>

typedef unsigned long long wide_t;

wide_t wide_load(const volatile void* object, int order) __asm__("__atomic_load_8");
void wide_store(volatile void* object, wide_t value, int order) __asm__("__atomic_store_8");
wide_t wide_exchange(volatile void* object, wide_t value, int order) __asm__("__atomic_exchange_8");
wide_t wide_add(volatile void* object, wide_t value, int order) __asm__("__atomic_fetch_add_8");
bool wide_compare(volatile void* object, void* expected, wide_t value, bool is_weak, int success,
                  int failure) __asm__("__atomic_compare_exchange_8");

static uint32_t begin(void)
{
    return (uint32_t)portSET_INTERRUPT_MASK_FROM_ISR();
}

static void end(const uint32_t mask)
{
    portCLEAR_INTERRUPT_MASK_FROM_ISR(mask);
}

wide_t wide_load(const volatile void* const object, const int order)
{
    (void)order;
    const uint32_t mask = begin();
    const wide_t value  = *(const volatile wide_t*)object;
    end(mask);
    return value;
}

void wide_store(volatile void* const object, const wide_t value, const int order)
{
    (void)order;
    const uint32_t mask       = begin();
    *(volatile wide_t*)object = value;
    end(mask);
}

wide_t wide_exchange(volatile void* const object, const wide_t value, const int order)
{
    (void)order;
    const uint32_t mask       = begin();
    const wide_t before       = *(volatile wide_t*)object;
    *(volatile wide_t*)object = value;
    end(mask);
    return before;
}

wide_t wide_add(volatile void* const object, const wide_t value, const int order)
{
    (void)order;
    const uint32_t mask       = begin();
    const wide_t before       = *(volatile wide_t*)object;
    *(volatile wide_t*)object = before + value;
    end(mask);
    return before;
}

bool wide_compare(volatile void* const object, void* const expected, const wide_t value, const bool is_weak,
                  const int success, const int failure)
{
    (void)is_weak;
    (void)success;
    (void)failure;
    const uint32_t mask = begin();
    const wide_t before = *(volatile wide_t*)object;
    const bool is_same  = (before == *(wide_t*)expected);
    if (is_same) {
        *(volatile wide_t*)object = value;
    }
    end(mask);
    *(wide_t*)expected = before;
    return is_same;
}
