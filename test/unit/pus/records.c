// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/records.h"

#include "unity.h"

#include <stdlib.h>
#include <string.h>

records_t records;

void records_start(void)
{
    for (size_t i = 0U; i < records.count; i++) {
        free(records.changes[i].octets);
    }
    memset(&records, 0, sizeof(records));
}

static void note(const uint8_t table, const uint32_t key, uint8_t* const octets, const size_t size)
{
    TEST_ASSERT_TRUE(records.count < RECORDS_MAX);
    records.changes[records.count] =
        (record_change_t){.table = table, .key = key, .size = size, .octets = octets};
    records.count++;
}

/// The last change of a record that came before `end`; null if there is none.
static const record_change_t* last_of(const uint8_t table, const uint32_t key, const size_t end)
{
    for (size_t i = end; i > 0U; i--) {
        if ((records.changes[i - 1U].table == table) && (records.changes[i - 1U].key == key)) {
            return &records.changes[i - 1U];
        }
    }
    return NULL;
}

static status_t put(void* const context, const uint8_t table, const uint32_t key, const uint8_t* const octets,
                    const size_t size)
{
    (void)context;
    TEST_ASSERT_TRUE(size <= PUS_RECORD_MAX);
    if (records.put_status != STATUS_OK) {
        if (records.refuse_after == 0U) {
            return records.put_status;
        }
        records.refuse_after--;
    }
    uint8_t* const copy = malloc(size + 1U); // Never null, even without an octet.
    TEST_ASSERT_NOT_NULL(copy);
    if (size > 0U) {
        memcpy(copy, octets, size);
    }
    note(table, key, copy, size);
    records.puts++;
    return STATUS_OK;
}

static status_t erase(void* const context, const uint8_t table, const uint32_t key)
{
    (void)context;
    const record_change_t* const last = last_of(table, key, records.count);
    if (records.erase_status != STATUS_OK) {
        return records.erase_status;
    }
    if ((last == NULL) || (last->octets == NULL)) {
        return STATUS_NOT_FOUND;
    }
    note(table, key, NULL, 0U);
    records.erasures++;
    return STATUS_OK;
}

static status_t commit(void* const context)
{
    (void)context;
    if (records.commit_status == STATUS_OK) {
        records.committed = records.count;
        records.commits++;
    }
    return records.commit_status;
}

const pus_persistence_t* records_port(void)
{
    static const pus_persistence_t port = {.put = put, .erase = erase, .commit = commit};
    return &port;
}

void records_cut(void)
{
    for (size_t i = records.committed; i < records.count; i++) {
        free(records.changes[i].octets);
    }
    records.count = records.committed;
}

size_t records_replay(const uint8_t table,
                      status_t (*const restore)(void* self, uint32_t key, const uint8_t* octets, size_t size),
                      void* const self)
{
    size_t replayed = 0U;
    for (size_t i = 0U; i < records.committed; i++) {
        const record_change_t* const change = &records.changes[i];
        if ((change->table == table) && (change->octets != NULL) &&
            (last_of(table, change->key, records.committed) == change)) {
            TEST_ASSERT_EQUAL(STATUS_OK, restore(self, change->key, change->octets, change->size));
            replayed++;
        }
    }
    return replayed;
}

const uint8_t* records_find(const uint8_t table, const uint32_t key, size_t* const out_size)
{
    const record_change_t* const last = last_of(table, key, records.count);
    *out_size                         = (last != NULL) ? last->size : 0U;
    return (last != NULL) ? last->octets : NULL;
}
