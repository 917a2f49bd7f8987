// SPDX-License-Identifier: Apache-2.0
/// In-memory model of a subsystem descriptor (docs/descriptors.md): read-only once loaded.
///
/// Lists are kept flat: a structure, a function or a port owns the range [first, first + count) of a list,
/// and stores `first` and `count`. A model that was read from a file refers to its own storage, so it must
/// not be copied; all capacities are fixed. A model that was compiled into a program refers to constants.
///
/// The content has two parts. The interface (names, ids, types, counts of parameters, events, functions,
/// services, configurations, ports; enumerations and failures) is compiled into the program; interface_hash
/// protects it. All else is configuration, which is read at run time; configuration_hash protects it
/// (docs/descriptors.md defines both).
///
/// Ownership  The caller provides the model (static; about 71 KiB).
/// Context    Any, read-only after loading.
#ifndef FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_DESCRIPTOR_H
#define FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_DESCRIPTOR_H

#include "base/apids.h"
#include "base/capacities.h"
#include "base/flow_format.h"
#include "base/status.h"
#include "base/text.h"
#include "base/value.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define DESCRIPTOR_ERROR_CHARACTERS 384U ///< Longest text of an error, with its NUL.
#define DESCRIPTOR_TEXT_OCTETS 6144U
#define DESCRIPTOR_FIELDS_MAX 160U
#define DESCRIPTOR_ENUMERATIONS_MAX 16U
#define DESCRIPTOR_FAILURES_MAX 32U
#define DESCRIPTOR_FAILURE_IDS 0x7FFFU ///< Highest id of a failure.
#define DESCRIPTOR_PARAMETERS_MAX 64U
#define DESCRIPTOR_EVENTS_MAX 48U
#define DESCRIPTOR_FUNCTIONS_MAX 32U
#define DESCRIPTOR_SERVICES_MAX 16U
#define DESCRIPTOR_CONFIGURATIONS_MAX 8U
#define DESCRIPTOR_INITIALS_MAX 64U
#define DESCRIPTOR_REFERENCES_MAX 192U
#define DESCRIPTOR_STRUCTURES_MAX 32U
#define DESCRIPTOR_SAMPLED_MAX 32U
#define DESCRIPTOR_LOOPS_MAX 16U
#define DESCRIPTOR_CONFIGURATION_LOOPS_MAX 2U ///< Loops of services of one configuration.
#define DESCRIPTOR_PORTS_MAX 16U
#define DESCRIPTOR_DEVICES_MAX 128U ///< Devices of all configurations together: 32 in each of four.
#define DESCRIPTOR_SETTINGS_MAX 640U
#define DESCRIPTOR_QUANTITIES_MAX 128U
#define DESCRIPTOR_SUPPLIES_MAX 32U
#define DESCRIPTOR_ENDNODES_MAX DESCRIPTOR_DEVICES_MAX
#define DESCRIPTOR_RECORD_FIELDS_MAX 128U
#define DESCRIPTOR_STATES 10U
#define DESCRIPTOR_STATE_WORDS 192U ///< Characters of the names of all states, each followed by a space.
#define DESCRIPTOR_METHODS 5U
#define DESCRIPTOR_NAME_MAX 32U   ///< Characters of a name.
#define DESCRIPTOR_NESTING_MAX 3U ///< Structures within the structure of a parameter.
#define DESCRIPTOR_PATH_MAX ((DESCRIPTOR_NESTING_MAX + 1U) * (DESCRIPTOR_NAME_MAX + 1U)) ///< "OUTER.INNER.X"
#define DESCRIPTOR_FUNCTION_NAME_MAX 8U  ///< A function's name is its wire id.
#define DESCRIPTOR_PORT_OCTETS_MAX 1024U ///< Payload of a real-time link.
#define DESCRIPTOR_AUXILIARY_MAX 1024U   ///< Auxiliary data of an event [octets].

/// Event severities: the message subtypes of ST[05].
typedef enum {
    DESCRIPTOR_INFORMATIVE = 1,
    DESCRIPTOR_LOW         = 2,
    DESCRIPTOR_MEDIUM      = 3,
    DESCRIPTOR_HIGH        = 4
} descriptor_severity_t;

/// Transfer methods of real-time links: codes of service 130.
typedef enum {
    DESCRIPTOR_SHARED_MEMORY = 0,
    DESCRIPTOR_TIPC          = 1,
    DESCRIPTOR_UDP           = 2,
    DESCRIPTOR_STREAM        = 3,
    DESCRIPTOR_MESSAGE_QUEUE = 4
} descriptor_method_t;
#define DESCRIPTOR_METHOD_WORDS "SHARED_MEMORY TIPC UDP STREAM MESSAGE_QUEUE"
/// Names of the severities, beginning with DESCRIPTOR_INFORMATIVE.
#define DESCRIPTOR_SEVERITY_WORDS "INFORMATIVE LOW MEDIUM HIGH"

typedef struct { // Names for the numbers of a field.
    const char* name;
    uint16_t first; ///< Number of the first name; the others have the numbers after it.
    uint32_t line;
    const char* values; ///< The names, separated by single spaces.
} descriptor_enumeration_t;

typedef struct { // A failure of functions that the subsystem defines itself.
    const char* name;
    uint16_t id; ///< The failure code is PUS_FAILURE_OWN + id.
    uint32_t line;
} descriptor_failure_t;

typedef struct { // One field of a parameter, an argument of a function, or an element of a port's layout.
    const char* name; ///< Name; in a structure within the parameter: "GROUP.NAME".
    value_type_t type;
    uint16_t id;     ///< Id of an argument; for other fields the index within the owner, from 0.
    uint16_t count;  ///< Number of scalars, >= 1.
    uint32_t offset; ///< [octets] in the generated C structure of its owner, as this compiler lays it out.
    uint32_t line;
    const char* unit;                            ///< "" if none.
    const char* init;                            ///< Text of `count` numbers, or NULL (zero).
    const descriptor_enumeration_t* enumeration; ///< Enumeration of the same model; NULL: none.
    double min;                                  ///< -DBL_MAX if none; for an enumeration, its first number.
    double max;                                  ///< DBL_MAX if none; for an enumeration, its last number.
} descriptor_field_t;

typedef struct {
    const char* name;
    uint32_t id;     ///< Full parameter id, APID << 21 | layout << 16 | number.
    uint16_t number; ///< Number of the parameter in the descriptor.
    uint16_t first_field;
    uint16_t field_count;
    uint32_t wire_size;   ///< [octets]
    uint32_t memory_size; ///< sizeof the generated structure or array.
    bool is_struct;       ///< Otherwise the parameter has one field, with its own name.
    bool is_settable;
    uint32_t line;
} descriptor_parameter_t;

typedef struct {
    const char* name;
    uint16_t id;
    descriptor_severity_t severity;
    uint16_t per_second;  ///< Occurrences reported per second on average; 0: no limit.
    uint8_t burst;        ///< Occurrences reported at once.
    uint16_t first_field; ///< First field of the auxiliary data that the caller of the event passes.
    uint16_t field_count;
    /// First of the parameters that are sampled into the auxiliary data. Only one of the two ranges is used.
    uint16_t first_reference;
    uint16_t reference_count;
    uint32_t octets; ///< Size of the auxiliary data on the wire.
    uint32_t line;
} descriptor_event_t;

typedef struct {
    const char* name; ///< 1..8 characters: the wire id, padded with NUL.
    uint16_t id;      ///< Number of the function in its program (generated enum), and detail of failures.
    uint16_t first_argument; ///< Index in `fields`.
    uint16_t argument_count;
    uint32_t memory_size;    ///< sizeof the generated argument structure; 0 without arguments.
    uint16_t states;         ///< Bit n: allowed in state n.
    uint16_t configurations; ///< Bit i: allowed in configurations[i].
    uint32_t line;
} descriptor_function_t;

/// Capacities of the supervisor's static storage: a descriptor may grant at most this number of entries to
/// a service of the whole spacecraft.
#define DESCRIPTOR_TIME_ACTIVITIES_MAX 12000U    ///< ST[11].
#define DESCRIPTOR_PACKET_STORES_MAX 8U          ///< ST[15].
#define DESCRIPTOR_PROCEDURES_MAX 64U            ///< ST[18].
#define DESCRIPTOR_EVENT_ACTIONS_MAX 1000U       ///< ST[19].
#define DESCRIPTOR_SEQUENCES_MAX 64U             ///< ST[21].
#define DESCRIPTOR_POSITION_ACTIVITIES_MAX 1000U ///< ST[22].
#define DESCRIPTOR_FILE_LOCKS_MAX 64U            ///< ST[23].

typedef struct { // Service in addition to those that all subsystems have.
    uint8_t type;
    /// Service of a subsystem: number of entries for which the program has room. Service of the whole
    /// spacecraft: number of entries granted, at most the maximum above; this is part of the configuration,
    /// not of the interface.
    uint16_t capacity;
    uint16_t functional; ///< ST[12]: functional monitoring definitions; others 0.
    bool is_of_spacecraft;
    uint32_t line;
} descriptor_service_t;

typedef struct {        // Initial value of one field that a configuration overrides.
    uint16_t parameter; ///< Index in `parameters`.
    uint16_t field;     ///< Index in `fields`.
    const char* text;
    uint32_t line;
} descriptor_initial_t;

typedef struct { // Super-commutated set: its parameters are sampled nrep times per interval.
    uint16_t nrep;
    uint16_t first_reference;
    uint16_t reference_count;
} descriptor_sampled_t;

#define DESCRIPTOR_LOOP_TEST 0x01U       ///< Bit of the services of a loop: requests of ST[17].
#define DESCRIPTOR_LOOP_PARAMETERS 0x02U ///< Bit: requests of ST[20] for values, not those that set them.

typedef struct { // A loop for services that do not need the rate of the control.
    const char* name;
    uint32_t sampling_us;
    uint8_t priority;
    /// DESCRIPTOR_LOOP_* bits of the services whose requests the loop performs. (Structures of ST[03] name
    /// their loop themselves.)
    uint8_t services;
    uint32_t line;
} descriptor_loop_t;

typedef struct { // Housekeeping report structure.
    uint16_t id;
    uint8_t loop;             ///< 0: the main loop; n: the n-th <Loop> of the configuration.
    uint32_t interval_cycles; ///< Collection interval in cycles of its loop; a multiple of every nrep.
    bool is_enabled;          ///< Periodic generation starts when the configuration is applied.
    uint16_t first_reference; ///< First of the parameters that are sampled once per interval.
    uint16_t reference_count;
    uint16_t first_sampled; ///< Index in `sampled` of the first super-commutated set.
    uint16_t sampled_count;
    uint32_t octets; ///< Size of the values of one report on the wire.
    uint32_t line;
} descriptor_structure_t;

typedef struct { // Port of a real-time link.
    const char* name;
    uint16_t id;
    bool is_provided; ///< Producer side; otherwise required (consumer side).
    bool is_required; ///< Consumer: SAFE_OPERATIONAL is refused while the link is missing.
    uint16_t first_field;
    uint16_t field_count;
    uint32_t layout_hash; ///< CRC-32 of the lines "name:type:count\n".
    uint32_t octets;      ///< Size of the payload on the wire.
    uint32_t memory_size; ///< sizeof the generated payload structure.
    uint32_t period_us;
    uint32_t stale_us; ///< Consumer: age at which the link is stale; 0 for a producer.
    /// Transfer methods (descriptor_method_t) in the order of preference.
    uint8_t methods[DESCRIPTOR_METHODS];
    uint8_t method_count;
    uint32_t line;
} descriptor_port_t;

typedef struct { // Value of one object of a device, written when the configuration is applied.
    uint16_t index;
    uint8_t subindex;
    value_type_t type; ///< Any type but BOOL.
    uint32_t line;
    uint64_t bits; ///< Bits of the value on the wire, two's complement or IEEE 754, in the low octets.
} descriptor_setting_t;

typedef struct { // A quantity of a device in engineering units: the value of an object times a scale.
    const char* name;
    const char* unit;
    uint16_t id; ///< Unique within the device.
    uint16_t index;
    uint8_t subindex;
    value_type_t type; ///< Type of the object: any but BOOL.
    double scale;      ///< Not 0.
    bool is_settable;
    uint32_t line;
} descriptor_quantity_t;

typedef struct { // A field of the record that a stream device sends (IN) or takes (OUT), in this order.
    const char* name;
    const char* unit;
    bool is_out;
    value_type_t type; ///< Raw value on the wire; engineering value = raw value * scale + offset.
    double scale;      ///< Not 0.
    double offset;
    double safe; ///< OUT: engineering value of the safe record.
    uint32_t line;
} descriptor_record_field_t;

typedef struct {  // The supply of a device: two output lines of a power unit on its bus switch it.
    uint8_t unit; ///< Node id of the power unit.
    uint8_t on;   ///< Line that switches on.
    uint8_t off;  ///< Line that switches off; not the same line.
    uint32_t line;
} descriptor_supply_t;

typedef enum {
    DESCRIPTOR_ENDNODE_CAN,
    DESCRIPTOR_ENDNODE_SHM,
    DESCRIPTOR_ENDNODE_MQUEUE,
    DESCRIPTOR_ENDNODE_UDP,
    DESCRIPTOR_ENDNODE_TCP,
    DESCRIPTOR_ENDNODE_SERIAL,
    DESCRIPTOR_ENDNODE_FILE
} descriptor_endnode_type_t;

typedef struct { // Address of a data flow; which fields are used depends on the type.
    descriptor_endnode_type_t type;
    const char* bus;           ///< CAN: name of the bus, channel A.
    const char* redundant_bus; ///< CAN: name of its channel B, or "".
    uint8_t node;              ///< CAN: node id 1..127.
    const char* name;          ///< SHM, MQUEUE: name of the object; SERIAL, FILE: path of the device.
    const char* address;       ///< UDP, TCP: host.
    uint16_t port;             ///< UDP, TCP: port.
    flow_format_t format;
    bool has_checksum;   ///< A record ends with its CRC-16/CCITT-FALSE, in the byte order of the flow.
    uint32_t silence_us; ///< A device that sends no record for this time is lost.
    uint32_t retry_us;   ///< First delay before the next attempt to connect.
    uint32_t longest_us; ///< Longest delay: each failure doubles the delay up to this.
    uint32_t line;
} descriptor_endnode_t;

typedef struct {
    const char* name;
    const char* type; ///< Device class, e.g. "joint-drive", or DESCRIPTOR_STREAM_TYPE.
    uint16_t first_setting;
    uint16_t setting_count;
    uint16_t first_quantity;
    uint16_t quantity_count;
    uint16_t first_supply;
    uint16_t supply_count;
    uint16_t first_record_field;
    uint16_t record_field_count;
    uint16_t first_endnode;
    uint16_t endnode_count;
    uint32_t line;
} descriptor_device_t;

typedef struct {
    const char* name;
    uint16_t id; ///< >= 1; on the wire 0 means "no configuration".
    uint8_t priority;
    uint32_t sampling_us;
    uint16_t first_initial;
    uint16_t initial_count;
    uint16_t first_loop;
    uint16_t loop_count;
    uint16_t first_structure;
    uint16_t structure_count;
    uint16_t first_port;
    uint16_t port_count;
    uint16_t first_device;
    uint16_t device_count;
    uint32_t line;
} descriptor_configuration_t;

typedef struct { // Private: lists and strings that were read from a file.
    descriptor_enumeration_t enumerations[CAPACITY_OF_STORAGE(DESCRIPTOR_ENUMERATIONS_MAX)];
    descriptor_failure_t failures[CAPACITY_OF_STORAGE(DESCRIPTOR_FAILURES_MAX)];
    descriptor_field_t fields[CAPACITY_OF_STORAGE(DESCRIPTOR_FIELDS_MAX)];
    descriptor_parameter_t parameters[CAPACITY_OF_STORAGE(DESCRIPTOR_PARAMETERS_MAX)];
    descriptor_event_t events[CAPACITY_OF_STORAGE(DESCRIPTOR_EVENTS_MAX)];
    descriptor_function_t functions[CAPACITY_OF_STORAGE(DESCRIPTOR_FUNCTIONS_MAX)];
    descriptor_service_t services[CAPACITY_OF_STORAGE(DESCRIPTOR_SERVICES_MAX)];
    descriptor_configuration_t configurations[CAPACITY_OF_STORAGE(DESCRIPTOR_CONFIGURATIONS_MAX)];
    descriptor_initial_t initials[CAPACITY_OF_STORAGE(DESCRIPTOR_INITIALS_MAX)];
    uint16_t references[CAPACITY_OF_STORAGE(DESCRIPTOR_REFERENCES_MAX)];
    descriptor_loop_t loops[CAPACITY_OF_STORAGE(DESCRIPTOR_LOOPS_MAX)];
    descriptor_structure_t structures[CAPACITY_OF_STORAGE(DESCRIPTOR_STRUCTURES_MAX)];
    descriptor_sampled_t sampled[CAPACITY_OF_STORAGE(DESCRIPTOR_SAMPLED_MAX)];
    descriptor_port_t ports[CAPACITY_OF_STORAGE(DESCRIPTOR_PORTS_MAX)];
    descriptor_device_t devices[CAPACITY_OF_STORAGE(DESCRIPTOR_DEVICES_MAX)];
    descriptor_setting_t settings[CAPACITY_OF_STORAGE(DESCRIPTOR_SETTINGS_MAX)];
    descriptor_quantity_t quantities[CAPACITY_OF_STORAGE(DESCRIPTOR_QUANTITIES_MAX)];
    descriptor_supply_t supplies[CAPACITY_OF_STORAGE(DESCRIPTOR_SUPPLIES_MAX)];
    descriptor_record_field_t record_fields[CAPACITY_OF_STORAGE(DESCRIPTOR_RECORD_FIELDS_MAX)];
    descriptor_endnode_t endnodes[CAPACITY_OF_STORAGE(DESCRIPTOR_ENDNODES_MAX)];
    char text[CAPACITY_OF_STORAGE(DESCRIPTOR_TEXT_OCTETS)];
} subsystem_storage_t;

typedef struct {
    const char* name;
    uint16_t apid;
    uint64_t interface_hash;
    uint64_t configuration_hash;
    uint8_t pool_warn_percent;
    uint8_t pool_clear_percent;
    bool is_sync_first;                     ///< SYNC is sent before the commands of a cycle.
    uint32_t timeout_us[DESCRIPTOR_STATES]; ///< Time limit of the entry action of each state.
    uint32_t sampling_us;                   ///< Step period while no configuration is applied.

    const descriptor_enumeration_t* enumerations;
    uint16_t enumeration_count;
    const descriptor_failure_t* failures;
    uint16_t failure_count;
    const descriptor_field_t* fields;
    uint16_t field_count;
    const descriptor_parameter_t* parameters;
    uint16_t parameter_count;
    const descriptor_event_t* events;
    uint16_t event_count;
    const descriptor_function_t* functions;
    uint16_t function_count;
    const descriptor_service_t* services;
    uint16_t service_count;
    const descriptor_configuration_t* configurations;
    uint16_t configuration_count;
    const descriptor_initial_t* initials;
    uint16_t initial_count;
    const uint16_t* references; ///< Indices in `parameters`.
    uint16_t reference_count;
    const descriptor_loop_t* loops;
    uint16_t loop_count;
    const descriptor_structure_t* structures;
    uint16_t structure_count;
    const descriptor_sampled_t* sampled;
    uint16_t sampled_count;
    /// A port has one entry for each configuration in which it occurs.
    const descriptor_port_t* ports;
    uint16_t port_count;
    const descriptor_device_t* devices;
    uint16_t device_count;
    const descriptor_setting_t* settings;
    uint16_t setting_count;
    const descriptor_quantity_t* quantities;
    uint16_t quantity_count;
    const descriptor_supply_t* supplies;
    uint16_t supply_count;
    const descriptor_record_field_t* record_fields;
    uint16_t record_field_count;
    const descriptor_endnode_t* endnodes;
    uint16_t endnode_count;

    uint32_t text_used; // Private.
    subsystem_storage_t storage;
} subsystem_descriptor_t;

/// Type of a device that exchanges records over a data flow (docs/stream-devices.md).
#define DESCRIPTOR_STREAM_TYPE "stream"
/// True if the type of the device is DESCRIPTOR_STREAM_TYPE; all other types are classes of devices on CAN.
bool descriptor_is_stream(const descriptor_device_t* device);

/// Compare the interface of a descriptor with the one compiled into the program. STATUS_OK, or
/// STATUS_CHECKSUM; it then appends a text with file, compiled and found hash, and "run make".
MUST_USE status_t descriptor_check_interface(text_t* out_error, const char* path,
                                             const subsystem_descriptor_t* descriptor,
                                             uint64_t compiled_hash);
/// Refuse a descriptor for a reason that only its program knows: appends "path:line: REASON" or, if `most` is
/// not 0, "path:line: too many REASON, at most MOST". Returns STATUS_UNSUPPORTED.
status_t descriptor_refuse(text_t* out_error, const char* path, uint32_t line, const char* reason,
                           uint32_t most);

/// Make a model empty: its lists have no items and use the storage of the model.
void descriptor_subsystem_clear(subsystem_descriptor_t* descriptor);
/// Call for a model that was copied: its lists then refer to the storage of the copy.
void descriptor_subsystem_use_storage(subsystem_descriptor_t* descriptor);

/// Return the first of `count` entries of `size` octets with this name, or with this id; NULL if there is
/// none. Every entry must begin with its name, directly followed by its id of 16 bits if it has one.
const void* descriptor_named(const void* entries, uint16_t count, size_t size, const char* name);
const void* descriptor_numbered(const void* entries, uint16_t count, size_t size, uint16_t id);

/// Each of these functions returns the entry, or NULL if there is none. Upper and lower case are
/// distinguished.
const descriptor_parameter_t* descriptor_find_parameter(const subsystem_descriptor_t* descriptor,
                                                        const char* name);
const descriptor_event_t* descriptor_find_event(const subsystem_descriptor_t* descriptor, uint16_t id);
const descriptor_event_t* descriptor_find_event_name(const subsystem_descriptor_t* descriptor,
                                                     const char* name);
const descriptor_configuration_t* descriptor_find_configuration(const subsystem_descriptor_t* descriptor,
                                                                uint16_t id);
const descriptor_port_t* descriptor_find_port(const subsystem_descriptor_t* descriptor,
                                              const descriptor_configuration_t* configuration, uint16_t id);

/// Returns the name of a state, "OFFLINE" to "SOFTWARE_DEINIT", or "UNKNOWN". Never null.
const char* descriptor_state_name(uint8_t state);
/// Append the names of the states whose bits are set, separated by single spaces.
void descriptor_state_words(uint16_t states, text_t* out_words);
/// Find the number of a state by its name. STATUS_OK, STATUS_NOT_FOUND.
MUST_USE status_t descriptor_state_of(const char* name, uint8_t* out_state);

#endif // FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_DESCRIPTOR_H
