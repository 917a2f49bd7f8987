// SPDX-License-Identifier: Apache-2.0
/// One packet store of ST[15]: packets in the order in which they were stored, each with its storage time, on
/// a medium of its own. A full store deletes its oldest block if it is circular, and refuses packets if it is
/// bounded. Layout of the medium: docs/services/st15.md.
///
/// The medium is divided into blocks of PUS_STORE_BLOCK octets. The address of a packet is block number x
/// PUS_STORE_BLOCK + offset; it only grows, so the position of a reader stays valid when the store wraps. An
/// index in memory has the times of each block. A search for a time therefore reads only blocks that have
/// packets of that time, also after the clock has jumped.
///
/// Ownership  The caller provides index and buffer; all stores of a loop may share one buffer.
/// Context    One loop.
/// Time       Append O(size), and once a block two syncs and O(blocks); next O(size); seek O(blocks) in
///            memory; find and cut O(blocks) and the records of one block; open O(blocks).
#ifndef PUS_CORE_PACKET_STORE_H
#define PUS_CORE_PACKET_STORE_H

#include "base/medium.h"
#include "pus/core/packet.h"

#define PUS_STORE_BLOCK 16384U
#define PUS_STORE_BLOCKS_MIN 2U ///< Minimum number of blocks of a store.
/// Room for one packet with its record fields [octets].
#define PUS_STORE_BUFFER_SIZE (PUS_PACKET_MAX + 26U)

typedef struct { // Private: one block that has packets; its index is number % capacity.
    uint64_t number;
    uint64_t earliest_ns;
    uint64_t latest_ns;
    uint16_t end; // Offset after the last record.
    uint16_t packets;
    uint16_t slot;      // Position of the block on the medium.
    bool is_slot_taken; // In entry i of the index: slot i is taken, whatever block the entry is about.
} pus_store_block_t;

typedef struct {
    medium_t medium;
    pus_store_block_t* blocks; ///< Index: `block_capacity` entries.
    uint16_t block_capacity;   ///< At least PUS_STORE_BLOCKS_MIN.
    uint8_t* buffer;           ///< PUS_STORE_BUFFER_SIZE octets; valid until the next call.
} pus_packet_store_config_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_packet_store_config_t config;
    uint32_t generation;
    uint16_t limit; // Maximum number of blocks.
    bool is_circular;
    bool is_dirty;  // Octets were written since the last sync.
    uint64_t first; // Number of the oldest block.
    uint64_t last;  // Number of the newest block; less than `first` if there is none.
    uint64_t tail;  // Address of the oldest packet.
    uint64_t newest_ns;
    struct {
        uint32_t stored;      ///< Packets stored.
        uint32_t refused;     ///< Packets that a full bounded store refused.
        uint32_t overwritten; ///< Packets in the blocks that a circular store has deleted to make room.
        uint32_t failed;      ///< Calls of the medium that failed.
        /// Blocks that cannot be found any more, and reads of a block that cannot be read to its end.
        uint32_t damaged;
    } counters;
} pus_packet_store_t;

/// A packet that was read; `packet` points into the buffer.
typedef struct {
    uint64_t time_ns;
    const uint8_t* packet;
    size_t size;
} pus_stored_packet_t;

/// Prepare the structure; pus_packet_store_create or pus_packet_store_open must follow.
void pus_packet_store_init(pus_packet_store_t* store, const pus_packet_store_config_t* config);
/// Begin an empty store. generation: a number that no earlier store on this medium had. limit:
/// PUS_STORE_BLOCKS_MIN.. block_capacity blocks. The medium does not change.
void pus_packet_store_create(pus_packet_store_t* store, uint32_t generation, uint16_t limit,
                             bool is_circular);
/// Recover a store of this generation; packets before address `tail` have been deleted. STATUS_OK (with the
/// packets found), STATUS_IO, STATUS_FULL: the medium failed, the store must not be used.
MUST_USE status_t pus_packet_store_open(pus_packet_store_t* store, uint32_t generation, uint16_t limit,
                                        bool is_circular, uint64_t tail);
/// Change type or size. limit: at least the number of blocks in use.
void pus_packet_store_change(pus_packet_store_t* store, uint16_t limit, bool is_circular);
/// Returns the number of blocks in use.
uint16_t pus_packet_store_blocks_used(const pus_packet_store_t* store);

/// Store a packet of 1..PUS_PACKET_MAX octets; `packet` may point to the packet read last. STATUS_OK;
/// STATUS_FULL (a full bounded store, or no space on the medium) or STATUS_IO: the packet is not stored, but
/// a circular store may have deleted its oldest block.
MUST_USE status_t pus_packet_store_append(pus_packet_store_t* store, uint64_t time_ns, const uint8_t* packet,
                                          size_t size);
/// Make the stored packets persistent. STATUS_OK, STATUS_IO: try again.
status_t pus_packet_store_sync(pus_packet_store_t* store);

/// Return the address of the oldest packet (tail), and the address after the newest packet (head); equal if
/// the store is empty.
uint64_t pus_packet_store_tail(const pus_packet_store_t* store);
uint64_t pus_packet_store_head(const pus_packet_store_t* store);
/// Returns the address that a reader at `cursor` reads next: that of the oldest packet if the packet at
/// `cursor` was deleted, else `cursor`.
uint64_t pus_packet_store_next_address(const pus_packet_store_t* store, uint64_t cursor);
/// Read the packet at the cursor and move the cursor past it. STATUS_OK; STATUS_EMPTY (no packet there yet);
/// STATUS_CHECKSUM (the rest of the block is damaged; the cursor is after the block); STATUS_IO (the cursor
/// did not move).
MUST_USE status_t pus_packet_store_next(pus_packet_store_t* store, uint64_t* cursor,
                                        pus_stored_packet_t* out_packet);
/// Move a cursor over the blocks before the next one that can have a packet of from_ns..to_ns. Returns the
/// new cursor.
uint64_t pus_packet_store_seek(const pus_packet_store_t* store, uint64_t cursor, uint64_t from_ns,
                               uint64_t to_ns);
/// Returns the address of the first packet stored at from_ns or later, or of one before it that the medium
/// cannot read now; the head if there is none.
uint64_t pus_packet_store_find(pus_packet_store_t* store, uint64_t from_ns);
/// Returns the address after the oldest packets that were stored at time_ns or earlier: that of the first
/// later packet, or the head.
uint64_t pus_packet_store_find_after(pus_packet_store_t* store, uint64_t time_ns);
/// Delete the packets before an address.
void pus_packet_store_cut(pus_packet_store_t* store, uint64_t tail);
/// Storage times of the oldest and the newest packet; 0 if the store is empty, or the oldest cannot be read.
uint64_t pus_packet_store_oldest_ns(pus_packet_store_t* store);
uint64_t pus_packet_store_newest_ns(const pus_packet_store_t* store);

#endif // PUS_CORE_PACKET_STORE_H
