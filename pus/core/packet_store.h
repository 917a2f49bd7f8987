// SPDX-License-Identifier: Apache-2.0
/// One packet store of ST[15]: packets in the order in which they were stored, each with its storage time, on
/// a medium of its own. Circular: a full store deletes its oldest block; bounded: it accepts no more. Layout
/// of the medium: docs/services/st15.md.
///
/// The medium is divided into blocks of PUS_STORE_BLOCK octets. The address of a packet is block number x
/// PUS_STORE_BLOCK + offset; it only grows, so the position of a reader stays valid when the store wraps.
/// Memory holds one entry for each block with its times, so a time is found without reading other blocks,
/// also after the clock has jumped.
///
/// Ownership  The caller places index and buffer; the buffer may serve all stores of a loop.
/// Context    One loop.
/// Time       Append O(size), and two syncs and O(blocks) once a block; next O(size); seek O(blocks) without
///            the medium; find and cut O(blocks) and one block's records; open O(blocks).
#ifndef PUS_CORE_PACKET_STORE_H
#define PUS_CORE_PACKET_STORE_H

#include "base/medium.h"
#include "pus/core/packet.h"

#define PUS_STORE_BLOCK 16384U
#define PUS_STORE_BLOCKS_MIN 2U ///< Minimum number of blocks of a store.
/// Room for one packet with its record fields [octets].
#define PUS_STORE_BUFFER_SIZE (PUS_PACKET_MAX + 26U)

typedef struct { // Private: one block that holds packets, at the place number % capacity.
    uint64_t number;
    uint64_t earliest_ns;
    uint64_t latest_ns;
    uint16_t end; // Offset after the last record.
    uint16_t packets;
    uint16_t slot;      // Index of its place on the medium.
    bool is_slot_taken; // True if the slot with this entry's index is taken.
} pus_store_block_t;

typedef struct {
    medium_t medium;
    pus_store_block_t* blocks; ///< Index: `block_capacity` entries.
    uint16_t block_capacity;   ///< >= PUS_STORE_BLOCKS_MIN.
    uint8_t* buffer;           ///< PUS_STORE_BUFFER_SIZE octets; valid until the next call.
} pus_packet_store_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_packet_store_config_t config;
    uint32_t generation;
    uint16_t limit; // Maximum number of blocks.
    bool is_circular;
    bool is_dirty;  // Written since the last sync.
    uint64_t first; // Number of the oldest block.
    uint64_t last;  // Number of the newest block; less than `first` if there is none.
    uint64_t tail;  // Address of the oldest packet.
    uint64_t newest_ns;
    struct {
        uint32_t stored;      ///< Packets.
        uint32_t refused;     ///< Packets a full bounded store did not take.
        uint32_t overwritten; ///< Packets that a circular store has overwritten by newer ones.
        uint32_t failed;      ///< Reads, writes and syncs that failed.
        uint32_t damaged;     ///< Blocks that could no longer be reached, or not read to their end.
    } counters;
} pus_packet_store_t;

/// A packet that was read; `packet` points into the buffer.
typedef struct {
    uint64_t time_ns;
    const uint8_t* packet;
    size_t size;
} pus_stored_packet_t;

void pus_packet_store_init(pus_packet_store_t* store, const pus_packet_store_config_t* config);
/// Begin an empty store. generation: never used before on this medium. limit: PUS_STORE_BLOCKS_MIN..
/// block_capacity blocks. Writes nothing.
void pus_packet_store_create(pus_packet_store_t* store, uint32_t generation, uint16_t limit,
                             bool is_circular);
/// Recover a store of this generation; packets before address `tail` have been deleted. STATUS_OK (with the
/// packets found), STATUS_IO, STATUS_FULL: the medium failed, the store must not be used.
MUST_USE status_t pus_packet_store_open(pus_packet_store_t* store, uint32_t generation, uint16_t limit,
                                        bool is_circular, uint64_t tail);
/// Change type or size. limit: at least the blocks in use.
void pus_packet_store_change(pus_packet_store_t* store, uint16_t limit, bool is_circular);
uint16_t pus_packet_store_blocks_used(const pus_packet_store_t* store);

/// Store a packet of 1..PUS_PACKET_MAX octets, which may be the one just read. STATUS_OK; STATUS_FULL (a full
/// bounded store, or no space on the medium), STATUS_IO: it is not stored.
MUST_USE status_t pus_packet_store_append(pus_packet_store_t* store, uint64_t time_ns, const uint8_t* packet,
                                          size_t size);
/// Make the stored packets persistent. STATUS_OK, STATUS_IO: try again.
status_t pus_packet_store_sync(pus_packet_store_t* store);

/// Address of the oldest packet, and address after the newest packet; equal if the store is empty.
uint64_t pus_packet_store_tail(const pus_packet_store_t* store);
uint64_t pus_packet_store_head(const pus_packet_store_t* store);
/// The address that a reader at *cursor reads next: the oldest packet if the packet there was deleted, else
/// *cursor.
uint64_t pus_packet_store_place(const pus_packet_store_t* store, uint64_t cursor);
/// Read the packet at the cursor and move the cursor past it. STATUS_OK; STATUS_EMPTY (no packet yet);
/// STATUS_CHECKSUM (the rest of the block is damaged: the cursor is after it); STATUS_IO (the cursor did not
/// move).
MUST_USE status_t pus_packet_store_next(pus_packet_store_t* store, uint64_t* cursor,
                                        pus_stored_packet_t* out_packet);
/// The place of a cursor, moved over all blocks without a packet of from_ns..to_ns.
uint64_t pus_packet_store_seek(const pus_packet_store_t* store, uint64_t cursor, uint64_t from_ns,
                               uint64_t to_ns);
/// Address of the first packet stored at from_ns or later; the head if there is none.
uint64_t pus_packet_store_find(pus_packet_store_t* store, uint64_t from_ns);
/// Address after the packets, from the oldest on, that were stored at time_ns or earlier.
uint64_t pus_packet_store_find_after(pus_packet_store_t* store, uint64_t time_ns);
/// Delete the packets before an address.
void pus_packet_store_cut(pus_packet_store_t* store, uint64_t tail);
/// Times of the oldest and the newest packet, 0 if there is none.
uint64_t pus_packet_store_oldest_ns(pus_packet_store_t* store);
uint64_t pus_packet_store_newest_ns(const pus_packet_store_t* store);

#endif // PUS_CORE_PACKET_STORE_H
