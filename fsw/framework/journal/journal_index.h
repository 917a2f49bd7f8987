// SPDX-License-Identifier: Apache-2.0
/// Index of the live records of a journal: a hash table with linear probing and without tombstones. Private
/// to the journal. A slot's address is valid until the next insertion or removal.
///
/// Time       O(1) expected, if at most three quarters of the slots are used.
#ifndef FSW_FRAMEWORK_JOURNAL_JOURNAL_INDEX_H
#define FSW_FRAMEWORK_JOURNAL_JOURNAL_INDEX_H

#include "fsw/framework/journal/journal.h"

/// Returns the slot of a record, or null.
journal_slot_t* journal_index_find(journal_slot_t* slots, size_t count, uint8_t table, uint32_t key);
/// Returns a slot for a record that has none yet. At least two slots must be free.
journal_slot_t* journal_index_insert(journal_slot_t* slots, size_t count, uint8_t table, uint32_t key);
/// Free a slot that is used.
void journal_index_remove(journal_slot_t* slots, size_t count, const journal_slot_t* slot);

#endif // FSW_FRAMEWORK_JOURNAL_JOURNAL_INDEX_H
