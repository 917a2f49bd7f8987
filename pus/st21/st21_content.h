// SPDX-License-Identifier: Apache-2.0
/// Private to pus/st21/: the contents of sequences, and their persistent records.
#ifndef PUS_ST21_ST21_CONTENT_H
#define PUS_ST21_ST21_CONTENT_H

#include "pus/st21/st21_sequences.h"

#define NO_SEQUENCE PUS_SORTED_INDEX_NONE

typedef pus_sequences_t sequences_t;
typedef pus_sequence_t sequence_t;

/// True if the content of the sequence is complete.
bool sequences_is_loaded(const sequence_t* sequence);
/// Returns the slot of the loaded sequence with this identifier; NO_SEQUENCE if there is none.
uint16_t sequences_find(const sequences_t* self, uint64_t id);
/// Returns the first four octets of an identifier, for failures.
uint32_t sequences_detail(uint64_t id);
/// Load a sequence from octets, which begin at `offset` of the application data. PUS_DONE, PUS_REFUSED,
/// PUS_FAILED.
pus_reply_t sequences_load(sequences_t* self, uint64_t id, const uint8_t* octets, size_t size, size_t offset,
                           uint16_t* out_slot);
/// Load from a file. Replies of sequences_load.
pus_reply_t sequences_load_file(sequences_t* self, uint64_t id, const pus_file_name_t* name,
                                uint16_t* out_slot);
/// Delete a sequence and its records. Status of the port.
MUST_USE status_t sequences_unload(sequences_t* self, uint16_t slot);
/// Read the next request into `out_octets` (PUS_PACKET_MAX), and its delay [ticks]. Returns the size of the
/// request; 0 if it is not complete.
size_t sequences_read_entry(pus_block_chain_reader_t* reader, uint8_t* out_octets, int64_t* out_delay);
/// Reader at the first request of a sequence. *out_count: number of its requests.
pus_block_chain_reader_t sequences_entries(const sequence_t* sequence, uint8_t* out_count);

#endif // PUS_ST21_ST21_CONTENT_H
