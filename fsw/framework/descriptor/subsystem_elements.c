// SPDX-License-Identifier: Apache-2.0
// The permitted contents of a subsystem descriptor, and their places in the model.
#include "fsw/framework/descriptor/subsystem_builder.h"

#include <string.h>

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
    KIND_ENDNODE,
    KIND_SERVICES,
    KIND_SERVICE,
    KIND_QUANTITY,
    KIND_SUPPLY
};

// ---- Lists ----

#define LIST(plural, counter, most, type)                                                                    \
    .items = offsetof(subsystem_descriptor_t, plural), .count = offsetof(subsystem_descriptor_t, counter),   \
    .capacity = (most), .size = sizeof(type)
#define RANGE(type, begin, length) .first = offsetof(type, begin), .number = offsetof(type, length)

#define FIELDS                                                                                               \
    .what = "fields in one descriptor",                                                                      \
    LIST(fields, field_count, DESCRIPTOR_FIELDS_MAX, descriptor_field_t),                                    \
    .line = offsetof(descriptor_field_t, line)
#define REFERENCES                                                                                           \
    .what = "references to parameters", LIST(references, reference_count, DESCRIPTOR_REFERENCES_MAX, uint16_t)

static const source_list_t parameters = {
    .what = "parameters",
    LIST(parameters, parameter_count, DESCRIPTOR_PARAMETERS_MAX, descriptor_parameter_t),
    .line = offsetof(descriptor_parameter_t, line)};
const source_list_t descriptor_subsystem_parameter_fields = {
    FIELDS, RANGE(descriptor_parameter_t, first_field, field_count)};
static const source_list_t events                         = {.what = "events",
                                                             LIST(events, event_count, DESCRIPTOR_EVENTS_MAX, descriptor_event_t),
                                                             .line = offsetof(descriptor_event_t, line)};
const source_list_t descriptor_subsystem_event_fields     = {FIELDS,
                                                             RANGE(descriptor_event_t, first_field, field_count)};
const source_list_t descriptor_subsystem_event_references = {
    REFERENCES, RANGE(descriptor_event_t, first_reference, reference_count)};
static const source_list_t functions = {
    .what = "functions",
    LIST(functions, function_count, DESCRIPTOR_FUNCTIONS_MAX, descriptor_function_t),
    .line = offsetof(descriptor_function_t, line)};
static const source_list_t arguments = {FIELDS, RANGE(descriptor_function_t, first_argument, argument_count)};
static const source_list_t services  = {
     .what = "services",
     LIST(services, service_count, DESCRIPTOR_SERVICES_MAX, descriptor_service_t),
     .line = offsetof(descriptor_service_t, line)};
const source_list_t descriptor_subsystem_configurations = {
    .what = "configurations",
    LIST(configurations, configuration_count, DESCRIPTOR_CONFIGURATIONS_MAX, descriptor_configuration_t),
    .line = offsetof(descriptor_configuration_t, line)};
static const source_list_t initials = {
    .what = "<Initial>",
    LIST(initials, initial_count, DESCRIPTOR_INITIALS_MAX, descriptor_initial_t),
    .line = offsetof(descriptor_initial_t, line),
    RANGE(descriptor_configuration_t, first_initial, initial_count)};
static const source_list_t loops      = {.what = "<Loop>",
                                         LIST(loops, loop_count, DESCRIPTOR_LOOPS_MAX, descriptor_loop_t),
                                         .line = offsetof(descriptor_loop_t, line),
                                         RANGE(descriptor_configuration_t, first_loop, loop_count)};
static const source_list_t structures = {
    .what = "<HKService>",
    LIST(structures, structure_count, DESCRIPTOR_STRUCTURES_MAX, descriptor_structure_t),
    .line = offsetof(descriptor_structure_t, line),
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
                                       LIST(ports, port_count, DESCRIPTOR_PORTS_MAX, descriptor_port_t),
                                       .line = offsetof(descriptor_port_t, line),
                                       RANGE(descriptor_configuration_t, first_port, port_count)};
static const source_list_t elements = {FIELDS, RANGE(descriptor_port_t, first_field, field_count)};
static const source_list_t devices  = {
     .what = "devices",
     LIST(devices, device_count, DESCRIPTOR_DEVICES_MAX, descriptor_device_t),
     .line = offsetof(descriptor_device_t, line),
     RANGE(descriptor_configuration_t, first_device, device_count)};
static const source_list_t settings = {
    .what = "<Setting>",
    LIST(settings, setting_count, DESCRIPTOR_SETTINGS_MAX, descriptor_setting_t),
    .line = offsetof(descriptor_setting_t, line),
    RANGE(descriptor_device_t, first_setting, setting_count)};
static const source_list_t quantities = {
    .what = "<Quantity>",
    LIST(quantities, quantity_count, DESCRIPTOR_QUANTITIES_MAX, descriptor_quantity_t),
    .line = offsetof(descriptor_quantity_t, line),
    RANGE(descriptor_device_t, first_quantity, quantity_count)};
static const source_list_t supplies = {
    .what = "<Supply>",
    LIST(supplies, supply_count, DESCRIPTOR_SUPPLIES_MAX, descriptor_supply_t),
    .line = offsetof(descriptor_supply_t, line),
    RANGE(descriptor_device_t, first_supply, supply_count)};
static const source_list_t endnodes = {
    .what = "<Endnode>",
    LIST(endnodes, endnode_count, DESCRIPTOR_ENDNODES_MAX, descriptor_endnode_t),
    .line = offsetof(descriptor_endnode_t, line),
    RANGE(descriptor_device_t, first_endnode, endnode_count)};

// ---- Attributes ----

#define NAMED(type)                                                                                          \
    {                                                                                                        \
        .name = "name", .form = SOURCE_UPPER | SOURCE_NEEDED | SOURCE_UNIQUE, .high = DESCRIPTOR_NAME_MAX,   \
        SOURCE_TO(type, name)                                                                                \
    }
#define NUMBERED(type)                                                                                       \
    {                                                                                                        \
        .name = "id", .form = SOURCE_UNSIGNED | SOURCE_NEEDED | SOURCE_UNIQUE, .low = 1U, .high = 65535U,    \
        SOURCE_TO(type, id)                                                                                  \
    }
#define NUMBER_ID                                                                                            \
    {                                                                                                        \
        .name = "id", .form = SOURCE_UNSIGNED, .high = 65535U                                                \
    }
#define FREE(id)                                                                                             \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FREE                                                                    \
    }
#define FREE_NEEDED(id)                                                                                      \
    {                                                                                                        \
        .name = (id), .form = SOURCE_FREE | SOURCE_NEEDED                                                    \
    }
#define SAMPLING(type)                                                                                       \
    {                                                                                                        \
        .name = "samplingTime", .form = SOURCE_TIME | SOURCE_NEEDED, .low = 100U, .high = 10000000U,         \
        SOURCE_TO(type, sampling_us)                                                                         \
    }
#define PRIORITY(type)                                                                                       \
    {                                                                                                        \
        .name = "priority", .form = SOURCE_UNSIGNED | SOURCE_NEEDED, .low = 1U, .high = 99U,                 \
        SOURCE_TO(type, priority)                                                                            \
    }
#define METHODS FREE_NEEDED("methods")
#define SEVERITIES .words = DESCRIPTOR_SEVERITY_WORDS, .low = DESCRIPTOR_INFORMATIVE
#define IS_STRUCT                                                                                            \
    {                                                                                                        \
        .name = "type", .form = SOURCE_WORD | SOURCE_NEEDED, .words = "STRUCT"                               \
    }
#define SETTABLE                                                                                             \
    {                                                                                                        \
        .name = "settable", .form = SOURCE_FLAG, SOURCE_TO(descriptor_parameter_t, is_settable)              \
    }
#define TYPE(type_of_item)                                                                                   \
    {                                                                                                        \
        .name = "type", .form = SOURCE_TYPE | SOURCE_NEEDED, SOURCE_TO(type_of_item, type)                   \
    }
#define COUNT                                                                                                \
    {                                                                                                        \
        .name = "count", .form = SOURCE_UNSIGNED, .low = 1U, .high = 256U, .otherwise = 1U,                  \
        SOURCE_TO(descriptor_field_t, count)                                                                 \
    }
#define UNIT                                                                                                 \
    {                                                                                                        \
        .name = "unit", .form = SOURCE_TEXT, .high = 16U, SOURCE_TO(descriptor_field_t, unit)                \
    }

static const source_attribute_t subsystem_attributes[] = {
    {.name = "name",
     .form = SOURCE_UPPER | SOURCE_NEEDED,
     .high = DESCRIPTOR_NAME_MAX,
     SOURCE_TO(subsystem_descriptor_t, name)},
    {.name = "id",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .low  = 1U,
     .high = 2046U,
     SOURCE_TO(subsystem_descriptor_t, apid)},
    {.name      = "samplingTime",
     .form      = SOURCE_TIME,
     .low       = 100U,
     .high      = 10000000U,
     .otherwise = 10000U,
     SOURCE_TO(subsystem_descriptor_t, sampling_us)},
};
static const source_attribute_t resources_attributes[] = {
    {.name      = "poolWarning",
     .form      = SOURCE_UNSIGNED,
     .low       = 1U,
     .high      = 100U,
     .otherwise = SUBSYSTEM_WARN_PERCENT,
     SOURCE_TO(subsystem_descriptor_t, pool_warn_percent)},
    {.name      = "poolClear",
     .form      = SOURCE_UNSIGNED,
     .high      = 99U,
     .otherwise = SUBSYSTEM_CLEAR_PERCENT,
     SOURCE_TO(subsystem_descriptor_t, pool_clear_percent)},
};
static const source_attribute_t state_attributes[] = {
    FREE_NEEDED("name"),
    {.name = "timeout", .form = SOURCE_TIME | SOURCE_NEEDED, .low = 1000U, .high = 600000000U},
};
static const source_attribute_t struct_attributes[] = {
    NAMED(descriptor_parameter_t),
    {.name = "id",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .high = 65535U,
     SOURCE_TO(descriptor_parameter_t, number)},
    IS_STRUCT,
    SETTABLE,
};
static const source_attribute_t group_attributes[] = {
    {.name = "name", .form = SOURCE_UPPER | SOURCE_NEEDED, .high = DESCRIPTOR_NAME_MAX},
    NUMBER_ID,
    IS_STRUCT,
};
static const source_attribute_t member_attributes[] = {
    {.name = "name",
     .form = SOURCE_UPPER | SOURCE_NEEDED,
     .high = DESCRIPTOR_NAME_MAX,
     SOURCE_TO(descriptor_field_t, name)},
    NUMBER_ID,
    TYPE(descriptor_field_t),
    COUNT,
    UNIT,
    FREE("init"),
    FREE("min"),
    FREE("max"),
};
static const source_attribute_t parameter_attributes[] = {
    NAMED(descriptor_parameter_t),
    {.name = "id",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .high = 65535U,
     SOURCE_TO(descriptor_parameter_t, number)},
    FREE_NEEDED("type"),
    FREE("count"),
    FREE("unit"),
    FREE("init"),
    FREE("min"),
    FREE("max"),
    SETTABLE,
};
const source_attribute_t descriptor_subsystem_field_attributes[SUBSYSTEM_FIELD_ATTRIBUTES] = {
    NAMED(descriptor_field_t), TYPE(descriptor_field_t), COUNT, UNIT};
static const source_attribute_t event_attributes[] = {
    NAMED(descriptor_event_t),
    NUMBERED(descriptor_event_t),
    {.name = "severity",
     .form = SOURCE_WORD | SOURCE_NEEDED,
     SEVERITIES,
     SOURCE_TO(descriptor_event_t, severity)},
    FREE("rate"),
    {.name      = "burst",
     .form      = SOURCE_UNSIGNED,
     .low       = 1U,
     .high      = 255U,
     .otherwise = 20U,
     SOURCE_TO(descriptor_event_t, burst)},
};
static const source_attribute_t event_value_attributes[] = {FREE_NEEDED("name"), FREE("type"), FREE("count"),
                                                            FREE("unit")};
static const source_attribute_t function_attributes[]    = {
       {.name = "name",
        .form = SOURCE_UPPER | SOURCE_NEEDED | SOURCE_UNIQUE,
        .high = DESCRIPTOR_FUNCTION_NAME_MAX,
        SOURCE_TO(descriptor_function_t, name)},
       NUMBERED(descriptor_function_t),
       FREE_NEEDED("states"),
       FREE("configurations"),
};
static const source_attribute_t argument_attributes[] = {
    NAMED(descriptor_field_t),
    {.name = "id",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED | SOURCE_UNIQUE,
     .high = 65535U,
     SOURCE_TO(descriptor_field_t, id)},
    TYPE(descriptor_field_t),
    COUNT,
    UNIT,
    FREE("min"),
    FREE("max"),
};
static const source_attribute_t service_attributes[]       = {FREE_NEEDED("type"), FREE("capacity"),
                                                              FREE("functional")};
static const source_attribute_t configuration_attributes[] = {
    NAMED(descriptor_configuration_t), NUMBERED(descriptor_configuration_t),
    PRIORITY(descriptor_configuration_t), SAMPLING(descriptor_configuration_t)};
static const source_attribute_t initial_attributes[] = {
    FREE_NEEDED("parameter"),
    FREE("field"),
    {.name = "value",
     .form = SOURCE_TEXT | SOURCE_NEEDED,
     .high = UINT32_MAX,
     SOURCE_TO(descriptor_initial_t, text)},
};
static const source_attribute_t loop_attributes[] = {NAMED(descriptor_loop_t), SAMPLING(descriptor_loop_t),
                                                     PRIORITY(descriptor_loop_t), FREE("services")};
static const source_attribute_t structure_attributes[] = {
    NUMBERED(descriptor_structure_t),
    {.name = "interval",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .low  = 1U,
     .high = UINT32_MAX,
     SOURCE_TO(descriptor_structure_t, interval_cycles)},
    {.name = "enabled", .form = SOURCE_FLAG, .otherwise = 1U, SOURCE_TO(descriptor_structure_t, is_enabled)},
    FREE("loop"),
};
static const source_attribute_t reference_attributes[] = {FREE_NEEDED("name")};
static const source_attribute_t sampled_attributes[]   = {
      {.name = "nrep",
       .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
       .low  = 2U,
       .high = 1000U,
       SOURCE_TO(descriptor_sampled_t, nrep)},
};
#define PROVIDES_ATTRIBUTES 3U
static const source_attribute_t port_attributes[] = {
    NAMED(descriptor_port_t),
    NUMBERED(descriptor_port_t),
    METHODS,
    {.name = "required", .form = SOURCE_FLAG, .otherwise = 1U, SOURCE_TO(descriptor_port_t, is_required)},
    {.name = "staleAfter",
     .form = SOURCE_TIME,
     .low  = 100U,
     .high = 60000000U,
     SOURCE_TO(descriptor_port_t, stale_us)},
};
static const source_attribute_t device_attributes[] = {
    NAMED(descriptor_device_t),
    {.name = "type",
     .form = SOURCE_LOWER | SOURCE_NEEDED,
     .high = DESCRIPTOR_NAME_MAX,
     SOURCE_TO(descriptor_device_t, type)},
};
static const source_attribute_t setting_attributes[]  = {FREE_NEEDED("object"), TYPE(descriptor_setting_t),
                                                         FREE_NEEDED("value")};
static const source_attribute_t quantity_attributes[] = {
    NAMED(descriptor_quantity_t),
    {.name = "id",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED | SOURCE_UNIQUE,
     .high = 65535U,
     SOURCE_TO(descriptor_quantity_t, id)},
    FREE_NEEDED("object"),
    TYPE(descriptor_quantity_t),
    FREE_NEEDED("scale"),
    {.name = "unit", .form = SOURCE_TEXT, .high = 16U, SOURCE_TO(descriptor_quantity_t, unit)},
    {.name = "settable", .form = SOURCE_FLAG, SOURCE_TO(descriptor_quantity_t, is_settable)},
};
static const source_attribute_t supply_attributes[] = {
    {.name = "unit",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .low  = 1U,
     .high = 127U,
     SOURCE_TO(descriptor_supply_t, unit)},
    {.name = "on",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .low  = 1U,
     .high = 255U,
     SOURCE_TO(descriptor_supply_t, on)},
    {.name = "off",
     .form = SOURCE_UNSIGNED | SOURCE_NEEDED,
     .low  = 1U,
     .high = 255U,
     SOURCE_TO(descriptor_supply_t, off)},
};
// The order of `type` and of the others is known to endnode_builder.c.
static const source_attribute_t endnode_attributes[] = {
    {.name  = "type",
     .form  = SOURCE_WORD | SOURCE_NEEDED,
     .words = "CAN SHM MQUEUE UDP TCP SERIAL FILE",
     SOURCE_TO(descriptor_endnode_t, type)},
    {.name = "bus", .form = SOURCE_LOWER, .high = DESCRIPTOR_NAME_MAX, SOURCE_TO(descriptor_endnode_t, bus)},
    {.name = "redundantBus",
     .form = SOURCE_LOWER,
     .high = DESCRIPTOR_NAME_MAX,
     SOURCE_TO(descriptor_endnode_t, redundant_bus)},
    {.name = "node", .form = SOURCE_UNSIGNED, .low = 1U, .high = 127U, SOURCE_TO(descriptor_endnode_t, node)},
    {.name = "name", .form = SOURCE_TEXT, .high = 255U, SOURCE_TO(descriptor_endnode_t, name)},
    {.name = "address", .form = SOURCE_TEXT, .high = 255U, SOURCE_TO(descriptor_endnode_t, address)},
    {.name = "port",
     .form = SOURCE_UNSIGNED,
     .low  = 1U,
     .high = 65535U,
     SOURCE_TO(descriptor_endnode_t, port)},
    {.name  = "framing",
     .form  = SOURCE_WORD,
     .words = "RAW LENGTH SLIP LINE",
     SOURCE_TO(descriptor_endnode_t, format.framing)},
    {.name  = "order",
     .form  = SOURCE_WORD,
     .words = "BIG LITTLE",
     SOURCE_TO(descriptor_endnode_t, format.order)},
    {.name  = "direction",
     .form  = SOURCE_WORD,
     .words = "BOTH READ WRITE",
     SOURCE_TO(descriptor_endnode_t, format.direction)},
    {.name      = "baud",
     .form      = SOURCE_WORD,
     .words     = "9600 19200 38400 57600 115200 230400 460800 921600",
     .otherwise = 4U,
     SOURCE_TO(descriptor_endnode_t, format.baud)},
};

// ---- Elements ----

#define WITH(name, attributes) SOURCE_COUNT(attributes), (name), (attributes)
#define PLAIN(name) 0U, (name), NULL

// Parent, kind, how often, name with attributes, list, start, end.
static const source_row_t rows[] = {
    {SOURCE_ROOT, KIND_SUBSYSTEM, SOURCE_ANY, WITH("Subsystem", subsystem_attributes), NULL, NULL,
     descriptor_subsystem_builder_end},
    {KIND_SUBSYSTEM, KIND_RESOURCES, SOURCE_ONCE, WITH("Resources", resources_attributes), NULL,
     descriptor_subsystem_builder_resources, NULL},
    {KIND_SUBSYSTEM, KIND_STATES, SOURCE_ONCE, PLAIN("States"), NULL, NULL, NULL},
    {KIND_STATES, KIND_STATE, SOURCE_ANY, WITH("State", state_attributes), NULL,
     descriptor_subsystem_builder_state, NULL},
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
    {KIND_DEVICE, KIND_ENDNODE, SOURCE_ANY, WITH("Endnode", endnode_attributes), &endnodes,
     descriptor_endnode_builder_start, NULL},
};

void descriptor_subsystem_builder_begin(subsystem_builder_t* const builder,
                                        subsystem_descriptor_t* const descriptor, const char* const path,
                                        text_t* const error)
{
    (void)memset(descriptor, 0, sizeof *descriptor);
    (void)memset(builder, 0, sizeof *builder);
    descriptor->name               = "";
    descriptor->pool_warn_percent  = SUBSYSTEM_WARN_PERCENT;
    descriptor->pool_clear_percent = SUBSYSTEM_CLEAR_PERCENT;
    builder->source.path           = path;
    builder->source.error          = error;
    builder->source.rows           = rows;
    builder->source.row_count      = SOURCE_COUNT(rows);
    builder->source.items[0]       = descriptor;
    builder->source.text           = descriptor->text;
    builder->source.text_capacity  = DESCRIPTOR_TEXT_OCTETS;
    builder->source.text_used      = &descriptor->text_used;
    builder->source.builder        = builder;
}
