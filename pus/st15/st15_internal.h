// SPDX-License-Identifier: Apache-2.0
/// Private to ST[15]: functions that its files share.
#ifndef PUS_ST15_ST15_INTERNAL_H
#define PUS_ST15_ST15_INTERNAL_H

#include "pus/st15/st15_storage.h"

/// Returns the number of blocks of a store of this size [octets].
uint32_t st15_blocks_of(uint32_t size);
/// True if name, size, type and virtual channel are possible in this configuration.
bool st15_is_possible(const pus_storage_t* storage, const pus_store_state_t* state);
/// Returns the number of the store of this name; store_count if there is none.
uint8_t st15_find(const pus_storage_t* storage, const uint8_t* name);
/// Store a new state of a store; on success it replaces the present state. Statuses of pus_persistence_t.put.
MUST_USE status_t st15_replace(pus_storage_t* storage, uint8_t number, const pus_store_state_t* next);
/// True if the copy in progress reads from or writes to this store, so that the store must not change.
bool st15_is_copying(const pus_storage_t* storage, uint8_t number);

/// Send a slice of each retrieval.
void st15_retrieve(pus_storage_t* storage);
/// Copy a slice; after the last one, report the end of the copy.
void st15_copy(pus_storage_t* storage, uint64_t now_ns);

#endif // PUS_ST15_ST15_INTERNAL_H
