// SPDX-License-Identifier: Apache-2.0
/// The services of the whole spacecraft: schedules, procedures, stores, files and others that exist once on
/// board and not in each subsystem. They belong to the supervisor; a binding (in the file <service>.c)
/// connects each of them to it.
///
/// A request that a service releases (from a schedule, a sequence, a procedure, an event-action) waits in
/// one queue, and is routed in the same step with the same checks as any request: known user, permission,
/// state. Its source stays unchanged. While its addressee has no credit, it and all later requests wait, for
/// at most SPACECRAFT_CREDIT_TIMEOUT_NS; then it and later ones to the same addressee are refused with
/// TM[1,10] (PUS_FAILURE_QUEUE_FULL) like requests from the ground.
#ifndef FSW_SUPERVISOR_SERVICES_SPACECRAFT_SERVICES_H
#define FSW_SUPERVISOR_SERVICES_SPACECRAFT_SERVICES_H

#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/message/message_ring.h"
#include "fsw/supervisor/telemetry_cache.h"
#include "fsw/supervisor/services/files.h"
#include "fsw/supervisor/services/large_packets.h"
#include "fsw/supervisor/services/memory.h"
#include "fsw/supervisor/services/procedures.h"
#include "fsw/supervisor/services/schedules.h"
#include "fsw/supervisor/services/sequences.h"
#include "fsw/supervisor/services/storage.h"
#include "fsw/supervisor/telemetry_directory.h"
#include "pus/core/packet.h"
#include "pus/core/persistence.h"
#include "pus/core/service.h"
#include "pus/st14/st14_forwarding.h"
#include "pus/st17/st17_test.h"

#define SPACECRAFT_SERVICES 12U          ///< Maximum number of bindings.
#define SPACECRAFT_RELEASE_OCTETS 65536U ///< Released requests that wait to be routed.
#define SPACECRAFT_CREDIT_TIMEOUT_NS 100000000ULL
#define SPACECRAFT_NEVER UINT64_MAX
/// Time after which a service sends packets again for which there was no room.
#define SPACECRAFT_RETRY_NS 1000000ULL

struct supervisor;

/// Functions that connect a service to the supervisor. A null function is not called.
typedef struct {
    uint8_t type; ///< Service type, and the table of its persistent records.
    /// Initialise without persistent records; returns the entry for the dispatcher, whose `step` is null.
    pus_service_t (*open)(struct supervisor* supervisor);
    /// Restore a persistent record. STATUS_OK, or the status with which the service refuses it.
    status_t (*restore)(struct supervisor* supervisor, uint32_t key, const uint8_t* octets, size_t size);
    /// Start the service, after all records have been restored. STATUS_OK, or the status for a
    /// RECORD_REFUSED event.
    status_t (*start)(struct supervisor* supervisor);
    /// Run the work that is due. Returns the time of the next wake [ns of the run], SPACECRAFT_NEVER if no
    /// work is planned.
    uint64_t (*step)(struct supervisor* supervisor, uint64_t now_ns);
    /// Process a report that was routed, also one of the supervisor itself. It may release requests, but
    /// must not send reports.
    void (*observe)(struct supervisor* supervisor, const pus_tm_t* tm, const uint8_t* packet, size_t size);
} spacecraft_binding_t;

#define SPACECRAFT_FORWARDING_ENTRIES 512U ///< Entries of ST[14]: types, structures and events.

typedef struct { // Private to fsw/supervisor.
    pus_forwarding_t service;
    uint16_t apids[MISSION_SUBSYSTEMS_MAX];
    pus_selection_entry_t entries[SPACECRAFT_FORWARDING_ENTRIES];
    pus_selection_entry_t candidate[SPACECRAFT_FORWARDING_ENTRIES];
} spacecraft_forwarding_t;

#define SPACECRAFT_CONNECTIONS 4U ///< On-board connection tests at the same time.
#define SPACECRAFT_CONNECTION_TIMEOUT_NS 1000000000ULL

typedef struct { // Private to fsw/supervisor: a running connection test.
    bool is_used;
    bool is_answered;
    uint16_t apid;
    uint64_t deadline_ns;
    pus_token_t token;
} spacecraft_connection_t;

typedef struct { // Private to fsw/supervisor.
    pus_test_t service;
    spacecraft_connection_t tests[SPACECRAFT_CONNECTIONS];
} spacecraft_connections_t;

// Private to fsw/supervisor. Storage of the services; each member belongs to the binding of its name.
typedef struct {
    pus_persistence_t persistence; // The journal.
    uint32_t refused;              // Events RECORD_REFUSED.
    // Time since which a subsystem has had no credit for waiting requests; 0: it has credit.
    uint64_t full_since_ns[MISSION_SUBSYSTEMS_MAX];
    message_ring_t released;
    uint8_t release_storage[SPACECRAFT_RELEASE_OCTETS];
    uint8_t packet[PUS_PACKET_MAX];
    spacecraft_schedules_t schedules;
    spacecraft_sequences_t sequences;
    spacecraft_forwarding_t forwarding;
    spacecraft_files_t files;
    spacecraft_connections_t connections;
    spacecraft_storage_t storage;
    spacecraft_large_packets_t large_packets;
    spacecraft_memory_t memory; // Memories that ST[06] of the component accesses.
    spacecraft_procedures_t procedures;
    telemetry_directory_t directory;
    // Configuration whose structures are in the telemetry cache; 0: none.
    uint16_t defined[MISSION_SUBSYSTEMS_MAX];
    telemetry_cache_t cache; // Cache of the subsystems' parameters, for services that read them.
} spacecraft_services_t;

extern const spacecraft_binding_t spacecraft_time_schedule;
extern const spacecraft_binding_t spacecraft_position_schedule;
extern const spacecraft_binding_t spacecraft_event_action;
extern const spacecraft_binding_t spacecraft_sequences;
extern const spacecraft_binding_t spacecraft_files;
extern const spacecraft_binding_t spacecraft_forwarding;
extern const spacecraft_binding_t spacecraft_connection;
extern const spacecraft_binding_t spacecraft_storage;
extern const spacecraft_binding_t spacecraft_time;
extern const spacecraft_binding_t spacecraft_procedures;
extern const spacecraft_binding_t spacecraft_large_packets;

/// Returns the store for persistent records of services; null if there is none.
const pus_persistence_t* spacecraft_persistence(struct supervisor* supervisor);
/// Returns the number of entries that the descriptor grants a service of the whole spacecraft, at most the
/// capacity `most`; `most` if the descriptor does not define it.
uint16_t spacecraft_capacity(const struct supervisor* supervisor, uint8_t type, uint16_t most);
/// Open all bindings, and write their services to `services`, which has room for SPACECRAFT_SERVICES.
/// Returns their number.
size_t spacecraft_open(struct supervisor* supervisor, pus_service_t* services);
/// Restore the persistent records of all services, then start the services. A refused record, a journal that
/// cannot be read and a failed start are counted and reported by the event RECORD_REFUSED.
void spacecraft_restore(struct supervisor* supervisor);
/// Raise the event that a persistent record was not restored or not written.
void spacecraft_report_refused(struct supervisor* supervisor, uint8_t table, uint32_t key, status_t status);
/// Call in the first step: raise JOURNAL_DAMAGED and enter the fallback mode if persistent records were
/// lost.
void spacecraft_report_damage(struct supervisor* supervisor);
/// Step all services, then route the requests that they have released. Returns the time of the next wake.
uint64_t spacecraft_step(struct supervisor* supervisor, uint64_t now_ns);
/// Pass a report to all services that observe reports.
void spacecraft_observe(struct supervisor* supervisor, const pus_tm_t* tm, const uint8_t* packet,
                        size_t size);
/// True if ST[14] forwards this report to the ground. Other reports are still logged and stored.
bool spacecraft_forwards(struct supervisor* supervisor, const pus_tm_t* tm);
/// Function of a port (pus_port_t) through which services release requests; the context is the supervisor.
/// STATUS_OK, STATUS_FULL (try again later).
status_t spacecraft_release(void* context, const uint8_t* packet, size_t size);

#endif // FSW_SUPERVISOR_SERVICES_SPACECRAFT_SERVICES_H
