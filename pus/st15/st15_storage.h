// SPDX-License-Identifier: Apache-2.0
/// ST[15] on-board storage and retrieval: packet stores, the selection of reports for each of them, and
/// retrieval. All 37 messages. Stores, retrieval, copies, persistent records and refusals:
/// docs/services/st15.md.
///
/// pus_storage_observe is called with every report on board. Each enabled store whose selection
/// (pus/core/report_selection.h) includes the report stores it with the time of the call. The packets are on
/// the medium after the next sync.
///
/// Ownership  The caller provides all objects to which the configuration points.
/// Context    One loop. `send` must not call functions of this service.
/// Time       Observe O(stores x log entries + size); step O(stores + slice); see pus/core/packet_store.h.
#ifndef PUS_ST15_ST15_STORAGE_H
#define PUS_ST15_ST15_STORAGE_H

#include "pus/core/packet_store.h"
#include "pus/core/report_selection.h"

#define PUS_STORES_MAX 32U
#define PUS_STORE_CIRCULAR 0U
#define PUS_STORE_BOUNDED 1U
#define PUS_STORE_SELECTION_KEY 256U ///< Key of the record of the first selection.

/// Port that sends retrieved packets.
typedef struct {
    void* context;
    /// Send a packet, which is copied. STATUS_OK, or any other status: the packet was refused, try again
    /// later.
    status_t (*send)(void* context, uint8_t virtual_channel, const uint8_t* packet, size_t size);
} pus_retrieval_port_t;

typedef struct {
    pus_app_process_t* process;       ///< Sends reports of completion; times are relative to its epoch.
    const medium_t* media;            ///< One for each store.
    uint8_t store_count;              ///< 1..PUS_STORES_MAX.
    uint16_t blocks_of_store;         ///< Blocks of the largest store, >= PUS_STORE_BLOCKS_MIN.
    pus_store_block_t* blocks;        ///< store_count x blocks_of_store entries.
    uint16_t entries_of_selection;    ///< 1..PUS_SELECTION_ENTRIES_MAX.
    pus_selection_entry_t* entries;   ///< store_count x entries_of_selection entries.
    pus_selection_entry_t* candidate; ///< entries_of_selection entries.
    const uint16_t* apids;            ///< Processes whose reports may be selected, each once.
    uint16_t apid_count;
    uint8_t virtual_channels; ///< Number of virtual channels, numbered from 0.
    pus_retrieval_port_t port;
    uint16_t packets_per_step;            ///< Largest number of packets that a step sends or copies, >= 1.
    uint32_t octets_per_step;             ///< A step ends when it has read this number of octets, >= 1.
    uint64_t sync_interval_ns;            ///< Time between syncs of stored packets; 0: in each step.
    uint64_t checkpoint_interval_ns;      ///< Time between checkpoints of retrievals; 0: in each step.
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
} pus_storage_config_t;

typedef enum { // Private.
    PUS_RETRIEVAL_NONE = 0,
    PUS_RETRIEVAL_OPEN,
    PUS_RETRIEVAL_RANGE
} pus_retrieval_t;

typedef struct { // Private: the persistent data of a store.
    bool is_there;
    uint8_t name[PUS_NAME_SIZE];
    uint32_t size;
    uint8_t type;
    uint8_t virtual_channel;
    bool is_enabled;
    uint8_t retrieval; // pus_retrieval_t.
    uint8_t priority;
    uint32_t generation;
    uint64_t tail; // Address of the oldest packet after the last deletion.
    uint64_t open_tag_ns;
    bool is_seeking;      // The open retrieval has not reached its start time tag yet.
    uint64_t open_cursor; // Addresses of the next packets, and of the end of the range.
    uint64_t range_cursor;
    uint64_t range_end;
    uint64_t from_ns;
    uint64_t to_ns;
} pus_store_state_t;

typedef struct { // Private, except `log.counters` and `sent`.
    pus_store_state_t state;
    pus_packet_store_t log;
    pus_selection_t selection;
    uint32_t sent;   ///< Packets retrieved and sent.
    bool is_failed;  // The medium could not be read at the start.
    bool is_moved;   // The retrieval has continued since the last checkpoint.
    bool is_waiting; // In this step the port has refused a packet, or there is no packet to send.
} pus_store_t;

typedef struct { // Private: the copy in progress.
    bool is_active;
    pus_token_t token;
    uint8_t source;
    uint8_t target;
    uint64_t cursor;
    uint64_t end;
    uint64_t from_ns;
    uint64_t to_ns;
    uint32_t copied;
} pus_store_copy_t;

typedef struct { // Private, except `counters` and `stores`: read-only, for telemetry.
    pus_storage_config_t config;
    pus_selection_editor_t editor;
    pus_store_copy_t copy;
    uint8_t last_served;           // Store that sent last.
    bool is_stale[PUS_STORES_MAX]; // The medium contains packets of a deleted store.
    uint64_t synced_ns;
    uint64_t checkpoint_ns;
    bool is_checkpoint_due; // A checkpoint is due, independent of the interval.
    pus_store_t stores[PUS_STORES_MAX];
    uint8_t buffer[PUS_STORE_BUFFER_SIZE];
    struct {
        uint32_t lost;    ///< Reports that could not be stored, counted for each store that selects them.
        uint32_t refused; ///< Sends that the port refused.
        uint32_t unkept;  ///< Checkpoints that could not be stored.
    } counters;
} pus_storage_t;

void pus_storage_init(pus_storage_t* storage, const pus_storage_config_t* config);
/// Restore a persistent record, between pus_storage_init and pus_storage_start. STATUS_OK; STATUS_NOT_FOUND
/// (no such store), STATUS_INVALID (malformed, or not possible in this configuration) or STATUS_EXHAUSTED
/// (the selection has too many entries): the service has not changed.
MUST_USE status_t pus_storage_restore(pus_storage_t* storage, uint32_t key, const uint8_t* octets,
                                      size_t size);
/// Recover the content of the stores. STATUS_OK; STATUS_CHECKSUM: some packets that were not deleted can no
/// longer be read; STATUS_IO: the medium of a store failed, and that store neither stores nor sends packets
/// until the next start.
MUST_USE status_t pus_storage_start(pus_storage_t* storage);
/// Store a report, whose decoded fields are in `tm`, in all stores that select it.
void pus_storage_observe(pus_storage_t* storage, const pus_tm_t* tm, const uint8_t* packet, size_t size,
                         uint64_t now_ns);
/// Send and copy a slice; sync stores and store checkpoints when they are due.
void pus_storage_step(pus_storage_t* storage, uint64_t now_ns);
/// Returns the time of the next step that has work [ns of the run]: now_ns or earlier if there is work now,
/// or if the port was busy; UINT64_MAX if there is no work until a report is stored or a request arrives.
uint64_t pus_storage_due_ns(const pus_storage_t* storage, uint64_t now_ns);
/// Entry of the service for a dispatcher. It has no `step`: the caller calls pus_storage_step once per cycle.
pus_service_t pus_storage_service(pus_storage_t* storage);

#endif // PUS_ST15_ST15_STORAGE_H
