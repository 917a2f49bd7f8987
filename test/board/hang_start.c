// SPDX-License-Identifier: Apache-2.0
// Linked to the program of a subsystem for a board: it hangs before its loop begins.
#include "fsw/programs/record_store.h"

status_t __wrap_record_store_open(record_store_t* store, component_runtime_t* runtime, journal_slot_t* slots,
                                  size_t capacity, bool waits);

status_t __wrap_record_store_open(record_store_t* const store, component_runtime_t* const runtime,
                                  journal_slot_t* const slots, const size_t capacity, const bool waits)
{
    (void)runtime;
    (void)slots;
    (void)capacity;
    (void)waits;
    while (store != NULL) {
    }
    return STATUS_IO;
}
