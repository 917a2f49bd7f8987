// SPDX-License-Identifier: Apache-2.0
/// Builds the model of a subsystem descriptor while its elements are read. Internal to descriptor/.
#ifndef FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_BUILDER_H
#define FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_BUILDER_H

#include "fsw/framework/descriptor/source.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"

typedef struct {
    source_t source;
    subsystem_descriptor_t* descriptor;
    const char* function_configurations[DESCRIPTOR_FUNCTIONS_MAX]; ///< Texts, resolved at the end.
    char group[DESCRIPTOR_PATH_MAX + 1U]; ///< Of the structure being read: "OUTER.INNER.", or empty.
    uint8_t group_depth;
    uint16_t first_reference; ///< Of the housekeeping structure being read.
    uint32_t seen;            ///< Bit n: the element of kind n that may stand only once has been read.
} subsystem_builder_t;

enum { // Kinds of elements.
    KIND_SUBSYSTEM = 1,
    KIND_RESOURCES,
    KIND_STATES,
    KIND_STATE,
    KIND_PARAMETERS,
    KIND_STRUCT,
    KIND_GROUP,
    KIND_MEMBER,
    KIND_PARAMETER,
    KIND_EVENTS,
    KIND_EVENT,
    KIND_EVENT_VALUE,
    KIND_FUNCTIONS,
    KIND_FUNCTION,
    KIND_ARGUMENT,
    KIND_CONFIGURATION,
    KIND_INITIAL,
    KIND_LOOP,
    KIND_STRUCTURE,
    KIND_ONCE,
    KIND_ONCE_REFERENCE,
    KIND_SAMPLED,
    KIND_SAMPLED_REFERENCE,
    KIND_LINKS,
    KIND_PROVIDES,
    KIND_REQUIRES,
    KIND_ELEMENT,
    KIND_DEVICES,
    KIND_DEVICE,
    KIND_SETTING,
    KIND_ENDNODE
};

/// Empty the model and begin. The builder outlives the document.
void subsystem_builder_begin(subsystem_builder_t* builder, subsystem_descriptor_t* descriptor,
                             const char* path, text_t* error);

subsystem_builder_t* subsystem_builder_of(source_t* source);
/// Refuse a second element of a kind that may stand only once.
void subsystem_builder_once(source_t* source, uint8_t kind);
/// Read a field into the list of fields; NULL after an error.
descriptor_field_t* subsystem_builder_field(source_t* source, uint16_t index);
/// Check `count` numbers of a field's type within its bounds.
void subsystem_builder_check_values(source_t* source, const char* attribute, const descriptor_field_t* field);
/// Offsets of a range of fields as the compiler lays out the structure of them; returns its size.
uint32_t subsystem_builder_lay_out(subsystem_descriptor_t* descriptor, uint16_t first, uint16_t count);
/// Octets of a range of fields on the wire.
uint32_t subsystem_builder_octets(const subsystem_descriptor_t* descriptor, uint16_t first, uint16_t count);
/// Refuse a field whose name one before it in [first, field_count - 1) has.
void subsystem_builder_check_field_name(source_t* source, uint16_t first);
/// Append a reference to the parameter of the element's name.
void subsystem_builder_refer(source_t* source);
void subsystem_builder_taken(source_t* source, const char* attribute, const char* value, uint32_t line);

// Handlers of what <Parameters> holds: parameter_builder.c
void parameter_builder_start(source_t* source);
void parameter_builder_scalars(source_t* source);
void parameter_builder_struct(source_t* source);
void parameter_builder_struct_end(source_t* source);
void parameter_builder_group(source_t* source);
void parameter_builder_group_end(source_t* source);
void parameter_builder_member(source_t* source);

// Handlers of what a <Configuration> holds: configuration_builder.c
void configuration_builder_start(source_t* source);
void configuration_builder_initial(source_t* source);
void configuration_builder_loop(source_t* source);
void configuration_builder_structure(source_t* source);
void configuration_builder_structure_end(source_t* source);
void configuration_builder_once(source_t* source);
void configuration_builder_once_reference(source_t* source);
void configuration_builder_sampled(source_t* source);
void configuration_builder_sampled_reference(source_t* source);
void configuration_builder_links(source_t* source);
void configuration_builder_provides(source_t* source);
void configuration_builder_requires(source_t* source);
void configuration_builder_element(source_t* source);
void configuration_builder_port_end(source_t* source);
void configuration_builder_devices(source_t* source);
void configuration_builder_device(source_t* source);
void configuration_builder_setting(source_t* source);
// End nodes: endnode_builder.c
void endnode_builder_start(source_t* source);

/// End of the document: functions' configurations, ports that several configurations share, interface hash.
void configuration_builder_resolve(source_t* source);

/// FNV-1a over the interface part, one line per thing; gse/generator hashes the same text.
uint64_t subsystem_interface_hash(const subsystem_descriptor_t* descriptor);

#endif // FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_BUILDER_H
