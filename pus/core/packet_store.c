// SPDX-License-Identifier: Apache-2.0
#include "pus/core/packet_store.h"

#include "base/assertion.h"
#include "base/crc.h"
#include "base/octets.h"

#include <string.h>

#define MAGIC 0x504B5331U // "PKS1"
#define HEADER_SIZE 20U
#define CLOSING_SIZE 36U
#define RECORDS_AT (HEADER_SIZE + CLOSING_SIZE) // Offset of the first record in a block.
#define CRC_SIZE 4U
#define NUMBER_MAX (1ULL << 48U) // Maximum number of blocks, so that addresses do not wrap.

// Layout of the buffer: the octets that the checksum covers but the medium does not contain, then a record.
#define SEED_SIZE 12U // Address and generation.
#define TIME_AT 14U
#define PACKET_AT 22U
#define FRAME_SIZE 14U // Size of a record around its packet: size, time and checksum.

void pus_packet_store_init(pus_packet_store_t* const store, const pus_packet_store_config_t* const config)
{
    FSW_ASSERT((store != NULL) && (config != NULL) && (config->blocks != NULL) && (config->buffer != NULL) &&
               (config->block_capacity >= PUS_STORE_BLOCKS_MIN));
    *store = (pus_packet_store_t){.config = *config, .first = 1U};
}

static pus_store_block_t* block_of(const pus_packet_store_t* const store, const uint64_t number)
{
    return &store->config.blocks[number % store->config.block_capacity];
}

static bool has_blocks(const pus_packet_store_t* const store)
{
    return store->last >= store->first;
}

static uint64_t address_of(const uint64_t number, const uint64_t offset)
{
    return (number * PUS_STORE_BLOCK) + offset;
}

static uint64_t number_of(const uint64_t address)
{
    return address / PUS_STORE_BLOCK;
}

/// Offset of an octet of a slot on the medium.
static uint64_t offset_on_medium(const uint16_t slot, const uint64_t offset)
{
    return ((uint64_t)slot * PUS_STORE_BLOCK) + offset;
}

void pus_packet_store_create(pus_packet_store_t* const store, const uint32_t generation, const uint16_t limit,
                             const bool is_circular)
{
    FSW_ASSERT((store != NULL) && (limit >= PUS_STORE_BLOCKS_MIN) && (limit <= store->config.block_capacity));
    (void)memset(store->config.blocks, 0, (size_t)store->config.block_capacity * sizeof(pus_store_block_t));
    store->generation  = generation;
    store->limit       = limit;
    store->is_circular = is_circular;
    store->is_dirty    = false;
    store->first       = 1U;
    store->last        = 0U;
    store->tail        = address_of(store->first, RECORDS_AT);
    store->newest_ns   = 0U;
}

uint16_t pus_packet_store_blocks_used(const pus_packet_store_t* const store)
{
    return (uint16_t)((store->last + 1U) - store->first);
}

void pus_packet_store_change(pus_packet_store_t* const store, const uint16_t limit, const bool is_circular)
{
    FSW_ASSERT((limit >= PUS_STORE_BLOCKS_MIN) && (limit <= store->config.block_capacity) &&
               (limit >= pus_packet_store_blocks_used(store)));
    store->limit       = limit;
    store->is_circular = is_circular;
}

uint64_t pus_packet_store_tail(const pus_packet_store_t* const store)
{
    return store->tail;
}

uint64_t pus_packet_store_head(const pus_packet_store_t* const store)
{
    return has_blocks(store) ? address_of(store->last, block_of(store, store->last)->end) : store->tail;
}

/// Count a failure of the medium. Returns the status unchanged.
static status_t count_failure(pus_packet_store_t* const store, const status_t status)
{
    store->counters.failed += (status != STATUS_OK) ? 1U : 0U;
    return status;
}

static status_t write_at(pus_packet_store_t* const store, const uint64_t offset, const uint8_t* const octets,
                         const size_t size)
{
    const medium_t* const medium = &store->config.medium;
    store->is_dirty              = true;
    return count_failure(store, medium->write(medium->context, offset, octets, size));
}

status_t pus_packet_store_sync(pus_packet_store_t* const store)
{
    const medium_t* const medium = &store->config.medium;
    const status_t status = store->is_dirty ? count_failure(store, medium->sync(medium->context)) : STATUS_OK;
    store->is_dirty       = store->is_dirty && (status != STATUS_OK);
    return status;
}

// ---- Records ----

/// Checksum of the record in the buffer, whose packet has `size` octets. The checksum also covers address and
/// generation, so that a record of an earlier store is not valid here.
static uint32_t checksum_of(const pus_packet_store_t* const store, const uint64_t address, const size_t size)
{
    uint8_t* const buffer = store->config.buffer;
    octets_put_u64(buffer, address);
    octets_put_u32(&buffer[sizeof(uint64_t)], store->generation);
    return crc32_iso(buffer, PACKET_AT + size);
}

/// Read a record at an address of a block whose records end at `end`. STATUS_OK, STATUS_CHECKSUM (no complete
/// record), STATUS_IO.
static status_t read_record(pus_packet_store_t* const store, const uint64_t address, const uint16_t slot,
                            const uint16_t end, pus_stored_packet_t* const out_packet)
{
    const medium_t* const medium = &store->config.medium;
    uint8_t* const buffer        = store->config.buffer;
    const uint64_t offset        = address % PUS_STORE_BLOCK;
    const size_t left            = (size_t)(end - offset);
    const size_t most = (left < (PUS_PACKET_MAX + FRAME_SIZE)) ? left : (PUS_PACKET_MAX + FRAME_SIZE);
    if (most <= FRAME_SIZE) {
        return STATUS_CHECKSUM;
    }
    const status_t status = count_failure(
        store, medium->read(medium->context, offset_on_medium(slot, offset), &buffer[SEED_SIZE], most));
    if (status != STATUS_OK) {
        return STATUS_IO;
    }
    const size_t size = octets_u16_at(&buffer[SEED_SIZE]);
    if ((size == 0U) || (size > (most - FRAME_SIZE)) ||
        (checksum_of(store, address, size) != octets_u32_at(&buffer[PACKET_AT + size]))) {
        return STATUS_CHECKSUM;
    }
    *out_packet = (pus_stored_packet_t){
        .time_ns = octets_u64_at(&buffer[TIME_AT]), .packet = &buffer[PACKET_AT], .size = size};
    return STATUS_OK;
}

static void note_packet(pus_store_block_t* const block, const uint64_t time_ns, const size_t size)
{
    if ((block->packets == 0U) || (time_ns < block->earliest_ns)) {
        block->earliest_ns = time_ns;
    }
    if ((block->packets == 0U) || (time_ns > block->latest_ns)) {
        block->latest_ns = time_ns;
    }
    block->packets++;
    block->end = (uint16_t)(block->end + size + FRAME_SIZE);
}

// ---- Blocks ----

static status_t write_header(pus_packet_store_t* const store, const uint16_t slot, const uint64_t number)
{
    uint8_t header[HEADER_SIZE];
    octet_writer_t writer = octet_writer(header, sizeof header);
    octet_write_u32(&writer, MAGIC);
    octet_write_u32(&writer, store->generation);
    octet_write_u64(&writer, number);
    octet_write_u32(&writer, crc32_iso(header, HEADER_SIZE - CRC_SIZE));
    return write_at(store, offset_on_medium(slot, 0U), header, sizeof header);
}

/// Write the closing of the newest block: its times, end and number of packets, so that pus_packet_store_open
/// does not need to read its records.
static status_t close_block(pus_packet_store_t* const store)
{
    const pus_store_block_t* const block = block_of(store, store->last);
    uint8_t closing[CLOSING_SIZE];
    octet_writer_t writer = octet_writer(closing, sizeof closing);
    octet_write_u32(&writer, store->generation);
    octet_write_u64(&writer, block->number);
    octet_write_u64(&writer, block->earliest_ns);
    octet_write_u64(&writer, block->latest_ns);
    octet_write_u16(&writer, block->end);
    octet_write_u16(&writer, block->packets);
    octet_write_u32(&writer, crc32_iso(closing, CLOSING_SIZE - CRC_SIZE));
    return write_at(store, offset_on_medium(block->slot, HEADER_SIZE), closing, sizeof closing);
}

static void free_block(pus_packet_store_t* const store)
{
    store->config.blocks[block_of(store, store->first)->slot].is_slot_taken = false;
    store->first++;
}

/// Returns the slot for a further block: the free slot with the lowest number.
static uint16_t free_slot(const pus_packet_store_t* const store)
{
    uint16_t slot = 0U;
    while (store->config.blocks[slot].is_slot_taken) {
        slot++;
        FSW_ASSERT(slot < store->config.block_capacity); // There are fewer blocks than slots.
    }
    return slot;
}

/// Delete the oldest block, to make room for a new one.
static void overwrite_oldest(pus_packet_store_t* const store)
{
    store->counters.overwritten += block_of(store, store->first)->packets;
    free_block(store);
    const uint64_t oldest = address_of(store->first, RECORDS_AT);
    store->tail           = (oldest > store->tail) ? oldest : store->tail;
}

/// Begin a further block. STATUS_OK; STATUS_FULL or STATUS_IO: no block was begun.
static status_t begin_block(pus_packet_store_t* const store)
{
    const bool is_full = pus_packet_store_blocks_used(store) >= store->limit;
    if (is_full && !store->is_circular) {
        store->counters.refused++;
        return STATUS_FULL;
    }
    // The earlier blocks are synced before the header of the next one is written: after a power cut only the
    // newest block can be incomplete.
    status_t status = has_blocks(store) ? close_block(store) : STATUS_OK;
    status          = (status == STATUS_OK) ? pus_packet_store_sync(store) : status;
    if (status != STATUS_OK) {
        return status;
    }
    if (is_full) {
        overwrite_oldest(store);
    }
    const uint16_t slot   = free_slot(store);
    const uint64_t number = store->last + 1U;
    status                = write_header(store, slot, number);
    status                = (status == STATUS_OK) ? pus_packet_store_sync(store) : status;
    if (status == STATUS_OK) {
        pus_store_block_t* const block = block_of(store, number);
        // In entry i, `is_slot_taken` is about slot i, so it stays when the block in the entry changes.
        const bool is_slot_taken = block->is_slot_taken;
        *block                   = (pus_store_block_t){
                              .number = number, .end = RECORDS_AT, .slot = slot, .is_slot_taken = is_slot_taken};
        store->config.blocks[slot].is_slot_taken = true;
        store->last                              = number;
    }
    return status;
}

status_t pus_packet_store_append(pus_packet_store_t* const store, const uint64_t time_ns,
                                 const uint8_t* const packet, const size_t size)
{
    FSW_ASSERT((packet != NULL) && (size > 0U) && (size <= PUS_PACKET_MAX) && (store->limit > 0U));
    if (!has_blocks(store) || ((block_of(store, store->last)->end + size + FRAME_SIZE) > PUS_STORE_BLOCK)) {
        const status_t status = begin_block(store);
        if (status != STATUS_OK) {
            return status;
        }
    }
    pus_store_block_t* const block = block_of(store, store->last);
    uint8_t* const buffer          = store->config.buffer;
    (void)memmove(&buffer[PACKET_AT], packet, size);
    octets_put_u16(&buffer[SEED_SIZE], (uint16_t)size);
    octets_put_u64(&buffer[TIME_AT], time_ns);
    octets_put_u32(&buffer[PACKET_AT + size], checksum_of(store, address_of(store->last, block->end), size));
    const status_t status =
        write_at(store, offset_on_medium(block->slot, block->end), &buffer[SEED_SIZE], size + FRAME_SIZE);
    if (status == STATUS_OK) {
        note_packet(block, time_ns, size);
        store->newest_ns = time_ns;
        store->counters.stored++;
    }
    return status;
}

// ---- Reading ----

uint64_t pus_packet_store_next_address(const pus_packet_store_t* const store, const uint64_t cursor)
{
    return (cursor > store->tail) ? cursor : store->tail;
}

/// True if there is a record at or after an address; *address then moves to the block of this record.
static bool is_there(const pus_packet_store_t* const store, uint64_t* const address)
{
    *address = pus_packet_store_next_address(store, *address);
    if (*address >= pus_packet_store_head(store)) {
        return false;
    }
    const uint64_t number = number_of(*address);
    if (*address >= address_of(number, block_of(store, number)->end)) {
        *address = address_of(number + 1U, RECORDS_AT);
    }
    // The previous block is full to its last octet, so the address is the start of the next one.
    if ((*address % PUS_STORE_BLOCK) < RECORDS_AT) {
        *address = address_of(number, RECORDS_AT);
    }
    return *address < pus_packet_store_head(store);
}

status_t pus_packet_store_next(pus_packet_store_t* const store, uint64_t* const cursor,
                               pus_stored_packet_t* const out_packet)
{
    FSW_ASSERT((store != NULL) && (cursor != NULL) && (out_packet != NULL));
    uint64_t address = *cursor;
    if (!is_there(store, &address)) {
        return STATUS_EMPTY;
    }
    const pus_store_block_t* const block = block_of(store, number_of(address));
    const status_t status                = read_record(store, address, block->slot, block->end, out_packet);
    if (status == STATUS_OK) {
        *cursor = address + out_packet->size + FRAME_SIZE;
    } else if (status == STATUS_CHECKSUM) {
        store->counters.damaged++;
        *cursor = address_of(block->number, block->end);
    } else {
        // STATUS_IO: the cursor stays, because a later read may succeed.
    }
    return status;
}

uint64_t pus_packet_store_seek(const pus_packet_store_t* const store, const uint64_t cursor,
                               const uint64_t from_ns, const uint64_t to_ns)
{
    uint64_t address = cursor;
    while (is_there(store, &address)) {
        const pus_store_block_t* const block = block_of(store, number_of(address));
        if ((block->latest_ns >= from_ns) && (block->earliest_ns <= to_ns)) {
            return address;
        }
        address = address_of(block->number, block->end);
    }
    return address;
}

uint64_t pus_packet_store_find(pus_packet_store_t* const store, const uint64_t from_ns)
{
    uint64_t cursor  = pus_packet_store_seek(store, store->tail, from_ns, UINT64_MAX);
    uint64_t address = cursor;
    pus_stored_packet_t packet;
    status_t status = pus_packet_store_next(store, &cursor, &packet);
    while ((status == STATUS_CHECKSUM) || ((status == STATUS_OK) && (packet.time_ns < from_ns))) {
        cursor  = pus_packet_store_seek(store, cursor, from_ns, UINT64_MAX);
        address = cursor;
        status  = pus_packet_store_next(store, &cursor, &packet);
    }
    return address;
}

uint64_t pus_packet_store_find_after(pus_packet_store_t* const store, const uint64_t time_ns)
{
    uint64_t address = store->tail;
    bool is_behind   = false; // True if a packet stored later than time_ns was found.
    while (!is_behind && is_there(store, &address)) {
        const pus_store_block_t* const block = block_of(store, number_of(address));
        uint64_t cursor                      = address;
        pus_stored_packet_t packet           = {.time_ns = 0U};
        if (block->latest_ns <= time_ns) {
            address = address_of(block->number, block->end);
        } else if ((pus_packet_store_next(store, &cursor, &packet) != STATUS_IO) &&
                   (packet.time_ns <= time_ns)) {
            address = cursor;
        } else {
            is_behind = true;
        }
    }
    return address;
}

void pus_packet_store_cut(pus_packet_store_t* const store, const uint64_t tail)
{
    uint64_t address = tail;
    store->tail      = is_there(store, &address) ? address : pus_packet_store_head(store);
    while ((store->first < store->last) && (number_of(store->tail) > store->first)) {
        free_block(store);
    }
}

uint64_t pus_packet_store_oldest_ns(pus_packet_store_t* const store)
{
    uint64_t cursor = store->tail;
    pus_stored_packet_t packet;
    return (pus_packet_store_next(store, &cursor, &packet) == STATUS_OK) ? packet.time_ns : 0U;
}

uint64_t pus_packet_store_newest_ns(const pus_packet_store_t* const store)
{
    return (store->tail < pus_packet_store_head(store)) ? store->newest_ns : 0U;
}

// ---- Recovery ----

/// Returns the number of octets of a slot that exist on the medium.
static size_t size_of_slot(const uint64_t medium_size, const uint16_t slot)
{
    const uint64_t begin = offset_on_medium(slot, 0U);
    const uint64_t left  = (medium_size > begin) ? (medium_size - begin) : 0U;
    return (size_t)((left < PUS_STORE_BLOCK) ? left : PUS_STORE_BLOCK);
}

/// Returns the number of the block in a header; 0 if the block does not belong to this store.
static uint64_t number_in_header(const pus_packet_store_t* const store, const uint8_t* const header)
{
    octet_reader_t reader     = octet_reader(header, HEADER_SIZE);
    const uint32_t magic      = octet_read_u32(&reader);
    const uint32_t generation = octet_read_u32(&reader);
    const uint64_t number     = octet_read_u64(&reader);
    const bool is_ours = (magic == MAGIC) && (generation == store->generation) && (number <= NUMBER_MAX) &&
                         (octet_read_u32(&reader) == crc32_iso(header, HEADER_SIZE - CRC_SIZE));
    return is_ours ? number : 0U;
}

/// Fill the index entry of a block from its closing; `end` stays 0 if the block was not closed.
static void read_closing(const pus_packet_store_t* const store, const uint8_t* const closing,
                         pus_store_block_t* const block)
{
    octet_reader_t reader     = octet_reader(closing, CLOSING_SIZE);
    const uint32_t generation = octet_read_u32(&reader);
    const uint64_t number     = octet_read_u64(&reader);
    const uint64_t earliest   = octet_read_u64(&reader);
    const uint64_t latest     = octet_read_u64(&reader);
    const uint16_t end        = octet_read_u16(&reader);
    const uint16_t packets    = octet_read_u16(&reader);
    if ((generation == store->generation) && (number == block->number) &&
        (octet_read_u32(&reader) == crc32_iso(closing, CLOSING_SIZE - CRC_SIZE))) {
        block->earliest_ns = earliest;
        block->latest_ns   = latest;
        block->end         = end;
        block->packets     = packets;
    }
}

/// Read the header in a slot. Enter its block in the index, unless the entry has a newer block.
static status_t look_at_slot(pus_packet_store_t* const store, const uint16_t slot, const size_t present)
{
    const medium_t* const medium = &store->config.medium;
    uint8_t* const octets        = store->config.buffer;
    (void)memset(octets, 0, RECORDS_AT);
    const size_t size = (present < RECORDS_AT) ? present : RECORDS_AT;
    const status_t status =
        count_failure(store, medium->read(medium->context, offset_on_medium(slot, 0U), octets, size));
    const uint64_t number          = (status == STATUS_OK) ? number_in_header(store, octets) : 0U;
    pus_store_block_t* const block = block_of(store, number);
    if (number > block->number) {
        *block = (pus_store_block_t){.number = number, .slot = slot};
        read_closing(store, &octets[HEADER_SIZE], block);
        store->last = (number > store->last) ? number : store->last;
    }
    return status;
}

/// Determine the content of a block from its records.
static status_t scan_block(pus_packet_store_t* const store, pus_store_block_t* const block,
                           const uint64_t medium_size)
{
    const uint16_t present = (uint16_t)size_of_slot(medium_size, block->slot);
    pus_stored_packet_t packet;
    block->end      = RECORDS_AT;
    block->packets  = 0U;
    status_t status = STATUS_OK;
    while (status == STATUS_OK) {
        const uint16_t end = (present > block->end) ? present : block->end;
        status = read_record(store, address_of(block->number, block->end), block->slot, end, &packet);
        if (status == STATUS_OK) {
            note_packet(block, packet.time_ns, packet.size);
            store->newest_ns = packet.time_ns;
        }
    }
    return (status == STATUS_CHECKSUM) ? STATUS_OK : status;
}

/// Overwrite the octets after the last valid record; otherwise a reader could take old records after it for
/// valid ones.
static status_t wipe_rest(pus_packet_store_t* const store, const pus_store_block_t* const block,
                          const uint64_t medium_size)
{
    const size_t present = size_of_slot(medium_size, block->slot);
    status_t status      = STATUS_OK;
    (void)memset(store->config.buffer, 0, PUS_STORE_BUFFER_SIZE);
    for (size_t at = block->end; (at < present) && (status == STATUS_OK); at += PUS_STORE_BUFFER_SIZE) {
        const size_t left = present - at;
        status            = write_at(store, offset_on_medium(block->slot, at), store->config.buffer,
                          (left < PUS_STORE_BUFFER_SIZE) ? left : PUS_STORE_BUFFER_SIZE);
    }
    return (status == STATUS_OK) ? pus_packet_store_sync(store) : status;
}

/// Find the oldest block: go back from the newest one while block numbers are consecutive, but not beyond the
/// deleted packets.
static void find_first(pus_packet_store_t* const store, const uint64_t tail)
{
    store->first = store->last;
    while ((store->first > 1U) && (store->first > number_of(tail)) &&
           (block_of(store, store->first - 1U)->number == (store->first - 1U)) &&
           (pus_packet_store_blocks_used(store) < store->limit)) {
        store->first--;
    }
}

/// Count the blocks that cannot be read any more: their packets were not deleted, but a block between them
/// and the newest one is missing.
static void count_unreachable(pus_packet_store_t* const store, const uint64_t tail)
{
    const uint64_t oldest = (number_of(tail) > 1U) ? number_of(tail) : 1U;
    for (uint16_t i = 0U; i < store->config.block_capacity; i++) {
        const uint64_t number = store->config.blocks[i].number;
        const bool is_lost    = (number >= oldest) && (number < store->first) &&
                             (pus_packet_store_blocks_used(store) < store->limit);
        store->counters.damaged += is_lost ? 1U : 0U;
    }
}

/// Read the existing blocks. STATUS_OK, STATUS_IO, STATUS_FULL.
static status_t recover(pus_packet_store_t* const store, const uint64_t tail)
{
    const medium_t* const medium = &store->config.medium;
    uint64_t medium_size         = 0U;
    status_t status              = count_failure(store, medium->size(medium->context, &medium_size));
    for (uint16_t slot = 0U; (status == STATUS_OK) && (slot < store->config.block_capacity) &&
                             (size_of_slot(medium_size, slot) > 0U);
         slot++) {
        status = look_at_slot(store, slot, size_of_slot(medium_size, slot));
    }
    if ((status != STATUS_OK) || !has_blocks(store)) {
        return status;
    }
    find_first(store, tail);
    count_unreachable(store, tail);
    for (uint64_t number = store->first; (number <= store->last) && (status == STATUS_OK); number++) {
        pus_store_block_t* const block                  = block_of(store, number);
        store->config.blocks[block->slot].is_slot_taken = true;
        if ((number == store->last) || (block->end == 0U)) {
            store->newest_ns = (number > store->first) ? block_of(store, number - 1U)->latest_ns : 0U;
            status           = scan_block(store, block, medium_size);
        }
    }
    return (status == STATUS_OK) ? wipe_rest(store, block_of(store, store->last), medium_size) : status;
}

status_t pus_packet_store_open(pus_packet_store_t* const store, const uint32_t generation,
                               const uint16_t limit, const bool is_circular, const uint64_t tail)
{
    pus_packet_store_create(store, generation, limit, is_circular);
    const status_t status = recover(store, tail);
    if (status != STATUS_OK) {
        return (status == STATUS_FULL) ? STATUS_FULL : STATUS_IO;
    }
    store->tail = address_of(store->first, RECORDS_AT);
    // The records before `tail` are lost, but were deleted anyway: continue at `tail`.
    if (tail > pus_packet_store_head(store)) {
        pus_packet_store_create(store, generation, limit, is_circular);
        store->first = number_of(tail) + 1U;
        store->last  = store->first - 1U;
        store->tail  = address_of(store->first, RECORDS_AT);
    } else {
        pus_packet_store_cut(store, tail);
    }
    return STATUS_OK;
}
