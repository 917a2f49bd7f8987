// SPDX-License-Identifier: Apache-2.0
/// How a program stores and runs a generic subsystem (subsystem.h is for developers of specific subsystems).
///
///     subsystem_init(&component, &config);
///     for (;;) {
///         wait;
///         while (subsystem_may_accept(&component) && (a packet has come)) { subsystem_accept(...); }
///         wake = subsystem_step(&component, now);
///     }
///
/// Further loops of a configuration, for services: docs/framework.md, "Loops of services".
///
/// Ownership  The program provides subsystem_t (static; about 120 KiB) and all that the configuration points
///            to.
/// Context    One loop; subsystem_loop_step and subsystem_loop_priority may run in the task of their loop.
///            They block only for short critical sections with priority inheritance.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_CORE_H
#define FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_CORE_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/message/message_ring.h"
#include "fsw/framework/parameter/parameter.h"
#include "base/pool.h"
#include "fsw/framework/rtlink/link_channel.h"
#include "fsw/framework/subsystem/state_machine.h"
#include "fsw/framework/subsystem/subsystem.h"
#include "osal/include/osal/mutex.h"
#include "pus/core/service.h"
#include "pus/st03/st03_housekeeping.h"
#include "pus/st05/st05_events.h"
#include "pus/st08/st08_functions.h"
#include "pus/private/st129_management.h"
#include "pus/private/st130_rtlink.h"
#include "pus/st17/st17_test.h"
#include "pus/st20/st20_parameters.h"

// A build whose descriptors are compiled in defines the capacities up to the #endif with the numbers that its
// descriptors need.
#ifndef SUBSYSTEM_PARAMETERS
#define SUBSYSTEM_PARAMETERS DESCRIPTOR_PARAMETERS_MAX
#define SUBSYSTEM_BOUNDS DESCRIPTOR_FIELDS_MAX ///< Fields of all parameters.
#define SUBSYSTEM_EVENTS DESCRIPTOR_EVENTS_MAX
#define SUBSYSTEM_FUNCTIONS DESCRIPTOR_FUNCTIONS_MAX
#define SUBSYSTEM_ARGUMENTS 96U ///< Arguments of all functions.
#define SUBSYSTEM_ARGUMENT_WORDS 64U
#define SUBSYSTEM_STRUCTURES 16U      ///< Housekeeping structures, defined by the descriptor and by requests.
#define SUBSYSTEM_SAMPLE_OCTETS 1024U ///< Size of the values of one housekeeping report.
#define SUBSYSTEM_LOOPS DESCRIPTOR_CONFIGURATION_LOOPS_MAX ///< Loops of services, without the main loop.
#define SUBSYSTEM_LINKS CAPACITY_SUBSYSTEM_LINKS
#endif
#ifndef SUBSYSTEM_FUNCTIONAL
#define SUBSYSTEM_FUNCTIONAL 8U ///< Functional reporting definitions.
#endif
#define SUBSYSTEM_PORT_LINKS CAPACITY_PORT_LINKS ///< Readers of one provided port.
/// Function commands that run at the same time; the last entry is reserved for users on ground.
#define SUBSYSTEM_CALL_TOKENS 8U
#define SUBSYSTEM_SERVICES 24U
#define SUBSYSTEM_OPTIONAL_SERVICES DESCRIPTOR_SERVICES_MAX ///< See optional_services.h.
/// Free room that a mailbox must have before a request is performed, so that its reports fit: the longest
/// answer, and the reports of its verification. The application process of the loop keeps further reports in
/// as many octets.
#ifndef SUBSYSTEM_LOOP_ANSWER
#define SUBSYSTEM_LOOP_ANSWER (2U * PUS_PACKET_MAX)
#endif
#define SUBSYSTEM_MAILBOX_RESERVE ((size_t)SUBSYSTEM_LOOP_ANSWER)
#define SUBSYSTEM_LOOP_KEPT SUBSYSTEM_LOOP_ANSWER
/// Size of the mailbox from a loop of services to the main loop.
#define SUBSYSTEM_MAILBOX_OCTETS (SUBSYSTEM_LOOP_ANSWER + PUS_PACKET_MAX)
#ifndef SUBSYSTEM_INBOX_OCTETS
#define SUBSYSTEM_INBOX_OCTETS 4096U ///< Size of the ring of requests to a loop of services.
#endif
/// Application data of the longest request to such a loop: the identifiers of TC[20,1].
#define SUBSYSTEM_LOOP_REQUEST_MAX (1U + (4U * PUS_COUNT_MAX))
#define SUBSYSTEM_LOOP_SCRATCH (sizeof(pus_token_t) + SUBSYSTEM_LOOP_REQUEST_MAX)
#define SUBSYSTEM_LOOP_REQUESTS 4U ///< Largest number of requests in one cycle of a loop of services.
#define SUBSYSTEM_LOOP_HEADER 10U  ///< Size of the header of a report in a mailbox [octets].
#define SUBSYSTEM_LOOP_REPORTS 16U ///< Largest number of reports taken from one mailbox in one step.
#define SUBSYSTEM_NEVER UINT64_MAX
#define SUBSYSTEM_STATUS_INTERVAL_NS 1000000000ULL ///< Interval of unsolicited status reports.
/// Cycles that the subsystem waits for a command of the supervisor after an event of severity MEDIUM.
#define SUBSYSTEM_MEDIUM_CYCLES 4U

// 16 and 8: the numbers for which PUS_FIRM_STANDING (pus/core/app_process.h) keeps room.
CAPACITY_CHECK(firm_ring_holds_ends_of_requests, (SUBSYSTEM_CALL_TOKENS + 2U) <= 16U);
CAPACITY_CHECK(loop_answer_fits, SUBSYSTEM_LOOP_ANSWER >= PUS_ANSWER_ROOM);
CAPACITY_CHECK(loop_inbox_holds_a_request, SUBSYSTEM_INBOX_OCTETS >= (SUBSYSTEM_LOOP_SCRATCH + 4U));
CAPACITY_CHECK(firm_ring_holds_links, SUBSYSTEM_LINKS <= 8U);
CAPACITY_CHECK(loop_scratch_holds_a_sample, SUBSYSTEM_LOOP_SCRATCH >= SUBSYSTEM_SAMPLE_OCTETS);

/// Restore a record of a service. STATUS_OK; with any other status the service cannot use the record.
typedef status_t (*subsystem_restore_t)(void* self, uint32_t key, const uint8_t* octets, size_t size);

/// Storage of the services that the descriptor lists, and the function that adds them: both are generated.
typedef struct {
    void* storage;
    void (*add)(void* storage, subsystem_t* subsystem); ///< Null: no such services.
} subsystem_services_t;

typedef struct {
    const subsystem_descriptor_t* descriptor;
    bool is_descriptor_valid; ///< False: stay in OFFLINE / INVALID; only apid and name of the descriptor
                              ///< are used.
    const subsystem_callbacks_t* callbacks;
    void* self;                  ///< First argument of the callbacks.
    uint32_t mission_epoch_s;    ///< Mission time 0 [s of TAI since 1958].
    uint64_t device_deadline_ns; ///< See subsystem_device_deadline_ns.
    /// Silence after which the supervisor is lost [ns]; 0: this component is the supervisor.
    uint64_t supervisor_timeout_ns;
    uint64_t status_interval_ns;    ///< Time between two unsolicited status reports.
    uint32_t start_count;           ///< 1 for the first start of this component in the run.
    pus_port_t port;                ///< Port to which the component's packets are sent.
    const rtlink_resolver_t* links; ///< Null: no real-time links.
    uint8_t link_methods;           ///< Transfer methods of this run: bit set of 1 << rtlink_method_t.
    bool has_loop_tasks;            ///< Each loop of services has a task of its own.
    const pus_service_t* services;  ///< Further services; SUBSYSTEM_SERVICES at most in all.
    size_t service_count;
    subsystem_services_t optional;        ///< Services that the descriptor lists.
    const pus_persistence_t* persistence; ///< Store for records of services; null: no records are stored.
    /// Read the descriptor again (TC[129,6]). It is called in OFFLINE, or in PRE_OPERATIONAL without a
    /// configuration. STATUS_OK with the model to be used from now on; with any other status the old model
    /// stays in force. Null: TC[129,6] is refused.
    status_t (*reload)(void* context, const subsystem_descriptor_t** out_descriptor);
    void* reload_context;
} subsystem_config_t;

typedef struct {        // Private: a loop of services. `mutex` guards inbox and mailbox, loop_mutex the rest.
    uint64_t period_ns; // 0: the loop does not run.
    uint64_t first_tick;
    uint32_t cycle;
    uint8_t priority;
    uint8_t services; // DESCRIPTOR_LOOP_*; used only by the main loop.
    osal_mutex_t mutex;
    message_ring_t inbox; // Accepted requests: token, application data.
    // Finished reports: structure id, time of the values, values; or 0, 0 and a complete report.
    message_ring_t mailbox;
    uint32_t lost;         // Housekeeping reports lost because the mailbox was full, and not counted yet.
    uint32_t reports_lost; // Other reports lost.
    uint8_t inbox_storage[SUBSYSTEM_INBOX_OCTETS];
    uint8_t storage[SUBSYSTEM_MAILBOX_OCTETS];
} subsystem_loop_t;

typedef struct { // Private: a service that the descriptor lists.
    pus_service_t service;
    subsystem_restore_t restore;
} subsystem_optional_t;

typedef struct { // Private: one end of a real-time link.
    bool is_used;
    bool is_producer;
    rtlink_state_t state;
    uint16_t link;
    const descriptor_port_t* port;
    pus_link_ends_t ends;
    rtlink_terms_t terms;
    uint64_t accepted_ns;
    uint64_t opened_ns;
    bool is_stale_reported;
    rtlink_producer_t producer;
    rtlink_consumer_t consumer;
} subsystem_link_t;

struct subsystem { // Private. The most frequently used members come first.
    const subsystem_descriptor_t* descriptor;
    uint64_t now_ns;
    const descriptor_configuration_t* configuration; // Configuration that is applied, or is being applied.
    uint64_t next_cycle_ns;
    uint32_t cycle;
    uint16_t configuration_id; // Id of the selected configuration; 0: none.
    uint16_t last_code;        // Failure code or event id that caused the last transition.
    // Action whose time-out runs; a request that changes nothing does not restart the time-out.
    state_action_t started_action;
    bool is_action_fresh; // The present action has not been called yet.
    bool has_pending;     // A request for a state or configuration is being performed.
    bool is_medium_pending;
    bool is_supervisor_lost;
    uint16_t loop_count; // Number of loops of the applied configuration; read only by the main loop.
    bool has_reload;     // TC[129,6] waits for PRE_OPERATIONAL without a configuration, or OFFLINE.
    state_machine_t machine;
    pus_app_process_t process;
    pus_report_queues_t queues; // Reports that wait for the port; those of the loops wait in the mailboxes.

    subsystem_config_t config;
    uint64_t period_ns;
    uint64_t next_status_ns;
    uint64_t action_start_ns;
    uint64_t supervisor_heard_ns;
    uint32_t medium_cycle;
    pus_token_t pending;
    pus_token_t reload;

    parameter_dictionary_t dictionary;
    parameter_entry_t entries[SUBSYSTEM_PARAMETERS];
    parameter_bounds_t bounds[SUBSYSTEM_BOUNDS];

    pus_dispatcher_t dispatcher;
    pus_service_t services[SUBSYSTEM_SERVICES];
    pus_test_t test;
    pus_hk_t housekeeping;
    pus_hk_structure_t structures[SUBSYSTEM_STRUCTURES];
    pus_hk_functional_t functional[SUBSYSTEM_FUNCTIONAL];
    uint8_t samples[SUBSYSTEM_STRUCTURES * SUBSYSTEM_SAMPLE_OCTETS];
    pus_events_t events;
    pus_event_definition_t event_definitions[SUBSYSTEM_EVENTS];
    pus_event_state_t event_states[SUBSYSTEM_EVENTS];
    pus_functions_t functions;
    pus_function_t function_table[SUBSYSTEM_FUNCTIONS];
    pus_argument_t arguments[SUBSYSTEM_ARGUMENTS];
    uint64_t argument_area[SUBSYSTEM_ARGUMENT_WORDS];
    pus_parameters_t parameters;
    pus_management_t management;
    pus_rtlink_t rtlink;
    size_t service_count;
    subsystem_optional_t optional[SUBSYSTEM_OPTIONAL_SERVICES];
    size_t optional_count;
    uint32_t optional_cycle; // Number of steps of the optional services.

    pool_t call_tokens;
    uint64_t call_token_storage[POOL_STORAGE_WORDS(sizeof(pus_token_t), SUBSYSTEM_CALL_TOKENS)];
    pool_slot_t call_token_slots[SUBSYSTEM_CALL_TOKENS];
    pus_token_t* open_call_tokens[SUBSYSTEM_CALL_TOKENS];
    uint32_t token_in_call; // Token of the function whose callback is running; its reply ends the token.

    osal_mutex_t loop_mutex;
    subsystem_loop_t loops[SUBSYSTEM_LOOPS];
    uint8_t loop_octets[SUBSYSTEM_LOOP_HEADER + PUS_PACKET_MAX]; // A report from a mailbox.
    uint32_t loop_reports_lost;
    // The loop that is being stepped (its step holds loop_mutex), and the services that it uses.
    subsystem_loop_t* present_loop;
    pus_app_process_t loop_process;
    pus_test_t loop_test;
    pus_parameters_t loop_parameters;
    pus_service_t loop_services[2];
    // First used for the values of housekeeping, then for one request at a time.
    uint8_t loop_scratch[SUBSYSTEM_LOOP_SCRATCH];
    uint8_t loop_kept[SUBSYSTEM_LOOP_KEPT];

    subsystem_link_t links[SUBSYSTEM_LINKS];
    subsystem_link_totals_t closed_links; // Counters of links that are closed.
};

/// Initialise the component in OFFLINE and register all services. `config` is copied.
void subsystem_init(subsystem_t* subsystem, const subsystem_config_t* config);
/// True if a request may be accepted, because there is room for its reports. While it is false, packets
/// must stay in the inbox, so that their senders wait. It becomes true in a later step, when the port
/// accepts the reports of the component.
bool subsystem_may_accept(subsystem_t* subsystem);
/// Process one packet (request or report). Its whole content is checked.
void subsystem_accept(subsystem_t* subsystem, const uint8_t* packet, size_t size, uint64_t now_ns);
/// Process one request that may be longer than a packet, because ST[13] has assembled it.
void subsystem_accept_large(subsystem_t* subsystem, const uint8_t* packet, size_t size, uint64_t now_ns);
/// Set the time, for a program whose own callbacks raise events between two steps.
void subsystem_set_time(subsystem_t* subsystem, uint64_t now_ns);
/// Run the work that is due. Returns the time of the next wake [ns of the run].
uint64_t subsystem_step(subsystem_t* subsystem, uint64_t now_ns);
/// Returns the priority of the loop that runs subsystem_step, 1..99: the priority of the applied
/// configuration. Without a configuration, the highest priority of all configurations, because the devices
/// run from HARDWARE_INIT on and expect heartbeats.
uint8_t subsystem_component_priority(const subsystem_t* subsystem);
/// Call when the program ends: close everything that the component and its subsystem have opened, without
/// sending a message.
void subsystem_release(subsystem_t* subsystem);
/// Run the work that is due in loop `loop` of services, 0..SUBSYSTEM_LOOPS - 1. Only for loops that have
/// their own tasks. Returns the time of the next wake; SUBSYSTEM_NEVER while no configuration with such a
/// loop is applied.
uint64_t subsystem_loop_step(subsystem_t* subsystem, uint8_t loop, uint64_t now_ns);
/// Returns the priority of a loop of services in the applied configuration, 1..99; 0 while the loop does not
/// run.
uint8_t subsystem_loop_priority(subsystem_t* subsystem, uint8_t loop);
/// Restore one record that a service has stored; `table` is the service type. Call it before the first
/// step. STATUS_OK, STATUS_NOT_FOUND (no service of the component stores such records), or the status with
/// which the service refuses the record.
MUST_USE status_t subsystem_restore(subsystem_t* subsystem, uint8_t table, uint32_t key,
                                    const uint8_t* octets, size_t size);
/// Process a datagram of a real-time link.
void subsystem_link_datagram(subsystem_t* subsystem, const uint8_t* frame, size_t size);
/// Returns the component's application process, for further services.
pus_app_process_t* subsystem_process(subsystem_t* subsystem);
/// Request a state, or select a configuration, without a request packet. The supervisor uses this for its
/// own start. ANSWER_NO also: no such configuration.
state_answer_t subsystem_request(subsystem_t* subsystem, state_t target, state_cause_t cause);
state_answer_t subsystem_select(subsystem_t* subsystem, uint16_t configuration_id);

#endif // FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_CORE_H
