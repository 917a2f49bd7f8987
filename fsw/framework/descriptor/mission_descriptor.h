// SPDX-License-Identifier: Apache-2.0
/// In-memory model of a mission descriptor.
///
/// Loading a mission also loads the descriptor of each of its subsystems, one after the other, and keeps what
/// the supervisor needs of them: names and ids of configurations and ports, which ports are required, and the
/// hashes. So every name in permissions, links and plans is checked and resolved to its id at load time.
///
/// Ownership  The caller provides the model (static; about 34 KiB); lists and strings lie inside: do not
///            copy it.
/// Context    Any, read-only after loading.
#ifndef FSW_FRAMEWORK_DESCRIPTOR_MISSION_DESCRIPTOR_H
#define FSW_FRAMEWORK_DESCRIPTOR_MISSION_DESCRIPTOR_H

#include "base/capacities.h"
#include "base/status.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MISSION_TEXT_OCTETS 16384U
#define MISSION_SUBSYSTEMS_MAX CAPACITY_SUBSYSTEMS
#define MISSION_MODES_MAX 8U
#define MISSION_RULES_MAX 128U
#define MISSION_LINKS_MAX CAPACITY_LINKS
#define MISSION_PORT_LINKS_MAX CAPACITY_PORT_LINKS
#define MISSION_PLANS_MAX 32U
#define MISSION_ACTIONS_MAX 64U
#define MISSION_BUSES_MAX CAPACITY_BUSES
#define MISSION_CONFIGURATIONS_MAX 8U ///< Per subsystem.
#define MISSION_PORTS_MAX 16U         ///< Per subsystem.
#define MISSION_USERS_MAX 8U
#define MISSION_COMPUTERS_MAX CAPACITY_COMPUTERS ///< On-board computers.

#define MISSION_ANY_TARGET 0xFFFFU ///< mission_rule_t.target: every subsystem.
#define MISSION_SELF 0xFFFEU       ///< mission_action_t.target: the subsystem that raised the event.
#define MISSION_NETWORK 0xFFFDU    ///< mission_action_t.target: its real-time network.

typedef struct {
    const char* name;
    uint16_t id;
} mission_configuration_t;

typedef struct { // A port in one configuration of its subsystem.
    const char* name;
    uint16_t id;
    uint16_t configuration; ///< Id of the configuration it belongs to.
    bool is_provided;
    bool is_required;
    uint32_t layout_hash;
    uint8_t methods; ///< Bit n: descriptor_method_t n.
} mission_port_t;

typedef struct {
    const char* name;
    uint16_t apid;
    const char* executable; ///< Name of the program, without directory.
    const char* descriptor; ///< Path as written, relative to the mission descriptor's directory.
    bool is_autostart;
    uint32_t memory_kib; ///< Address space limit of its process; 0: derived from the program.
    /// Restarts in a row; when they are used up, the mission enters its fallback mode.
    uint8_t restart_budget;
    /// The count of restarts is cleared when the process has run for this time; 0: never.
    uint32_t restart_period_us;
    /// After a restart, the supervisor commands the subsystem back to its earlier state.
    bool is_recommissioned;
    /// Time from the command to start its process until its first step [us].
    uint32_t boot_time_us;
    /// If each process has its own clock: silence after which devices and master regard each other as lost
    /// [us]; 0: not defined.
    uint32_t device_deadline_us;
    uint32_t hang_after_us; ///< Delay of a step after which the process is killed [us].
    /// How long the subsystem stays OPERATIONAL without the supervisor [us].
    uint32_t supervisor_timeout_us;
    /// Number of the on-board computer that the subsystem runs on, from 1; used only if the run has several
    /// computers.
    uint8_t computer;
    /// Power consumption in each state [W].
    uint32_t power_w[DESCRIPTOR_STATES];
    uint64_t interface_hash;
    uint64_t configuration_hash;
    mission_configuration_t configurations[CAPACITY_OF_STORAGE(MISSION_CONFIGURATIONS_MAX)];
    uint16_t configuration_count;
    mission_port_t ports[CAPACITY_OF_STORAGE(MISSION_PORTS_MAX)];
    uint16_t port_count;
    uint32_t line;
} mission_subsystem_t;

typedef struct {
    const char* name;
    uint8_t id; ///< Mode number of TC[131,1], 0..7.
    bool is_initial;
    bool is_fallback;
    uint32_t line;
} mission_mode_t;

typedef struct { // One <Allow>. A request that no rule allows is denied.
    uint8_t service;
    uint8_t subtype;    ///< 0: every subtype of the service.
    const char* select; ///< Function name; NULL if the selector is a number or "*".
    uint16_t number;    ///< State, configuration or link, if is_numbered.
    bool is_numbered;   ///< Compare `number`.
    bool is_any;        ///< select="*": any selector.
    uint16_t target;    ///< APID or MISSION_ANY_TARGET.
    uint8_t modes;      ///< Bit n: mode id n.
    uint16_t states;    ///< Bit n: state n of the target.
    uint32_t line;
} mission_rule_t;

typedef struct { // Real-time link of the mission: producer.port -> consumer.port.
    const char* name;
    /// 1.. in the order of the file; the id of the link on the wire, and the selector of permissions for
    /// service 130.
    uint16_t number;
    uint16_t producer_apid;
    uint16_t producer_port;
    uint16_t consumer_apid;
    uint16_t consumer_port;
    bool is_required; ///< The consumer's port is required in its configurations.
    uint32_t line;
} mission_link_t;

typedef enum {
    MISSION_ACTION_STATE, ///< Request a state of the target.
    MISSION_ACTION_MODE,  ///< Set the mode of the mission.
    MISSION_ACTION_LOG    ///< Only write to the log.
} mission_action_kind_t;

typedef struct {
    mission_action_kind_t kind;
    uint16_t target;   ///< APID, MISSION_SELF or MISSION_NETWORK (STATE).
    uint8_t state;     ///< STATE: the requested state.
    uint8_t mode;      ///< MODE: id of the mode.
    uint32_t after_us; ///< Delay after the event.
    uint32_t line;
} mission_action_t;

typedef struct { // Recovery plan: actions after an event.
    const char* name;
    descriptor_severity_t severity;
    uint16_t apid;     ///< Subsystem whose events start the plan, or MISSION_ANY_TARGET.
    uint16_t event_id; ///< Event that starts the plan; 0: any event.
    uint16_t first_action;
    uint16_t action_count;
    uint32_t line;
} mission_plan_t;

typedef struct {
    const char* name;
    const char* redundant_to; ///< Name of the bus whose channel B this is; "": this is not a channel B.
    uint32_t bit_rate;        ///< Nominal bit rate [bit/s].
    uint32_t data_bit_rate;   ///< CAN FD data phase [bit/s]; 0 = classic CAN.
    uint32_t line;
} mission_bus_t;

typedef enum {
    MISSION_LOG_ASCII      = 0, // Values of TC[131,3].
    MISSION_LOG_SQLITE     = 1,
    MISSION_LOG_POSTGRESQL = 2,
    MISSION_LOG_RING       = 3
} mission_log_t;

typedef struct {
    const char* name;
    uint16_t id; ///< Source and destination id in packets.
    uint32_t line;
} mission_user_t;

typedef struct { // Private: lists and strings that were read from a file.
    mission_subsystem_t subsystems[CAPACITY_OF_STORAGE(MISSION_SUBSYSTEMS_MAX)];
    mission_mode_t modes[CAPACITY_OF_STORAGE(MISSION_MODES_MAX)];
    mission_rule_t rules[CAPACITY_OF_STORAGE(MISSION_RULES_MAX)];
    mission_link_t links[CAPACITY_OF_STORAGE(MISSION_LINKS_MAX)];
    mission_plan_t plans[CAPACITY_OF_STORAGE(MISSION_PLANS_MAX)];
    mission_action_t actions[CAPACITY_OF_STORAGE(MISSION_ACTIONS_MAX)];
    mission_bus_t buses[CAPACITY_OF_STORAGE(MISSION_BUSES_MAX)];
    mission_user_t users[CAPACITY_OF_STORAGE(MISSION_USERS_MAX)];
    char text[CAPACITY_OF_STORAGE(MISSION_TEXT_OCTETS)];
} mission_storage_t;

typedef struct {
    const char* name;
    uint32_t epoch_s;            ///< Mission time 0 as TAI seconds since 1958-01-01.
    uint64_t interface_hash;     ///< Hash over the interface hashes of all subsystems.
    uint64_t configuration_hash; ///< Hash over this file and the configuration hashes of all subsystems.
    uint32_t power_available_w;
    uint16_t initial_mode; ///< Id of the mode in which the mission begins.
    uint8_t fallback_mode; ///< Id of the mode that is entered when the mission cannot continue normally.
    uint8_t time_reports;  ///< Format of spacecraft time packets: the subtype of ST[09], 2 CUC, 3 CDS.
    mission_log_t log_strategy;
    uint32_t log_ring_records;
    uint8_t message_method; ///< descriptor_method_t of messages between processes.
    uint8_t link_method;    ///< Preferred method of real-time links.
    uint16_t ground_port;
    uint8_t is_ground_open; ///< The port is open to other machines; the mission then has a key.
    const char* ground_key; ///< File with the key of telecommands, relative to this file; "": none.

    const mission_subsystem_t* subsystems; ///< In the order of their turns in a time step.
    uint16_t subsystem_count;
    const mission_mode_t* modes;
    uint16_t mode_count;
    const mission_rule_t* rules;
    uint16_t rule_count;
    const mission_link_t* links;
    uint16_t link_count;
    const mission_plan_t* plans;
    uint16_t plan_count;
    const mission_action_t* actions;
    uint16_t action_count;
    const mission_bus_t* buses;
    uint16_t bus_count;
    const mission_user_t* users;
    uint16_t user_count;

    uint32_t text_used; // Private.
    mission_storage_t storage;
} mission_descriptor_t;

/// Make a model empty: its lists have no items and use the storage of the model.
void descriptor_mission_clear(mission_descriptor_t* mission);
/// Call for a model that was copied: its lists then refer to the storage of the copy.
void descriptor_mission_use_storage(mission_descriptor_t* mission);

/// Build the path of a descriptor that a mission lists: relative to the directory of the mission's file, or
/// absolute. Returns STATUS_OK, or STATUS_TOO_LARGE (longer than `capacity`); then the error text, with file,
/// line, value and expected length, is appended.
MUST_USE status_t descriptor_path_of(text_t* out_error, const char* mission_path,
                                     const mission_subsystem_t* subsystem, char* out_path, size_t capacity);

/// Each of these functions returns the entry, or NULL if there is none.
const mission_subsystem_t* descriptor_mission_find_subsystem(const mission_descriptor_t* mission,
                                                             uint16_t apid);
const mission_mode_t* descriptor_mission_find_mode(const mission_descriptor_t* mission, uint8_t id);
/// Find the link between two ports, which TC[130,3] names.
const mission_link_t* descriptor_mission_find_link(const mission_descriptor_t* mission,
                                                   uint16_t producer_apid, uint16_t producer_port,
                                                   uint16_t consumer_apid, uint16_t consumer_port);
/// Find the plan for an event: the first one in the file that matches severity, subsystem and event. NULL:
/// the built-in reaction applies.
const mission_plan_t* descriptor_mission_find_plan(const mission_descriptor_t* mission,
                                                   descriptor_severity_t severity, uint16_t apid,
                                                   uint16_t event_id);

#endif // FSW_FRAMEWORK_DESCRIPTOR_MISSION_DESCRIPTOR_H
