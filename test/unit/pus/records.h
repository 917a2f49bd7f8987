// SPDX-License-Identifier: Apache-2.0
/// Lasting records of services under test, in memory: what was put and committed is there after a power cut.
#ifndef TEST_UNIT_PUS_RECORDS_H
#define TEST_UNIT_PUS_RECORDS_H

#include "pus/persistence.h"

#define RECORDS_MAX 40000U ///< Puts and erasures of a test.

typedef struct { // Private.
    uint8_t table;
    uint32_t key;
    size_t size;
    uint8_t* octets; // Null: erased.
} record_change_t;

typedef struct {
    status_t put_status;    ///< What `put` answers from now on; STATUS_OK lets it do its work.
    status_t erase_status;  ///< The same for `erase`,
    status_t commit_status; ///< and `commit`.
    unsigned refuse_after;  ///< Puts that succeed before put_status counts.
    unsigned puts;          ///< Records put.
    unsigned erasures;      ///< Records erased.
    unsigned commits;       ///< Commits that succeeded.
    size_t count;           ///< Private: changes so far,
    size_t committed;       ///< Private: and those that are lasting.
    record_change_t changes[RECORDS_MAX];
} records_t;

extern records_t records;

/// Forget everything; all calls succeed from now on.
void records_start(void);
const pus_persistence_t* records_port(void);
/// Cut the power: what was not committed is forgotten.
void records_cut(void);
/// Hand the records of a table to `restore`, in the order in which they were last put. Returns how many.
size_t records_replay(uint8_t table,
                      status_t (*restore)(void* self, uint32_t key, const uint8_t* octets, size_t size),
                      void* self);
/// The present record, committed or not, and its size; null if there is none.
const uint8_t* records_find(uint8_t table, uint32_t key, size_t* out_size);

#endif // TEST_UNIT_PUS_RECORDS_H
