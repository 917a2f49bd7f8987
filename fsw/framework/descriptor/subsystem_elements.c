// SPDX-License-Identifier: Apache-2.0
// The permitted contents of a subsystem descriptor, and the members of the model that store them.
#include "fsw/framework/descriptor/subsystem_builder.h"

#include "osal/include/osal/can_interface.h"

#include <string.h>

enum { // Kinds of elements.
    KIND_SUBSYSTEM = 1,
    KIND_RESOURCES,
    KIND_STATES,
    KIND_STATE,
    KIND_ENUMERATIONS,
    KIND_ENUMERATION,
    KIND_FAILURES,
    KIND_FAILURE,
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
    KIND_ENDNODE,
    KIND_RECORD_FIELD,
    KIND_SERVICES,
    KIND_SERVICE,
    KIND_QUANTITY,
    KIND_SUPPLY
};

// ---- Lists ----

#define LIST(plural, counter, most, type)                                                                    \
    .items = offsetof(subsystem_descriptor_t, storage.plural),                                               \
    .count = offsetof(subsystem_descriptor_t, counter), .capacity = CAPACITY_OF_STORAGE(most),               \
    .size = sizeof(type)
#define LINED(plural, counter, most, type) LIST(plural, counter, most, type), .line = offsetof(type, line)
#define RANGE(type, begin, length) .first = offsetof(type, begin), .number = offsetof(type, length)

#define FIELDS                                                                                               \
    .what = "fields in one descriptor", LINED(fields, field_count, DESCRIPTOR_FIELDS_MAX, descriptor_field_t)
#define REFERENCES                                                                                           \
    .what = "references to parameters", LIST(references, reference_count, DESCRIPTOR_REFERENCES_MAX, uint16_t)

static const source_list_t enumerations = {
    .what = "enumerations",
    LINED(enumerations, enumeration_count, DESCRIPTOR_ENUMERATIONS_MAX, descriptor_enumeration_t)};
static const source_list_t failures = {
    .what = "failures", LINED(failures, failure_count, DESCRIPTOR_FAILURES_MAX, descriptor_failure_t)};
static const source_list_t parameters = {
    .what = "parameters",
    LINED(parameters, parameter_count, DESCRIPTOR_PARAMETERS_MAX, descriptor_parameter_t)};
const source_list_t descriptor_subsystem_parameter_fields = {
    FIELDS, RANGE(descriptor_parameter_t, first_field, field_count)};
static const source_list_t events                         = {.what = "events",
                                                             LINED(events, event_count, DESCRIPTOR_EVENTS_MAX, descriptor_event_t)};
const source_list_t descriptor_subsystem_event_fields     = {FIELDS,
                                                             RANGE(descriptor_event_t, first_field, field_count)};
const source_list_t descriptor_subsystem_event_references = {
    REFERENCES, RANGE(descriptor_event_t, first_reference, reference_count)};
static const source_list_t functions = {
    .what = "functions", LINED(functions, function_count, DESCRIPTOR_FUNCTIONS_MAX, descriptor_function_t)};
static const source_list_t arguments = {FIELDS, RANGE(descriptor_function_t, first_argument, argument_count)};
static const source_list_t services  = {
     .what = "services", LINED(services, service_count, DESCRIPTOR_SERVICES_MAX, descriptor_service_t)};
const source_list_t descriptor_subsystem_configurations = {
    .what = "configurations",
    LINED(configurations, configuration_count, DESCRIPTOR_CONFIGURATIONS_MAX, descriptor_configuration_t)};
static const source_list_t initials = {
    .what = "<Initial>",
    LINED(initials, initial_count, DESCRIPTOR_INITIALS_MAX, descriptor_initial_t),
    RANGE(descriptor_configuration_t, first_initial, initial_count)};
static const source_list_t loops      = {.what = "<Loop>",
                                         LINED(loops, loop_count, DESCRIPTOR_LOOPS_MAX, descriptor_loop_t),
                                         RANGE(descriptor_configuration_t, first_loop, loop_count)};
static const source_list_t structures = {
    .what = "<HKService>",
    LINED(structures, structure_count, DESCRIPTOR_STRUCTURES_MAX, descriptor_structure_t),
    RANGE(descriptor_configuration_t, first_structure, structure_count)};
const source_list_t descriptor_subsystem_structure_references = {
    REFERENCES, RANGE(descriptor_structure_t, first_reference, reference_count)};
static const source_list_t sampled = {
    .what = "<SampledNREPTimes>",
    LIST(sampled, sampled_count, DESCRIPTOR_SAMPLED_MAX, descriptor_sampled_t),
    RANGE(descriptor_structure_t, first_sampled, sampled_count)};
const source_list_t descriptor_subsystem_sampled_references = {
    REFERENCES, RANGE(descriptor_sampled_t, first_reference, reference_count)};
static const source_list_t ports    = {.what = "ports",
                                       LINED(ports, port_count, DESCRIPTOR_PORTS_MAX, descriptor_port_t),
                                       RANGE(descriptor_configuration_t, first_port, port_count)};
static const source_list_t elements = {FIELDS, RANGE(descriptor_port_t, first_field, field_count)};
static const source_list_t devices  = {
     .what = "devices",
     LINED(devices, device_count, DESCRIPTOR_DEVICES_MAX, descriptor_device_t),
     RANGE(descriptor_configuration_t, first_device, device_count)};
static const source_list_t settings = {
    .what = "<Setting>",
    LINED(settings, setting_count, DESCRIPTOR_SETTINGS_MAX, descriptor_setting_t),
    RANGE(descriptor_device_t, first_setting, setting_count)};
static const source_list_t quantities = {
    .what = "<Quantity>",
    LINED(quantities, quantity_count, DESCRIPTOR_QUANTITIES_MAX, descriptor_quantity_t),
    RANGE(descriptor_device_t, first_quantity, quantity_count)};
static const source_list_t supplies = {
    .what = "<Supply>",
    LINED(supplies, supply_count, DESCRIPTOR_SUPPLIES_MAX, descriptor_supply_t),
    RANGE(descriptor_device_t, first_supply, supply_count)};
static const source_list_t record_fields = {
    .what = "<Field>",
    LINED(record_fields, record_field_count, DESCRIPTOR_RECORD_FIELDS_MAX, descriptor_record_field_t),
    RANGE(descriptor_device_t, first_record_field, record_field_count)};
static const source_list_t endnodes = {
    .what = "<Endnode>",
    LINED(endnodes, endnode_count, DESCRIPTOR_ENDNODES_MAX, descriptor_endnode_t),
    RANGE(descriptor_device_t, first_endnode, endnode_count)};

// ---- Attributes ----

#define IS_STRUCT                                                                                            \
    {                                                                                                        \
        .name = "type", .form = SOURCE_WORD | SOURCE_NEEDED, .words = "STRUCT"                               \
    }
#define TYPE(type_of_item)                                                                                   \
    {                                                                                                        \
        .name = "type", .form = SOURCE_TYPE | SOURCE_NEEDED, SOURCE_TO(type_of_item, type)                   \
    }

static const source_attribute_t subsystem_attributes[] = {
    SOURCE_STRING("name", SOURCE_UPPER | SOURCE_NEEDED, DESCRIPTOR_NAME_MAX, subsystem_descriptor_t, name),
    SOURCE_WITHIN("id", SOURCE_UNSIGNED | SOURCE_NEEDED, 1U, 2046U, 0U, subsystem_descriptor_t, apid),
    SOURCE_WITHIN("samplingTime", SOURCE_TIME, 100U, 10000000U, 10000U, subsystem_descriptor_t, sampling_us),
    SOURCE_CHOICE("sync", SOURCE_WORD, "AFTER_COMMANDS BEFORE_COMMANDS", 0U, 0U, subsystem_descriptor_t,
                  is_sync_first),
};
static const source_attribute_t resources_attributes[] = {
    SOURCE_WITHIN("poolWarning", SOURCE_UNSIGNED, 1U, 100U, SUBSYSTEM_WARN_PERCENT, subsystem_descriptor_t,
                  pool_warn_percent),
    SOURCE_WITHIN("poolClear", SOURCE_UNSIGNED, 0U, 99U, SUBSYSTEM_CLEAR_PERCENT, subsystem_descriptor_t,
                  pool_clear_percent),
};
static const source_attribute_t state_attributes[] = {
    SOURCE_REQUIRED("name"),
    {.name = "timeout", .form = SOURCE_TIME | SOURCE_NEEDED, .low = 1000U, .high = 600000000U},
};
static const source_attribute_t enumeration_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_enumeration_t),
    SOURCE_WITHIN("first", SOURCE_UNSIGNED, 0U, 65535U, 0U, descriptor_enumeration_t, first),
    SOURCE_STRING("values", SOURCE_NAMES | SOURCE_NEEDED, DESCRIPTOR_NAME_MAX, descriptor_enumeration_t,
                  values)};
static const source_attribute_t failure_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_failure_t),
    SOURCE_NUMBERED(1U, DESCRIPTOR_FAILURE_IDS, descriptor_failure_t, id),
    {.name = "detail", .form = SOURCE_UPPER, .high = DESCRIPTOR_NAME_MAX}, // Only ground tools use it.
};
static const source_attribute_t struct_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_parameter_t),
    SOURCE_WITHIN("id", SOURCE_UNSIGNED | SOURCE_NEEDED, 0U, 65535U, 0U, descriptor_parameter_t, number),
    IS_STRUCT,
    SOURCE_SWITCH("settable", 0U, descriptor_parameter_t, is_settable),
};
static const source_attribute_t group_attributes[] = {
    {.name = "name", .form = SOURCE_UPPER | SOURCE_NEEDED, .high = DESCRIPTOR_NAME_MAX},
    {.name = "id", .form = SOURCE_UNSIGNED, .high = 65535U},
    IS_STRUCT,
};
static const source_attribute_t member_attributes[] = {
    SOURCE_STRING("name", SOURCE_UPPER | SOURCE_NEEDED, DESCRIPTOR_NAME_MAX, descriptor_field_t, name),
    {.name = "id", .form = SOURCE_UNSIGNED, .high = 65535U},
    TYPE(descriptor_field_t),
    SOURCE_WITHIN("count", SOURCE_UNSIGNED, 1U, 256U, 1U, descriptor_field_t, count),
    SOURCE_STRING("unit", SOURCE_TEXT, 16U, descriptor_field_t, unit),
    SOURCE_OPTION("init"),
    SOURCE_OPTION("min"),
    SOURCE_OPTION("max"),
    SOURCE_OPTION("enumeration"),
};
static const source_attribute_t parameter_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_parameter_t),
    SOURCE_WITHIN("id", SOURCE_UNSIGNED | SOURCE_NEEDED, 0U, 65535U, 0U, descriptor_parameter_t, number),
    SOURCE_REQUIRED("type"),
    SOURCE_OPTION("count"),
    SOURCE_OPTION("unit"),
    SOURCE_OPTION("init"),
    SOURCE_OPTION("min"),
    SOURCE_OPTION("max"),
    SOURCE_OPTION("enumeration"),
    SOURCE_SWITCH("settable", 0U, descriptor_parameter_t, is_settable),
};
const source_attribute_t descriptor_subsystem_field_attributes[SUBSYSTEM_FIELD_ATTRIBUTES] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_field_t), TYPE(descriptor_field_t),
    SOURCE_WITHIN("count", SOURCE_UNSIGNED, 1U, 256U, 1U, descriptor_field_t, count),
    SOURCE_STRING("unit", SOURCE_TEXT, 16U, descriptor_field_t, unit), SOURCE_OPTION("enumeration")};
static const source_attribute_t event_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_event_t),
    SOURCE_NUMBERED(1U, 65535U, descriptor_event_t, id),
    SOURCE_CHOICE("severity", SOURCE_WORD | SOURCE_NEEDED, DESCRIPTOR_SEVERITY_WORDS, DESCRIPTOR_INFORMATIVE,
                  0U, descriptor_event_t, severity),
    SOURCE_OPTION("rate"),
    SOURCE_WITHIN("burst", SOURCE_UNSIGNED, 1U, 255U, 20U, descriptor_event_t, burst),
};
static const source_attribute_t event_value_attributes[] = {SOURCE_REQUIRED("name"), SOURCE_OPTION("type"),
                                                            SOURCE_OPTION("count"), SOURCE_OPTION("unit"),
                                                            SOURCE_OPTION("enumeration")};
static const source_attribute_t function_attributes[]    = {
       SOURCE_STRING("name", SOURCE_UPPER | SOURCE_NEEDED | SOURCE_UNIQUE, DESCRIPTOR_FUNCTION_NAME_MAX,
                     descriptor_function_t, name),
       SOURCE_NUMBERED(1U, 65535U, descriptor_function_t, id),
       SOURCE_REQUIRED("states"),
       SOURCE_OPTION("configurations"),
       SOURCE_CHECKED("critical", SOURCE_FLAG), // Only ground tools use it.
};
static const source_attribute_t argument_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_field_t),
    SOURCE_WITHIN("id", SOURCE_UNSIGNED | SOURCE_NEEDED | SOURCE_UNIQUE, 0U, 65535U, 0U, descriptor_field_t,
                  id),
    TYPE(descriptor_field_t),
    SOURCE_WITHIN("count", SOURCE_UNSIGNED, 1U, 256U, 1U, descriptor_field_t, count),
    SOURCE_STRING("unit", SOURCE_TEXT, 16U, descriptor_field_t, unit),
    SOURCE_OPTION("min"),
    SOURCE_OPTION("max"),
    SOURCE_OPTION("enumeration"),
};
static const source_attribute_t service_attributes[] = {SOURCE_REQUIRED("type"), SOURCE_OPTION("capacity"),
                                                        SOURCE_OPTION("functional")};
static const source_attribute_t configuration_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_configuration_t),
    SOURCE_NUMBERED(1U, 65535U, descriptor_configuration_t, id),
    SOURCE_WITHIN("priority", SOURCE_UNSIGNED | SOURCE_NEEDED, 1U, 99U, 0U, descriptor_configuration_t,
                  priority),
    SOURCE_WITHIN("samplingTime", SOURCE_TIME | SOURCE_NEEDED, 100U, 10000000U, 0U,
                  descriptor_configuration_t, sampling_us)};
static const source_attribute_t initial_attributes[] = {
    SOURCE_REQUIRED("parameter"),
    SOURCE_OPTION("field"),
    SOURCE_REQUIRED("value"),
};
static const source_attribute_t loop_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_loop_t),
    SOURCE_WITHIN("samplingTime", SOURCE_TIME | SOURCE_NEEDED, 100U, 10000000U, 0U, descriptor_loop_t,
                  sampling_us),
    SOURCE_WITHIN("priority", SOURCE_UNSIGNED | SOURCE_NEEDED, 1U, 99U, 0U, descriptor_loop_t, priority),
    SOURCE_OPTION("services")};
static const source_attribute_t structure_attributes[] = {
    SOURCE_NUMBERED(1U, 65535U, descriptor_structure_t, id),
    SOURCE_WITHIN("interval", SOURCE_UNSIGNED | SOURCE_NEEDED, 1U, UINT32_MAX, 0U, descriptor_structure_t,
                  interval_cycles),
    SOURCE_SWITCH("enabled", 1U, descriptor_structure_t, is_enabled),
    SOURCE_CHECKED("display", SOURCE_FLAG), // Only ground tools use it.
    SOURCE_OPTION("loop"),
};
static const source_attribute_t reference_attributes[] = {SOURCE_REQUIRED("name")};
static const source_attribute_t sampled_attributes[]   = {
      SOURCE_WITHIN("nrep", SOURCE_UNSIGNED | SOURCE_NEEDED, 2U, 1000U, 0U, descriptor_sampled_t, nrep),
};
#define PROVIDES_ATTRIBUTES 3U // Provides has the first three of these attributes, Requires has all.
static const source_attribute_t port_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_port_t),
    SOURCE_NUMBERED(1U, 65535U, descriptor_port_t, id),
    SOURCE_REQUIRED("methods"),
    SOURCE_SWITCH("required", 1U, descriptor_port_t, is_required),
    SOURCE_WITHIN("staleAfter", SOURCE_TIME, 100U, 60000000U, 0U, descriptor_port_t, stale_us),
};
static const source_attribute_t device_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_device_t),
    SOURCE_STRING("type", SOURCE_LOWER | SOURCE_NEEDED, DESCRIPTOR_NAME_MAX, descriptor_device_t, type),
};
static const source_attribute_t setting_attributes[] = {SOURCE_REQUIRED("object"), TYPE(descriptor_setting_t),
                                                        SOURCE_REQUIRED("value")};
static const source_attribute_t quantity_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_quantity_t),
    SOURCE_WITHIN("id", SOURCE_UNSIGNED | SOURCE_NEEDED | SOURCE_UNIQUE, 0U, 65535U, 0U,
                  descriptor_quantity_t, id),
    SOURCE_REQUIRED("object"),
    TYPE(descriptor_quantity_t),
    SOURCE_REQUIRED("scale"),
    SOURCE_STRING("unit", SOURCE_TEXT, 16U, descriptor_quantity_t, unit),
    SOURCE_SWITCH("settable", 0U, descriptor_quantity_t, is_settable),
};
static const source_attribute_t supply_attributes[] = {
    SOURCE_WITHIN("unit", SOURCE_UNSIGNED | SOURCE_NEEDED, 1U, 127U, 0U, descriptor_supply_t, unit),
    SOURCE_WITHIN("on", SOURCE_UNSIGNED | SOURCE_NEEDED, 1U, 255U, 0U, descriptor_supply_t, on),
    SOURCE_WITHIN("off", SOURCE_UNSIGNED | SOURCE_NEEDED, 1U, 255U, 0U, descriptor_supply_t, off),
};
static const source_attribute_t record_field_attributes[] = {
    SOURCE_NAMED(SOURCE_UPPER, descriptor_record_field_t),
    SOURCE_CHOICE("direction", SOURCE_WORD | SOURCE_NEEDED, "IN OUT", 0U, 0U, descriptor_record_field_t,
                  is_out),
    TYPE(descriptor_record_field_t),
    SOURCE_OPTION("scale"),
    SOURCE_OPTION("offset"),
    SOURCE_OPTION("safe"),
    SOURCE_STRING("unit", SOURCE_TEXT, 16U, descriptor_record_field_t, unit),
};
// endnode_builder.c depends on the order of these attributes.
static const source_attribute_t endnode_attributes[] = {
    SOURCE_CHOICE("type", SOURCE_WORD | SOURCE_NEEDED, "CAN SHM MQUEUE UDP TCP SERIAL FILE", 0U, 0U,
                  descriptor_endnode_t, type),
    SOURCE_STRING("bus", SOURCE_LOWER, OSAL_CAN_INTERFACE_NAME_MAX, descriptor_endnode_t, bus),
    SOURCE_STRING("redundantBus", SOURCE_LOWER, OSAL_CAN_INTERFACE_NAME_MAX, descriptor_endnode_t,
                  redundant_bus),
    SOURCE_WITHIN("node", SOURCE_UNSIGNED, 1U, 127U, 0U, descriptor_endnode_t, node),
    SOURCE_STRING("name", SOURCE_TEXT, 255U, descriptor_endnode_t, name),
    SOURCE_STRING("address", SOURCE_TEXT, 255U, descriptor_endnode_t, address),
    SOURCE_WITHIN("port", SOURCE_UNSIGNED, 1U, 65535U, 0U, descriptor_endnode_t, port),
    SOURCE_CHOICE("framing", SOURCE_WORD, "RAW LENGTH SLIP LINE", 0U, 0U, descriptor_endnode_t,
                  format.framing),
    SOURCE_CHOICE("order", SOURCE_WORD, "BIG LITTLE", 0U, 0U, descriptor_endnode_t, format.order),
    SOURCE_CHOICE("direction", SOURCE_WORD, "BOTH READ WRITE", 0U, 0U, descriptor_endnode_t,
                  format.direction),
    SOURCE_CHOICE("baud", SOURCE_WORD, "9600 19200 38400 57600 115200 230400 460800 921600", 0U, 4U,
                  descriptor_endnode_t, format.baud),
    SOURCE_SWITCH("checksum", 0U, descriptor_endnode_t, has_checksum),
    SOURCE_WITHIN("silence", SOURCE_TIME, 100U, 60000000U, 100000U, descriptor_endnode_t, silence_us),
    SOURCE_WITHIN("retry", SOURCE_TIME, 100U, 60000000U, 10000U, descriptor_endnode_t, retry_us),
    SOURCE_WITHIN("retryLongest", SOURCE_TIME, 100U, 60000000U, 1000000U, descriptor_endnode_t, longest_us),
};

// ---- Elements ----

#define WITH(name, attributes) SOURCE_COUNT(attributes), (name), (attributes)
#define PLAIN(name) 0U, (name), NULL

// Parent, kind, number of occurrences, name with attributes, list, start handler, end handler.
static const source_row_t rows[] = {
    {SOURCE_ROOT, KIND_SUBSYSTEM, SOURCE_ANY, WITH("Subsystem", subsystem_attributes), NULL, NULL,
     descriptor_subsystem_builder_end},
    {KIND_SUBSYSTEM, KIND_RESOURCES, SOURCE_ONCE, WITH("Resources", resources_attributes), NULL,
     descriptor_subsystem_builder_resources, NULL},
    {KIND_SUBSYSTEM, KIND_STATES, SOURCE_ONCE, PLAIN("States"), NULL, NULL, NULL},
    {KIND_STATES, KIND_STATE, SOURCE_ANY, WITH("State", state_attributes), NULL,
     descriptor_subsystem_builder_state, NULL},
    {KIND_SUBSYSTEM, KIND_ENUMERATIONS, SOURCE_ONCE, PLAIN("Enumerations"), NULL, NULL, NULL},
    {KIND_ENUMERATIONS, KIND_ENUMERATION, SOURCE_ANY, WITH("Enumeration", enumeration_attributes),
     &enumerations, NULL, NULL},
    {KIND_SUBSYSTEM, KIND_FAILURES, SOURCE_ONCE, PLAIN("Failures"), NULL, NULL, NULL},
    {KIND_FAILURES, KIND_FAILURE, SOURCE_ANY, WITH("Failure", failure_attributes), &failures, NULL, NULL},
    {KIND_SUBSYSTEM, KIND_PARAMETERS, SOURCE_ONCE, PLAIN("Parameters"), NULL, NULL, NULL},
    {KIND_PARAMETERS, KIND_STRUCT, SOURCE_ANY, WITH("StructRef", struct_attributes), &parameters,
     descriptor_parameter_builder_struct, descriptor_parameter_builder_struct_end},
    {KIND_STRUCT, KIND_MEMBER, SOURCE_ANY, WITH("ParamRef", member_attributes),
     &descriptor_subsystem_parameter_fields, descriptor_parameter_builder_member, NULL},
    {KIND_STRUCT, KIND_GROUP, SOURCE_ANY, WITH("StructRef", group_attributes), NULL,
     descriptor_parameter_builder_group, descriptor_parameter_builder_group_end},
    {KIND_GROUP, KIND_MEMBER, SOURCE_ANY, WITH("ParamRef", member_attributes),
     &descriptor_subsystem_parameter_fields, descriptor_parameter_builder_member, NULL},
    {KIND_GROUP, KIND_GROUP, SOURCE_ANY, WITH("StructRef", group_attributes), NULL,
     descriptor_parameter_builder_group, descriptor_parameter_builder_group_end},
    {KIND_PARAMETERS, KIND_PARAMETER, SOURCE_ANY, WITH("ParamRef", parameter_attributes), &parameters,
     descriptor_parameter_builder_scalars, NULL},
    {KIND_SUBSYSTEM, KIND_EVENTS, SOURCE_ONCE, PLAIN("Events"), NULL, NULL, NULL},
    {KIND_EVENTS, KIND_EVENT, SOURCE_ANY, WITH("Event", event_attributes), &events,
     descriptor_subsystem_builder_event, descriptor_subsystem_builder_event_end},
    {KIND_EVENT, KIND_EVENT_VALUE, SOURCE_ANY, WITH("ParamRef", event_value_attributes), NULL,
     descriptor_subsystem_builder_event_value, NULL},
    {KIND_SUBSYSTEM, KIND_FUNCTIONS, SOURCE_ONCE, PLAIN("Functions"), NULL, NULL, NULL},
    {KIND_FUNCTIONS, KIND_FUNCTION, SOURCE_ANY, WITH("Function", function_attributes), &functions,
     descriptor_subsystem_builder_function, descriptor_subsystem_builder_function_end},
    {KIND_FUNCTION, KIND_ARGUMENT, SOURCE_ANY, WITH("Argument", argument_attributes), &arguments,
     descriptor_subsystem_builder_argument, NULL},
    {KIND_SUBSYSTEM, KIND_SERVICES, SOURCE_ONCE, PLAIN("Services"), NULL, NULL, NULL},
    {KIND_SERVICES, KIND_SERVICE, SOURCE_ANY, WITH("Service", service_attributes), &services,
     descriptor_subsystem_builder_service, NULL},
    {KIND_SUBSYSTEM, KIND_CONFIGURATION, SOURCE_ANY, WITH("Configuration", configuration_attributes),
     &descriptor_subsystem_configurations, NULL, NULL},
    {KIND_CONFIGURATION, KIND_INITIAL, SOURCE_ANY, WITH("Initial", initial_attributes), &initials,
     descriptor_configuration_builder_initial, NULL},
    {KIND_CONFIGURATION, KIND_LOOP, SOURCE_ANY, WITH("Loop", loop_attributes), &loops,
     descriptor_configuration_builder_loop, NULL},
    {KIND_CONFIGURATION, KIND_STRUCTURE, SOURCE_ANY, WITH("HKService", structure_attributes), &structures,
     descriptor_configuration_builder_structure, descriptor_configuration_builder_structure_end},
    {KIND_STRUCTURE, KIND_ONCE, SOURCE_ONCE, PLAIN("SampledOnce"), NULL, NULL, NULL},
    {KIND_ONCE, KIND_ONCE_REFERENCE, SOURCE_SOME, WITH("ParamRef", reference_attributes), NULL,
     descriptor_configuration_builder_once_reference, NULL},
    {KIND_STRUCTURE, KIND_SAMPLED, SOURCE_ANY, WITH("SampledNREPTimes", sampled_attributes), &sampled,
     descriptor_configuration_builder_sampled, NULL},
    {KIND_SAMPLED, KIND_SAMPLED_REFERENCE, SOURCE_SOME, WITH("ParamRef", reference_attributes), NULL,
     descriptor_configuration_builder_sampled_reference, NULL},
    {KIND_CONFIGURATION, KIND_LINKS, SOURCE_ONCE, PLAIN("RTLinkService"), NULL, NULL, NULL},
    {KIND_LINKS, KIND_PROVIDES, SOURCE_ANY, PROVIDES_ATTRIBUTES, "Provides", port_attributes, &ports,
     descriptor_configuration_builder_provides, descriptor_configuration_builder_port_end},
    {KIND_LINKS, KIND_REQUIRES, SOURCE_ANY, WITH("Requires", port_attributes), &ports,
     descriptor_configuration_builder_requires, descriptor_configuration_builder_port_end},
    {KIND_PROVIDES, KIND_ELEMENT, SOURCE_SOME, WITH("ParamRef", descriptor_subsystem_field_attributes),
     &elements, descriptor_subsystem_builder_field, NULL},
    {KIND_REQUIRES, KIND_ELEMENT, SOURCE_SOME, WITH("ParamRef", descriptor_subsystem_field_attributes),
     &elements, descriptor_subsystem_builder_field, NULL},
    {KIND_CONFIGURATION, KIND_DEVICES, SOURCE_ONCE, PLAIN("Devices"), NULL, NULL, NULL},
    {KIND_DEVICES, KIND_DEVICE, SOURCE_ANY, WITH("Device", device_attributes), &devices, NULL, NULL},
    {KIND_DEVICE, KIND_SETTING, SOURCE_ANY, WITH("Setting", setting_attributes), &settings,
     descriptor_configuration_builder_setting, NULL},
    {KIND_DEVICE, KIND_QUANTITY, SOURCE_ANY, WITH("Quantity", quantity_attributes), &quantities,
     descriptor_configuration_builder_quantity, NULL},
    {KIND_DEVICE, KIND_SUPPLY, SOURCE_ANY, WITH("Supply", supply_attributes), &supplies,
     descriptor_configuration_builder_supply, NULL},
    {KIND_DEVICE, KIND_RECORD_FIELD, SOURCE_ANY, WITH("Field", record_field_attributes), &record_fields,
     descriptor_endnode_builder_field, NULL},
    {KIND_DEVICE, KIND_ENDNODE, SOURCE_ANY, WITH("Endnode", endnode_attributes), &endnodes,
     descriptor_endnode_builder_start, NULL},
};

void descriptor_subsystem_builder_begin(subsystem_builder_t* const builder,
                                        subsystem_descriptor_t* const descriptor, const char* const path,
                                        text_t* const error)
{
    descriptor_subsystem_clear(descriptor);
    (void)memset(builder, 0, sizeof *builder);
    descriptor->pool_warn_percent  = SUBSYSTEM_WARN_PERCENT;
    descriptor->pool_clear_percent = SUBSYSTEM_CLEAR_PERCENT;
    builder->source.path           = path;
    builder->source.error          = error;
    builder->source.rows           = rows;
    builder->source.row_count      = SOURCE_COUNT(rows);
    builder->source.items[0]       = descriptor;
    builder->source.text           = descriptor->storage.text;
    builder->source.text_capacity  = sizeof descriptor->storage.text;
    builder->source.text_used      = &descriptor->text_used;
    builder->source.builder        = builder;
}
