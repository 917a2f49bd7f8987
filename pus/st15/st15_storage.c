// SPDX-License-Identifier: Apache-2.0
#include "pus/st15/st15_storage.h"

#include "base/assertion.h"
#include "pus/st15/st15_internal.h"

#include <string.h>

#define PRINTABLE_FIRST 0x21U
#define PRINTABLE_LAST 0x7EU
#define STATE_SIZE 79U // Size of the persistent record of a store [octets].

uint32_t st15_blocks_of(const uint32_t size)
{
    return size / PUS_STORE_BLOCK;
}

/// True if a name consists of one or more printable characters, padded with NUL.
static bool is_name(const uint8_t* const name)
{
    uint8_t length = 0U;
    while ((length < PUS_NAME_SIZE) && (name[length] >= PRINTABLE_FIRST) &&
           (name[length] <= PRINTABLE_LAST)) {
        length++;
    }
    bool is_padded = length > 0U;
    for (uint8_t i = length; i < PUS_NAME_SIZE; i++) {
        is_padded = is_padded && (name[i] == 0U);
    }
    return is_padded;
}

bool st15_is_possible(const pus_storage_t* const storage, const pus_store_state_t* const state)
{
    const uint32_t blocks = st15_blocks_of(state->size);
    return is_name(state->name) && (blocks >= PUS_STORE_BLOCKS_MIN) &&
           (blocks <= storage->config.blocks_of_store) && (state->type <= PUS_STORE_BOUNDED) &&
           (state->virtual_channel < storage->config.virtual_channels);
}

uint8_t st15_find(const pus_storage_t* const storage, const uint8_t* const name)
{
    uint8_t number = 0U;
    while ((number < storage->config.store_count) &&
           (!storage->stores[number].state.is_there ||
            (memcmp(storage->stores[number].state.name, name, PUS_NAME_SIZE) != 0))) {
        number++;
    }
    return number;
}

bool st15_is_copying(const pus_storage_t* const storage, const uint8_t number)
{
    const pus_store_copy_t* const copy = &storage->copy;
    return copy->is_active && ((copy->source == number) || (copy->target == number));
}

// ---- Persistent records ----

static status_t put_state(const pus_storage_t* const storage, const uint8_t number,
                          const pus_store_state_t* const state)
{
    const pus_persistence_t* const persistence = storage->config.persistence;
    uint8_t record[STATE_SIZE];
    octet_writer_t writer = octet_writer(record, sizeof record);
    octet_write_u8(&writer, state->is_there ? 1U : 0U);
    octet_write_octets(&writer, state->name, PUS_NAME_SIZE);
    octet_write_u32(&writer, state->size);
    octet_write_u8(&writer, state->type);
    octet_write_u8(&writer, state->virtual_channel);
    octet_write_u8(&writer, state->is_enabled ? 1U : 0U);
    octet_write_u8(&writer, state->retrieval);
    octet_write_u8(&writer, state->priority);
    octet_write_u32(&writer, state->generation);
    octet_write_u64(&writer, state->tail);
    octet_write_u64(&writer, state->open_tag_ns);
    octet_write_u8(&writer, state->is_seeking ? 1U : 0U);
    octet_write_u64(&writer, state->open_cursor);
    octet_write_u64(&writer, state->range_cursor);
    octet_write_u64(&writer, state->range_end);
    octet_write_u64(&writer, state->from_ns);
    octet_write_u64(&writer, state->to_ns);
    FSW_ASSERT(!writer.failed && (writer.position == sizeof record));
    return (persistence == NULL)
               ? STATUS_OK
               : persistence->put(persistence->context, PUS_SERVICE_STORAGE, number, record, sizeof record);
}

static void read_state(octet_reader_t* const reader, pus_store_state_t* const state)
{
    state->is_there = octet_read_u8(reader) != 0U;
    (void)memcpy(state->name, octet_read_octets(reader, PUS_NAME_SIZE), PUS_NAME_SIZE);
    state->size            = octet_read_u32(reader);
    state->type            = octet_read_u8(reader);
    state->virtual_channel = octet_read_u8(reader);
    state->is_enabled      = octet_read_u8(reader) != 0U;
    state->retrieval       = octet_read_u8(reader);
    state->priority        = octet_read_u8(reader);
    state->generation      = octet_read_u32(reader);
    state->tail            = octet_read_u64(reader);
    state->open_tag_ns     = octet_read_u64(reader);
    state->is_seeking      = octet_read_u8(reader) != 0U;
    state->open_cursor     = octet_read_u64(reader);
    state->range_cursor    = octet_read_u64(reader);
    state->range_end       = octet_read_u64(reader);
    state->from_ns         = octet_read_u64(reader);
    state->to_ns           = octet_read_u64(reader);
}

status_t pus_storage_restore(pus_storage_t* const storage, const uint32_t key, const uint8_t* const octets,
                             const size_t size)
{
    FSW_ASSERT((storage != NULL) && ((octets != NULL) || (size == 0U)));
    const uint32_t number = key % PUS_STORE_SELECTION_KEY;
    const uint32_t kind   = key / PUS_STORE_SELECTION_KEY;
    if ((number >= storage->config.store_count) || (kind > 1U)) {
        return STATUS_NOT_FOUND;
    }
    if (kind == 1U) {
        return pus_selection_restore(&storage->stores[number].selection, octets, size);
    }
    if (size != STATE_SIZE) {
        return STATUS_INVALID;
    }
    pus_store_state_t state;
    octet_reader_t reader = octet_reader(octets, size);
    read_state(&reader, &state);
    const bool is_good = !state.is_there || (st15_is_possible(storage, &state) &&
                                             (state.retrieval <= (uint8_t)PUS_RETRIEVAL_RANGE));
    if (is_good) {
        storage->stores[number].state = state;
    }
    return is_good ? STATUS_OK : STATUS_INVALID;
}

/// Set up the log of a store according to its state.
static void adopt(pus_storage_t* const storage, const uint8_t number)
{
    pus_store_t* const store             = &storage->stores[number];
    const pus_store_state_t* const state = &store->state;
    const bool is_circular               = state->type == PUS_STORE_CIRCULAR;
    storage->is_stale[number]            = !state->is_there;
    if (!state->is_there) {
        return;
    }
    if (state->generation != store->log.generation) {
        pus_packet_store_create(&store->log, state->generation, (uint16_t)st15_blocks_of(state->size),
                                is_circular);
        store->is_failed = false;
        return;
    }
    pus_packet_store_change(&store->log, (uint16_t)st15_blocks_of(state->size), is_circular);
    if (state->tail > pus_packet_store_tail(&store->log)) {
        pus_packet_store_cut(&store->log, state->tail);
    }
}

status_t st15_replace(pus_storage_t* const storage, const uint8_t number, const pus_store_state_t* const next)
{
    const status_t status = put_state(storage, number, next);
    if (status == STATUS_OK) {
        storage->stores[number].state = *next;
        adopt(storage, number);
    }
    return status;
}

// ---- Start ----

void pus_storage_init(pus_storage_t* const storage, const pus_storage_config_t* const config)
{
    FSW_ASSERT((storage != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->media != NULL) && (config->port.send != NULL) && (config->store_count > 0U) &&
               (config->store_count <= PUS_STORES_MAX) && (config->blocks != NULL) &&
               (config->entries != NULL) && (config->candidate != NULL) && (config->apids != NULL));
    (void)memset(storage, 0, sizeof *storage);
    storage->config = *config;
    storage->editor = (pus_selection_editor_t){.apids       = config->apids,
                                               .apid_count  = config->apid_count,
                                               .candidate   = config->candidate,
                                               .persistence = config->persistence,
                                               .table       = PUS_SERVICE_STORAGE};
    for (uint8_t i = 0U; i < config->store_count; i++) {
        pus_store_t* const store                   = &storage->stores[i];
        const pus_packet_store_config_t log_config = {
            .medium         = config->media[i],
            .blocks         = &config->blocks[(size_t)i * config->blocks_of_store],
            .block_capacity = config->blocks_of_store,
            .buffer         = storage->buffer};
        pus_packet_store_init(&store->log, &log_config);
        pus_selection_init(&store->selection, &config->entries[(size_t)i * config->entries_of_selection],
                           config->entries_of_selection);
    }
}

static uint64_t lesser(const uint64_t a, const uint64_t b)
{
    return (a < b) ? a : b;
}

status_t pus_storage_start(pus_storage_t* const storage)
{
    FSW_ASSERT(storage != NULL);
    status_t result = STATUS_OK;
    for (uint8_t i = 0U; i < storage->config.store_count; i++) {
        pus_store_t* const store       = &storage->stores[i];
        pus_store_state_t* const state = &store->state;
        const uint16_t limit           = (uint16_t)st15_blocks_of(state->size);
        const bool is_circular         = state->type == PUS_STORE_CIRCULAR;
        storage->is_stale[i]           = !state->is_there;
        if (!state->is_there) {
            continue;
        }
        if (pus_packet_store_open(&store->log, state->generation, limit, is_circular, state->tail) !=
            STATUS_OK) {
            pus_packet_store_create(&store->log, state->generation, limit, is_circular);
            store->is_failed = true;
            result           = STATUS_IO;
        } else if ((store->log.counters.damaged > 0U) && (result == STATUS_OK)) {
            result = STATUS_CHECKSUM;
        } else {
            // All packets can be read, or `result` already has the status of another store.
        }
        // The last packets before a power cut may not be on the medium: they are lost, and positions after
        // them move back.
        const uint64_t head = pus_packet_store_head(&store->log);
        state->open_cursor  = lesser(state->open_cursor, head);
        state->range_cursor = lesser(state->range_cursor, head);
        state->range_end    = lesser(state->range_end, head);
    }
    return result;
}

// ---- Storage ----

/// Round a time to the resolution on the wire, so that a request can contain exactly this time.
static uint64_t time_on_wire(const uint64_t time_ns)
{
    uint8_t octets[PUS_TIME_SIZE];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    pus_time_write(&writer, time_ns);
    octet_reader_t reader = octet_reader(octets, sizeof octets);
    uint64_t result       = 0U;
    const status_t status = pus_time_read(&reader, &result);
    FSW_ASSERT(status == STATUS_OK);
    return result;
}

void pus_storage_observe(pus_storage_t* const storage, const pus_tm_t* const tm, const uint8_t* const packet,
                         const size_t size, const uint64_t now_ns)
{
    FSW_ASSERT((storage != NULL) && (tm != NULL) && (packet != NULL));
    const uint64_t time_ns = time_on_wire(storage->config.process->epoch_ns + now_ns);
    for (uint8_t i = 0U; i < storage->config.store_count; i++) {
        pus_store_t* const store = &storage->stores[i];
        if (store->state.is_there && store->state.is_enabled && pus_selection_takes(&store->selection, tm) &&
            (store->is_failed ||
             (pus_packet_store_append(&store->log, time_ns, packet, size) != STATUS_OK))) {
            storage->counters.lost++;
        }
    }
}

/// Sync stored packets when the sync interval has passed.
static void sync_stores(pus_storage_t* const storage, const uint64_t now_ns)
{
    if ((now_ns - storage->synced_ns) >= storage->config.sync_interval_ns) {
        storage->synced_ns = now_ns;
        for (uint8_t i = 0U; i < storage->config.store_count; i++) {
            // The store counts a failure; a later sync tries again.
            (void)pus_packet_store_sync(&storage->stores[i].log);
        }
    }
}

/// Store the positions of retrievals when the checkpoint interval has passed.
static void store_positions(pus_storage_t* const storage, const uint64_t now_ns)
{
    const pus_persistence_t* const persistence = storage->config.persistence;
    status_t status                            = STATUS_OK;
    bool is_moved                              = false;
    if (!storage->is_checkpoint_due &&
        ((now_ns - storage->checkpoint_ns) < storage->config.checkpoint_interval_ns)) {
        return;
    }
    storage->is_checkpoint_due = false;
    for (uint8_t i = 0U; (i < storage->config.store_count) && (status == STATUS_OK); i++) {
        if (storage->stores[i].is_moved) {
            is_moved = true;
            status   = put_state(storage, i, &storage->stores[i].state);
        }
    }
    if (!is_moved) {
        return;
    }
    if ((status == STATUS_OK) && (persistence != NULL)) {
        status = persistence->commit(persistence->context);
    }
    storage->checkpoint_ns = now_ns;
    storage->counters.unkept += (status != STATUS_OK) ? 1U : 0U;
    for (uint8_t i = 0U; i < storage->config.store_count; i++) {
        storage->stores[i].is_moved = storage->stores[i].is_moved && (status != STATUS_OK);
    }
}

/// Release the media of deleted stores.
static void trim(pus_storage_t* const storage)
{
    for (uint8_t i = 0U; i < storage->config.store_count; i++) {
        if (storage->is_stale[i]) {
            const medium_t* const medium = &storage->config.media[i];
            storage->is_stale[i]         = medium->resize(medium->context, 0U) != STATUS_OK;
        }
    }
}

void pus_storage_step(pus_storage_t* const storage, const uint64_t now_ns)
{
    FSW_ASSERT(storage != NULL);
    trim(storage);
    st15_retrieve(storage);
    st15_copy(storage, now_ns);
    sync_stores(storage, now_ns);
    store_positions(storage, now_ns);
}

/// True if a store has a packet to send, or a medium to release.
static bool has_work(const pus_storage_t* const storage, const uint8_t number)
{
    const pus_store_t* const store       = &storage->stores[number];
    const pus_store_state_t* const state = &store->state;
    return storage->is_stale[number] || (state->retrieval == (uint8_t)PUS_RETRIEVAL_RANGE) ||
           ((state->retrieval == (uint8_t)PUS_RETRIEVAL_OPEN) &&
            (pus_packet_store_next_address(&store->log, state->open_cursor) <
             pus_packet_store_head(&store->log)));
}

uint64_t pus_storage_due_ns(const pus_storage_t* const storage, const uint64_t now_ns)
{
    FSW_ASSERT(storage != NULL);
    const uint64_t sync_ns = storage->synced_ns + storage->config.sync_interval_ns;
    const uint64_t keep_ns = storage->checkpoint_ns + storage->config.checkpoint_interval_ns;
    uint64_t due_ns        = storage->copy.is_active ? now_ns : UINT64_MAX;
    for (uint8_t i = 0U; i < storage->config.store_count; i++) {
        due_ns = has_work(storage, i) ? lesser(due_ns, now_ns) : due_ns;
        due_ns = storage->stores[i].log.is_dirty ? lesser(due_ns, sync_ns) : due_ns;
        due_ns = storage->stores[i].is_moved ? lesser(due_ns, keep_ns) : due_ns;
    }
    return due_ns;
}
