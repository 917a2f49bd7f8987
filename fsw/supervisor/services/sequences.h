// SPDX-License-Identifier: Apache-2.0
/// Storage of the request sequences of ST[21]. It has room for the largest capacity that a descriptor may
/// grant.
#ifndef FSW_SUPERVISOR_SERVICES_SEQUENCES_H
#define FSW_SUPERVISOR_SERVICES_SEQUENCES_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "pus/st21/st21_sequences.h"

#define SPACECRAFT_SEQUENCES DESCRIPTOR_SEQUENCES_MAX
#define SPACECRAFT_SEQUENCE_OCTETS 65535U ///< Largest size of the content of a sequence [octets].
/// Number of blocks of PUS_BLOCK_CHAIN_BLOCK octets for all sequences.
#define SPACECRAFT_SEQUENCE_BLOCKS 8192U

typedef struct { // Private to fsw/supervisor.
    pus_sequences_t service;
    pus_sequence_t sequences[SPACECRAFT_SEQUENCES];
    pus_sorted_index_node_t nodes[SPACECRAFT_SEQUENCES];
    pus_block_chains_t chains;
    uint64_t blocks[PUS_BLOCK_CHAIN_WORDS(SPACECRAFT_SEQUENCE_BLOCKS)];
    pool_slot_t slots[SPACECRAFT_SEQUENCE_BLOCKS];
} spacecraft_sequences_t;

#endif // FSW_SUPERVISOR_SERVICES_SEQUENCES_H
