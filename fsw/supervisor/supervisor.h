// SPDX-License-Identifier: Apache-2.0
/// The supervisor: a subsystem that controls the others. It routes and logs every packet, checks
/// permissions, monitors subsystems, processes and real-time networks, and reacts to errors (section 4.3 of
/// the paper that docs/glossary.md names).
///
///     spacecraft services   services/*.c
///     supervision           router.c, error_handling.c, link_manager.c, sequences.c, mission_service.c
///     platform abstraction  packet_log (database interface), supervisor_platform_t (processes),
///                           message endpoint (communication interface)
///
/// Ownership  The program provides supervisor_t (static) and all that the configuration points to.
/// Context    One loop; supervisor_step never blocks. It is woken by each message and every 10 ms.
#ifndef FSW_SUPERVISOR_SUPERVISOR_H
#define FSW_SUPERVISOR_SUPERVISOR_H

#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/journal/journal.h"
#include "fsw/framework/message/message.h"
#include "fsw/framework/subsystem/subsystem_core.h"
#include "fsw/supervisor/ground_backlog.h"
#include "fsw/supervisor/link_graph.h"
#include "fsw/supervisor/services/spacecraft_services.h"
#include "fsw/supervisor/orbit.h"
#include "fsw/supervisor/packet_log.h"
#include "fsw/supervisor/pending_table.h"
#include "fsw/supervisor/plan_runner.h"
#include "fsw/supervisor/recommission.h"
#include "fsw/supervisor/checkpoint.h"
#include "generated/supervisor_descriptor.h"
#include "pus/core/requester.h"
#include "pus/private/st130_rtlink.h"
#include "pus/private/st131_mission.h"

/// Octets of the record of a mode: mode, and time of its beginning [ns of the run].
#define SUPERVISOR_MODE_RECORD 9U
#define SUPERVISOR_OWN_EVENTS 16U ///< Largest number of its own events that wait for the end of the step.

/// Access to the processes, which the launcher manages. Orders are performed after the commit of their step;
/// if the supervisor dies at that moment, the next one may repeat one of them.
typedef struct {
    void* context;
    /// Start a new life of the process; its first step is `boot_ns` from now. Real-time links that it opens
    /// have epochs above `link_floor`. STATUS_OK, STATUS_EXISTS (it runs), STATUS_NOT_FOUND.
    status_t (*start)(void* context, uint16_t apid, uint32_t link_floor, uint64_t boot_ns);
    /// Let a process shut itself down. STATUS_OK, STATUS_NOT_FOUND.
    status_t (*stop)(void* context, uint16_t apid);
    /// End a process immediately because it hangs. Statuses as of `stop`.
    status_t (*kill)(void* context, uint16_t apid);
    bool (*is_running)(void* context, uint16_t apid);
    /// Returns the latest time of the next step that the process has promised [ns of the run]; 0: the
    /// launcher has found that it hangs; UINT64_MAX: there is no promise.
    uint64_t (*promise)(void* context, uint16_t apid);
    bool (*is_stop_requested)(void* context); ///< The program was asked to end (Ctrl-C).
    void (*finished)(void* context);          ///< The mission is shut down; the run may end.
} supervisor_platform_t;

/// Access to the descriptors of the subsystems, which define their telemetry; used once, at start.
typedef struct {
    void* context;
    /// Load the descriptor of a subsystem by its index in the mission; it is valid until the next call.
    /// Statuses of descriptor_load_subsystem. Null: the telemetry of other subsystems is unknown.
    status_t (*load)(void* context, uint16_t index, const subsystem_descriptor_t** out_descriptor);
} supervisor_descriptors_t;

typedef enum { // Process state in TM[131,9].
    PROCESS_STOPPED = 0,
    PROCESS_RUNNING = 1,
    PROCESS_LOST    = 2
} process_state_t;

typedef enum {
    DOUBT_NONE,
    DOUBT_SILENT, ///< No report for so long that the state may have changed.
    DOUBT_ASKED   ///< Reports arrive again, and the status was requested.
} doubt_t;

typedef enum { // Presumed state of a process for which an order is not performed yet.
    PRESUMED_NOTHING = 0,
    PRESUMED_RUNNING,
    PRESUMED_GONE
} presumed_t;

typedef struct { // Known data of one subsystem, which is the subject of each comment.
    const mission_subsystem_t* mission;
    process_state_t process;
    bool is_heard;     ///< The subsystem has reported since its process was started.
    bool is_restarted; ///< Its process was started more than once.
    state_t state;
    state_phase_t phase;
    uint16_t configuration;
    uint8_t restarts;     ///< Times that the process was started again after its death [wraps].
    uint8_t deaths;       ///< Deaths that count against its restart budget.
    bool is_start_due;    ///< The process must be started at restart_ns.
    uint64_t restart_ns;  ///< Time of the last start, or of the next one.
    state_t rested;       ///< Last rest state, other than ERROR_OPERATIONAL.
    uint16_t rested_with; ///< Configuration in that state.
    uint64_t error_ns;    ///< Time at which it last reported a change to ERROR_OPERATIONAL.
    recommission_t recommission;
    bool is_order_pending; ///< The order for the state `ordered` waits for room in its inbox.
    state_t ordered;
    pus_cause_t order_cause;
    struct {
        uint32_t request_id; ///< Request id of the last order; 0: none, or it was not sent.
        uint64_t time_ns;    ///< Time of the last order.
    } order;
    presumed_t presumed;     ///< See output_commit.c.
    uint64_t heard_ns;       ///< Time of its last report.
    uint64_t started_ns;     ///< Time of its last start, or of the last event SUBSYSTEM_SILENT about it.
    uint64_t interface_hash; ///< Hash of its descriptor, as last reported.
    uint64_t configuration_hash;
    bool is_interface_mismatched; ///< The interface hash differs from the one in the supervisor's mission.
    /// Its state was taken over from the previous supervisor and not yet compared with its report.
    bool is_state_adopted;
    bool are_links_adopted; ///< The same for its links.
    bool is_unresponsive;   ///< No packet was taken for too long: requests are refused immediately.
    doubt_t doubt;          ///< Whether its state may have changed without a report (doubt.c).
    struct {
        uint32_t request_id; ///< Request id of TC[129,4], if DOUBT_ASKED.
        uint64_t time_ns;    ///< Time of that request.
    } asked;
} registry_entry_t;

typedef struct { // An event of the supervisor itself that needs a reaction.
    uint16_t event_id;
    uint8_t severity;
    uint16_t subject; ///< Subsystem that it is about, or SUPERVISOR_APID.
} own_event_t;

typedef struct {
    const mission_descriptor_t* mission;
    const subsystem_descriptor_t* descriptor; ///< The supervisor's own descriptor.
    bool is_descriptor_valid;                 ///< See subsystem_config_t.
    message_endpoint_t* endpoint;
    supervisor_platform_t platform;
    supervisor_descriptors_t descriptors;
    const char* log_directory; ///< Directory of the packet log.
    bool has_log_writer;       ///< The packet log has a task that waits for the disk.
    uint32_t start_count;      ///< See subsystem_config_t.
    pus_file_store_t files;    ///< Files of ST[23] and of services that load by reference.
    /// Open journal with the persistent records of earlier lives; null: there are no persistent records.
    journal_t* journal;
    subsystem_services_t optional; ///< Services that the supervisor's descriptor lists.
    const medium_t* store_media;   ///< SPACECRAFT_STORES media for packet stores; null: stores are refused.
    bool is_endpoint_kept;         ///< The endpoint is the unchanged one of the supervisor that died.
    /// Number of records of the packet log in this run so far; used if there is no checkpoint.
    uint64_t log_records;
    /// Checkpoint for the next supervisor, with the data of the one that died; null: there is none.
    checkpoint_t* checkpoint;
    /// Copy a damaged checkpoint for analysis; the context is that of the platform. True if the copy was
    /// made. Null: no copy is made.
    bool (*keep_checkpoint)(void* context, const checkpoint_t* checkpoint);
} supervisor_config_t;

typedef enum { // Result of reading the checkpoint.
    ADOPTION_WHOLE = 0,
    ADOPTION_OLDER,  ///< The last commit is damaged; the previous one was used.
    ADOPTION_NOTHING ///< Both commits are damaged.
} adoption_damage_t;

typedef struct supervisor { // All fields are private.
    supervisor_config_t config;
    const mission_descriptor_t* mission;
    subsystem_t subsystem;
    uint64_t now_ns;
    uint64_t next_tick_ns; // Time of the next check of the subsystems, every 10 ms.
    bool has_begun;        // The first step is done.
    uint8_t mode;
    bool is_cut_off; // The previous flight ended without a shutdown, in the mode of the record `cut_off`.
    uint8_t cut_off[SUPERVISOR_MODE_RECORD];
    registry_entry_t registry[MISSION_SUBSYSTEMS_MAX];
    bool is_log_failure_reported;
    pending_table_t pending;
    pending_table_t own;  // Requests to the supervisor itself.
    pending_table_t left; // Requests in `own` that the previous supervisor began and that cannot continue.
    uint32_t lives;       // Number of supervisor lives in this run.
    bool is_adopted;      // Data were taken over from the previous supervisor, and this was not reported yet.
    // Data were taken over after the autostart: only the supervisor itself must be brought up.
    bool is_continued;
    adoption_damage_t checkpoint_damage;
    bool is_checkpoint_copied;
    uint8_t log_strategy; // First strategy of the packet log.
    packet_log_past_t log_past;
    checkpoint_state_t checkpoint_state; // The state that was adopted; later the one of the last commit.
    pus_requester_t requester;
    link_graph_t graph;
    link_session_t sessions[SUPERVISOR_LINK_SESSIONS];
    // APID of the end that must also close, by mission link number - 1; 0: none.
    uint16_t closings[MISSION_LINKS_MAX];
    link_edge_t accepted[MISSION_LINKS_MAX]; // Negotiated links, by mission link number - 1; link 0: none.
    uint32_t link_epoch;
    uint32_t link_transaction;
    // Properties of the last request on which both ends agreed, by mission link number - 1; for a renewal.
    pus_link_properties_t wanted[MISSION_LINKS_MAX];
    uint32_t renewed;                    // Bit n: link n + 1 was open and must be opened again.
    uint8_t renewals[MISSION_LINKS_MAX]; // Remaining attempts.
    plan_runner_t plans;
    own_event_t own_events[SUPERVISOR_OWN_EVENTS];
    uint16_t own_event_count;
    unsigned autostart_step;
    unsigned shutdown_step; // 0: there is no shutdown.
    uint64_t shutdown_ns;
    bool has_shutdown_token;
    pus_token_t shutdown_token;
    bool is_finished;
    pus_mission_t mission_service;
    pus_rtlink_t link_service;
    pus_service_t services[2U + SPACECRAFT_SERVICES];
    spacecraft_services_t spacecraft;
    // Members and links of the network that TM[131,11] reports at present.
    uint16_t network_members[LINK_GRAPH_MEMBERS];
    uint16_t network_links[LINK_GRAPH_EDGES];
    supervisor_status_t status;       // Published.
    supervisor_counters_t counters;   // Published.
    supervisor_blocks_t blocks;       // Published.
    uint32_t orbit_period_ms;         // Published.
    supervisor_orbit_t orbit;         // Published.
    orbit_t orbit_state;              // From which `orbit` is computed.
    supervisor_reactions_t reactions; // Published.
    supervisor_ground_t ground;       // Published.
    supervisor_messages_t messages;   // Published.
    ground_backlog_t ground_backlog;
    message_ring_t ground_kept; // Copy of the backlog for the next life.
    // Addressee of the next request from the ground, if it has no room for this request; 0: none.
    uint16_t held_for;
    uint64_t held_ns;               // Time since which `held_for` has had no room.
    message_ring_t outputs;         // Outputs of this step, and earlier ones that were not taken yet.
    uint32_t performed;             // Number of outputs of the last commit that were performed.
    uint64_t ground_moved_ns;       // Last time at which a waiting report was sent, or no report waited.
    bool is_ground_behind;          // Reports were dropped since the backlog was empty.
    bool is_ground_loss_unreported; // The loss was not reported yet.
    packet_log_t log;
    uint8_t ground_storage[GROUND_OCTETS];
    uint8_t output_storage[OUTPUT_COMMIT_OCTETS];
    uint8_t packet[PUS_PACKET_MAX];
} supervisor_t;

/// Initialise the supervisor and open the packet log. `supervisor` must be all zeros, like static storage at
/// the start of a program; it is not cleared here, because that would write several megabytes at start.
/// STATUS_OK, or the status of supervisor_packet_log_open.
MUST_USE status_t supervisor_init(supervisor_t* supervisor, const supervisor_config_t* config);
/// Process received messages and run the work that is due. Returns the time of the next wake [ns of the run].
uint64_t supervisor_step(supervisor_t* supervisor, uint64_t now_ns);
/// Returns the callbacks of the supervisor as a subsystem; they publish status and counters.
const subsystem_callbacks_t* supervisor_callbacks(void);
/// Write out and close the packet log.
void supervisor_close(supervisor_t* supervisor);
/// Call it instead of supervisor_close to end like a process that dies: close everything that is open. The
/// next supervisor takes over.
void supervisor_abandon(supervisor_t* supervisor);

#endif // FSW_SUPERVISOR_SUPERVISOR_H
