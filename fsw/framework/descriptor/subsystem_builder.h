// SPDX-License-Identifier: Apache-2.0
/// Builds the model of a subsystem descriptor while its elements are read. Internal to descriptor/.
#ifndef FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_BUILDER_H
#define FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_BUILDER_H

#include "fsw/framework/descriptor/source.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"

#define SUBSYSTEM_TIMEOUT_US 1000000U ///< Default time-out of a state.
#define SUBSYSTEM_WARN_PERCENT 75U
#define SUBSYSTEM_CLEAR_PERCENT 65U

typedef struct {
    source_t source;
    /// Names of the functions' configurations; they are resolved at the end.
    const char* function_configurations[DESCRIPTOR_FUNCTIONS_MAX];
    char group[DESCRIPTOR_PATH_MAX + 1U]; ///< Prefix of the structure being read: "OUTER.INNER.", or empty.
    uint8_t group_depth;
    uint16_t first_reference; ///< First reference of the report being read.
} subsystem_builder_t;

/// Clear the model and begin to read a document. The builder must outlive the document.
void descriptor_subsystem_builder_begin(subsystem_builder_t* builder, subsystem_descriptor_t* descriptor,
                                        const char* path, text_t* error);

// Lists and attributes that handlers use: subsystem_elements.c
extern const source_list_t descriptor_subsystem_configurations;
extern const source_list_t descriptor_subsystem_parameter_fields;
extern const source_list_t descriptor_subsystem_event_fields;
extern const source_list_t descriptor_subsystem_event_references;
extern const source_list_t descriptor_subsystem_structure_references;
extern const source_list_t descriptor_subsystem_sampled_references;
#define SUBSYSTEM_FIELD_ATTRIBUTES 5U
extern const source_attribute_t descriptor_subsystem_field_attributes[SUBSYSTEM_FIELD_ATTRIBUTES];

static inline subsystem_builder_t* descriptor_subsystem_builder_of(const source_t* const source)
{
    return source->builder;
}

static inline subsystem_descriptor_t* descriptor_subsystem_builder_model(const source_t* const source)
{
    return source->items[0];
}

/// Set enumeration, bounds and initial values of a field whose other attributes have been read.
void descriptor_subsystem_builder_complete(source_t* source, descriptor_field_t* field);
/// Read an attribute with as many values as the field has: numbers of its type within its bounds, or names
/// of its enumeration. Returns them as a text of numbers; "" after an error.
const char* descriptor_subsystem_builder_values(source_t* source, const char* attribute,
                                                const descriptor_field_t* field);
/// Set the offsets of a range of fields as the compiler lays out their structure. Returns the size of the
/// structure.
uint32_t descriptor_subsystem_builder_lay_out(subsystem_descriptor_t* descriptor, uint16_t first,
                                              uint16_t count);
/// Returns the size of a range of fields on the wire [octets].
uint32_t descriptor_subsystem_builder_octets(const subsystem_descriptor_t* descriptor, uint16_t first,
                                             uint16_t count);
/// Returns the size on the wire [octets] of the parameters to which a range of references refers.
uint32_t descriptor_subsystem_builder_referred(const subsystem_descriptor_t* descriptor, uint16_t first,
                                               uint16_t count);
/// Returns the parameter that an attribute names; NULL after an error.
const descriptor_parameter_t* descriptor_subsystem_builder_parameter(source_t* source, const char* attribute);
/// Append a reference to the parameter that the element names to the range of references of the enclosing
/// item.
void descriptor_subsystem_builder_refer(source_t* source, const source_list_t* list);

// Handlers: subsystem_builder.c
void descriptor_subsystem_builder_resources(source_t* source);
void descriptor_subsystem_builder_state(source_t* source);
/// Handler of a field that is identified by its order.
void descriptor_subsystem_builder_field(source_t* source);
void descriptor_subsystem_builder_event(source_t* source);
void descriptor_subsystem_builder_event_value(source_t* source);
void descriptor_subsystem_builder_event_end(source_t* source);
void descriptor_subsystem_builder_function(source_t* source);
void descriptor_subsystem_builder_argument(source_t* source);
void descriptor_subsystem_builder_function_end(source_t* source);
void descriptor_subsystem_builder_service(source_t* source);
void descriptor_subsystem_builder_end(source_t* source);

// Handlers of the contents of <Parameters>: parameter_builder.c
void descriptor_parameter_builder_scalars(source_t* source);
void descriptor_parameter_builder_struct(source_t* source);
void descriptor_parameter_builder_struct_end(source_t* source);
void descriptor_parameter_builder_group(source_t* source);
void descriptor_parameter_builder_group_end(source_t* source);
void descriptor_parameter_builder_member(source_t* source);

// Handlers of the contents of a <Configuration>: configuration_builder.c
void descriptor_configuration_builder_initial(source_t* source);
void descriptor_configuration_builder_loop(source_t* source);
void descriptor_configuration_builder_structure(source_t* source);
void descriptor_configuration_builder_structure_end(source_t* source);
void descriptor_configuration_builder_once_reference(source_t* source);
void descriptor_configuration_builder_sampled(source_t* source);
void descriptor_configuration_builder_sampled_reference(source_t* source);
void descriptor_configuration_builder_provides(source_t* source);
void descriptor_configuration_builder_requires(source_t* source);
void descriptor_configuration_builder_port_end(source_t* source);
void descriptor_configuration_builder_setting(source_t* source);
void descriptor_configuration_builder_quantity(source_t* source);
void descriptor_configuration_builder_supply(source_t* source);
// End nodes: endnode_builder.c
void descriptor_endnode_builder_start(source_t* source);
void descriptor_endnode_builder_field(source_t* source); ///< A field of a record.

/// Called at the end of the document: resolve the configurations of functions, check ports that occur in
/// several configurations, and compute the interface hash.
void descriptor_configuration_builder_resolve(source_t* source);

/// Returns the FNV-1a hash of the interface part, one line per entry; gse/generator computes the same hash.
uint64_t descriptor_subsystem_interface_hash(const subsystem_descriptor_t* descriptor);

#endif // FSW_FRAMEWORK_DESCRIPTOR_SUBSYSTEM_BUILDER_H
