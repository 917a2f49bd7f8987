// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/hand_over.h"

#include "base/assertion.h"
#include "osal/include/osal/shm.h"

#include <stddef.h>

#define MAGIC 0x48414E44U

typedef struct {
    uint32_t announced; // Octets or datagrams that the sender has announced [wraps].
    uint32_t taken;     // Octets or datagrams that the receiver has taken [wraps].
} direction_t;

typedef struct {
    uint32_t magic; // Written last by the device end: it marks the memory as complete.
    uint32_t is_present;
    uint32_t connection;
    uint32_t is_connected;
    uint32_t lost;
    direction_t to_flight;
    direction_t to_device;
} counts_t;

static uint32_t load(const uint32_t* const number)
{
    return __atomic_load_n(number, __ATOMIC_ACQUIRE);
}

static void store(uint32_t* const number, const uint32_t value)
{
    __atomic_store_n(number, value, __ATOMIC_RELEASE);
}

static direction_t* direction_of(const osal_hand_over_t* const hand_over, const bool is_received)
{
    counts_t* const counts = hand_over->shared;
    return (hand_over->is_device == is_received) ? &counts->to_device : &counts->to_flight;
}

status_t osal_hand_over_create(osal_hand_over_t* const hand_over, const char* const name)
{
    FSW_ASSERT((hand_over != NULL) && (name != NULL));
    *hand_over = (osal_hand_over_t)OSAL_HAND_OVER_CLOSED;
    osal_shm_t shm;
    const status_t status = osal_shm_create(&shm, name, sizeof(counts_t));
    if (status == STATUS_OK) {
        counts_t* const counts = osal_shm_address(&shm);
        *hand_over             = (osal_hand_over_t){.shared = counts, .is_device = true};
        store(&counts->is_present, 1U);
        store(&counts->magic, MAGIC);
    }
    return status;
}

status_t osal_hand_over_open(osal_hand_over_t* const hand_over, const char* const name)
{
    FSW_ASSERT((hand_over != NULL) && (name != NULL));
    *hand_over = (osal_hand_over_t)OSAL_HAND_OVER_CLOSED;
    osal_shm_t shm;
    const status_t status = osal_shm_open(&shm, name);
    if (status != STATUS_OK) {
        return status;
    }
    const counts_t* const counts = osal_shm_address(&shm);
    if ((osal_shm_size(&shm) < sizeof(counts_t)) || (load(&counts->magic) != MAGIC) ||
        (load(&counts->is_present) == 0U)) {
        osal_shm_close(&shm);
        return STATUS_NOT_FOUND;
    }
    hand_over->shared = osal_shm_address(&shm);
    return STATUS_OK;
}

void osal_hand_over_close(osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    if (hand_over->shared != NULL) {
        if (!hand_over->is_device) {
            store(&((counts_t*)hand_over->shared)->is_connected, 0U);
        }
        osal_shm_t shm = {.address = hand_over->shared, .size = sizeof(counts_t)};
        osal_shm_close(&shm);
    }
    *hand_over = (osal_hand_over_t)OSAL_HAND_OVER_CLOSED;
}

bool osal_hand_over_is_open(const osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    return hand_over->shared != NULL;
}

void osal_hand_over_begin(osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    if (hand_over->shared != NULL) {
        // Octets announced before this connection belong to an earlier one: do not wait for them.
        counts_t* const counts    = hand_over->shared;
        direction_t* const both[] = {&counts->to_flight, &counts->to_device};
        for (unsigned i = 0U; i < 2U; i++) {
            store(&both[i]->taken, load(&both[i]->announced));
        }
        store(&counts->connection, load(&counts->connection) + 1U);
        store(&counts->is_connected, 1U);
    }
}

bool osal_hand_over_is_connected(const osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    return (hand_over->shared != NULL) && (load(&((const counts_t*)hand_over->shared)->is_connected) != 0U);
}

uint32_t osal_hand_over_connection(const osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    return (hand_over->shared != NULL) ? load(&((const counts_t*)hand_over->shared)->connection) : 0U;
}

void osal_hand_over_set_present(osal_hand_over_t* const hand_over, const bool is_present)
{
    FSW_ASSERT(hand_over != NULL);
    if (hand_over->shared != NULL) {
        store(&((counts_t*)hand_over->shared)->is_present, is_present ? 1U : 0U);
    }
}

bool osal_hand_over_is_present(const osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    return (hand_over->shared == NULL) || (load(&((const counts_t*)hand_over->shared)->is_present) != 0U);
}

void osal_hand_over_announce(osal_hand_over_t* const hand_over, const uint32_t count)
{
    FSW_ASSERT(hand_over != NULL);
    if (hand_over->shared != NULL) {
        direction_t* const direction = direction_of(hand_over, false);
        store(&direction->announced, load(&direction->announced) + count);
    }
}

uint32_t osal_hand_over_due(const osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    if (hand_over->shared == NULL) {
        return 0U;
    }
    const direction_t* const direction = direction_of(hand_over, true);
    return load(&direction->announced) - load(&direction->taken);
}

void osal_hand_over_take(osal_hand_over_t* const hand_over, const uint32_t count)
{
    FSW_ASSERT(hand_over != NULL);
    if (hand_over->shared != NULL) {
        const uint32_t due           = osal_hand_over_due(hand_over);
        direction_t* const direction = direction_of(hand_over, true);
        store(&direction->taken, load(&direction->taken) + ((count < due) ? count : due));
    }
}

void osal_hand_over_give_up(osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    const uint32_t due = osal_hand_over_due(hand_over);
    if (due > 0U) {
        counts_t* const counts = hand_over->shared;
        store(&counts->lost, load(&counts->lost) + due);
        osal_hand_over_take(hand_over, due);
    }
}

uint32_t osal_hand_over_lost(const osal_hand_over_t* const hand_over)
{
    FSW_ASSERT(hand_over != NULL);
    return (hand_over->shared != NULL) ? load(&((const counts_t*)hand_over->shared)->lost) : 0U;
}
