// SPDX-License-Identifier: Apache-2.0
/// Storage of ST[15] and ST[09] in the supervisor. The packets themselves are on the media of the stores.
#ifndef FSW_SUPERVISOR_SERVICES_STORAGE_H
#define FSW_SUPERVISOR_SERVICES_STORAGE_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "pus/st09/st09_time.h"
#include "pus/st15/st15_storage.h"

#define SPACECRAFT_STORES DESCRIPTOR_PACKET_STORES_MAX
#define SPACECRAFT_STORE_BLOCKS 4096U ///< Number of blocks of the largest store: 64 MiB.
#define SPACECRAFT_STORE_ENTRIES 256U ///< Number of entries of a store's selection.
#define SPACECRAFT_VIRTUAL_CHANNELS 8U
#define SPACECRAFT_RETRIEVAL_PACKETS 16U ///< Largest number of packets sent in one step.
#define SPACECRAFT_RETRIEVAL_OCTETS 65536U
/// Time between two syncs, and between two checkpoints of retrievals.
#define SPACECRAFT_STORE_INTERVAL_NS 1000000000ULL

typedef struct { // Private to fsw/supervisor.
    pus_storage_t service;
    bool is_started;
    uint16_t apids[MISSION_SUBSYSTEMS_MAX];
    medium_t media[SPACECRAFT_STORES];
    pus_store_block_t blocks[SPACECRAFT_STORES * SPACECRAFT_STORE_BLOCKS];
    pus_selection_entry_t entries[SPACECRAFT_STORES * SPACECRAFT_STORE_ENTRIES];
    pus_selection_entry_t candidate[SPACECRAFT_STORE_ENTRIES];
    pus_time_t time;
} spacecraft_storage_t;

#endif // FSW_SUPERVISOR_SERVICES_STORAGE_H
