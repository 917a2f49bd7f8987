// SPDX-License-Identifier: Apache-2.0
/// Storage of the request sequences of ST[21]. Capacities are those of this mission class.
#ifndef FSW_SUPERVISOR_SERVICES_ONBOARD_SEQUENCES_H
#define FSW_SUPERVISOR_SERVICES_ONBOARD_SEQUENCES_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "pus/st21/st21_sequences.h"

#define ONBOARD_SEQUENCES DESCRIPTOR_SEQUENCES_MAX
#define ONBOARD_SEQUENCE_OCTETS 65535U ///< Of the content of a sequence, at most.
#define ONBOARD_SEQUENCE_BLOCKS 8192U  ///< Of PUS_CHAIN_BLOCK octets, for all of them.

typedef struct { // Private to fsw/supervisor.
    pus_sequences_t service;
    pus_sequence_t sequences[ONBOARD_SEQUENCES];
    pus_order_node_t nodes[ONBOARD_SEQUENCES];
    pus_chains_t chains;
    uint64_t blocks[PUS_CHAIN_WORDS(ONBOARD_SEQUENCE_BLOCKS)];
    pool_slot_t slots[ONBOARD_SEQUENCE_BLOCKS];
} onboard_sequences_t;

#endif // FSW_SUPERVISOR_SERVICES_ONBOARD_SEQUENCES_H
