// SPDX-License-Identifier: Apache-2.0
#include "launcher/descriptor_members.h"

#include "fsw/framework/descriptor/mission_descriptor.h"

#define WIDTH(type, member) ((uint8_t)sizeof(((const type*)NULL)->member))
#define MEMBER(type, member, kind)                                                                           \
    {                                                                                                        \
#member, offsetof(type, member), WIDTH(type, member), 0U, (kind)                                     \
    }
#define NUMBER(type, member) MEMBER(type, member, DESCRIPTOR_MEMBER_NUMBER)
#define REAL(type, member) MEMBER(type, member, DESCRIPTOR_MEMBER_REAL)
#define TEXT(type, member) MEMBER(type, member, DESCRIPTOR_MEMBER_TEXT)
#define NAMES(type, member)                                                                                  \
    {                                                                                                        \
#member, offsetof(type, member), (uint8_t)sizeof(void*), 0U, DESCRIPTOR_MEMBER_NAMES                 \
    }
#define ITEM_WIDTH(type, member) ((uint8_t)sizeof *((const type*)NULL)->member)
#define NUMBERS(type, member)                                                                                \
    {                                                                                                        \
#member, offsetof(type, member), ITEM_WIDTH(type, member),                                           \
            (uint8_t)(sizeof(((const type*)NULL)->member) / ITEM_WIDTH(type, member)),                       \
            DESCRIPTOR_MEMBER_NUMBER                                                                         \
    }
#define LIST(model, type, list, number)                                                                      \
    {                                                                                                        \
#type, #list, list, sizeof(list) / sizeof((list)[0]), sizeof(type), offsetof(model, list),           \
            offsetof(model, number)                                                                          \
    }

static const descriptor_member_t enumerations[] = {
    TEXT(descriptor_enumeration_t, name),
    NUMBER(descriptor_enumeration_t, first),
    NUMBER(descriptor_enumeration_t, line),
    TEXT(descriptor_enumeration_t, values),
};
static const descriptor_member_t failures[] = {
    TEXT(descriptor_failure_t, name),
    NUMBER(descriptor_failure_t, id),
    NUMBER(descriptor_failure_t, line),
};
static const descriptor_member_t fields[] = {
    TEXT(descriptor_field_t, name),         NUMBER(descriptor_field_t, type),
    NUMBER(descriptor_field_t, id),         NUMBER(descriptor_field_t, count),
    NUMBER(descriptor_field_t, offset),     NUMBER(descriptor_field_t, line),
    TEXT(descriptor_field_t, unit),         TEXT(descriptor_field_t, init),
    REAL(descriptor_field_t, min),          REAL(descriptor_field_t, max),
    NAMES(descriptor_field_t, enumeration),
};
static const descriptor_member_t parameters[] = {
    TEXT(descriptor_parameter_t, name),          NUMBER(descriptor_parameter_t, id),
    NUMBER(descriptor_parameter_t, number),      NUMBER(descriptor_parameter_t, first_field),
    NUMBER(descriptor_parameter_t, field_count), NUMBER(descriptor_parameter_t, wire_size),
    NUMBER(descriptor_parameter_t, memory_size), NUMBER(descriptor_parameter_t, is_struct),
    NUMBER(descriptor_parameter_t, is_settable), NUMBER(descriptor_parameter_t, line),
};
static const descriptor_member_t events[] = {
    TEXT(descriptor_event_t, name),
    NUMBER(descriptor_event_t, id),
    NUMBER(descriptor_event_t, severity),
    NUMBER(descriptor_event_t, per_second),
    NUMBER(descriptor_event_t, burst),
    NUMBER(descriptor_event_t, first_field),
    NUMBER(descriptor_event_t, field_count),
    NUMBER(descriptor_event_t, first_reference),
    NUMBER(descriptor_event_t, reference_count),
    NUMBER(descriptor_event_t, octets),
    NUMBER(descriptor_event_t, line),
};
static const descriptor_member_t functions[] = {
    TEXT(descriptor_function_t, name),
    NUMBER(descriptor_function_t, id),
    NUMBER(descriptor_function_t, first_argument),
    NUMBER(descriptor_function_t, argument_count),
    NUMBER(descriptor_function_t, memory_size),
    NUMBER(descriptor_function_t, states),
    NUMBER(descriptor_function_t, configurations),
    NUMBER(descriptor_function_t, line),
};
static const descriptor_member_t services[] = {
    NUMBER(descriptor_service_t, type),       NUMBER(descriptor_service_t, capacity),
    NUMBER(descriptor_service_t, functional), NUMBER(descriptor_service_t, is_of_spacecraft),
    NUMBER(descriptor_service_t, line),
};
static const descriptor_member_t configurations[] = {
    TEXT(descriptor_configuration_t, name),
    NUMBER(descriptor_configuration_t, id),
    NUMBER(descriptor_configuration_t, priority),
    NUMBER(descriptor_configuration_t, sampling_us),
    NUMBER(descriptor_configuration_t, first_initial),
    NUMBER(descriptor_configuration_t, initial_count),
    NUMBER(descriptor_configuration_t, first_loop),
    NUMBER(descriptor_configuration_t, loop_count),
    NUMBER(descriptor_configuration_t, first_structure),
    NUMBER(descriptor_configuration_t, structure_count),
    NUMBER(descriptor_configuration_t, first_port),
    NUMBER(descriptor_configuration_t, port_count),
    NUMBER(descriptor_configuration_t, first_device),
    NUMBER(descriptor_configuration_t, device_count),
    NUMBER(descriptor_configuration_t, line),
};
static const descriptor_member_t initials[] = {
    NUMBER(descriptor_initial_t, parameter),
    NUMBER(descriptor_initial_t, field),
    TEXT(descriptor_initial_t, text),
    NUMBER(descriptor_initial_t, line),
};
static const descriptor_member_t loops[] = {
    TEXT(descriptor_loop_t, name),       NUMBER(descriptor_loop_t, sampling_us),
    NUMBER(descriptor_loop_t, priority), NUMBER(descriptor_loop_t, services),
    NUMBER(descriptor_loop_t, line),
};
static const descriptor_member_t structures[] = {
    NUMBER(descriptor_structure_t, id),
    NUMBER(descriptor_structure_t, loop),
    NUMBER(descriptor_structure_t, interval_cycles),
    NUMBER(descriptor_structure_t, is_enabled),
    NUMBER(descriptor_structure_t, first_reference),
    NUMBER(descriptor_structure_t, reference_count),
    NUMBER(descriptor_structure_t, first_sampled),
    NUMBER(descriptor_structure_t, sampled_count),
    NUMBER(descriptor_structure_t, octets),
    NUMBER(descriptor_structure_t, line),
};
static const descriptor_member_t sampled[] = {
    NUMBER(descriptor_sampled_t, nrep),
    NUMBER(descriptor_sampled_t, first_reference),
    NUMBER(descriptor_sampled_t, reference_count),
};
static const descriptor_member_t ports[] = {
    TEXT(descriptor_port_t, name),           NUMBER(descriptor_port_t, id),
    NUMBER(descriptor_port_t, is_provided),  NUMBER(descriptor_port_t, is_required),
    NUMBER(descriptor_port_t, first_field),  NUMBER(descriptor_port_t, field_count),
    NUMBER(descriptor_port_t, layout_hash),  NUMBER(descriptor_port_t, octets),
    NUMBER(descriptor_port_t, memory_size),  NUMBER(descriptor_port_t, period_us),
    NUMBER(descriptor_port_t, stale_us),     NUMBERS(descriptor_port_t, methods),
    NUMBER(descriptor_port_t, method_count), NUMBER(descriptor_port_t, line),
};
static const descriptor_member_t devices[] = {
    TEXT(descriptor_device_t, name),
    TEXT(descriptor_device_t, type),
    NUMBER(descriptor_device_t, first_setting),
    NUMBER(descriptor_device_t, setting_count),
    NUMBER(descriptor_device_t, first_quantity),
    NUMBER(descriptor_device_t, quantity_count),
    NUMBER(descriptor_device_t, first_supply),
    NUMBER(descriptor_device_t, supply_count),
    NUMBER(descriptor_device_t, first_record_field),
    NUMBER(descriptor_device_t, record_field_count),
    NUMBER(descriptor_device_t, first_endnode),
    NUMBER(descriptor_device_t, endnode_count),
    NUMBER(descriptor_device_t, line),
};
static const descriptor_member_t settings[] = {
    NUMBER(descriptor_setting_t, index), NUMBER(descriptor_setting_t, subindex),
    NUMBER(descriptor_setting_t, type),  NUMBER(descriptor_setting_t, bits),
    NUMBER(descriptor_setting_t, line),
};
static const descriptor_member_t quantities[] = {
    TEXT(descriptor_quantity_t, name),       TEXT(descriptor_quantity_t, unit),
    NUMBER(descriptor_quantity_t, id),       NUMBER(descriptor_quantity_t, index),
    NUMBER(descriptor_quantity_t, subindex), NUMBER(descriptor_quantity_t, type),
    REAL(descriptor_quantity_t, scale),      NUMBER(descriptor_quantity_t, is_settable),
    NUMBER(descriptor_quantity_t, line),
};
static const descriptor_member_t supplies[] = {
    NUMBER(descriptor_supply_t, unit),
    NUMBER(descriptor_supply_t, on),
    NUMBER(descriptor_supply_t, off),
    NUMBER(descriptor_supply_t, line),
};
static const descriptor_member_t record_fields[] = {
    TEXT(descriptor_record_field_t, name),     TEXT(descriptor_record_field_t, unit),
    NUMBER(descriptor_record_field_t, is_out), NUMBER(descriptor_record_field_t, type),
    REAL(descriptor_record_field_t, scale),    REAL(descriptor_record_field_t, offset),
    REAL(descriptor_record_field_t, safe),     NUMBER(descriptor_record_field_t, line),
};
static const descriptor_member_t endnodes[] = {
    NUMBER(descriptor_endnode_t, type),         TEXT(descriptor_endnode_t, bus),
    TEXT(descriptor_endnode_t, redundant_bus),  NUMBER(descriptor_endnode_t, node),
    TEXT(descriptor_endnode_t, name),           TEXT(descriptor_endnode_t, address),
    NUMBER(descriptor_endnode_t, port),         NUMBER(descriptor_endnode_t, format.framing),
    NUMBER(descriptor_endnode_t, format.order), NUMBER(descriptor_endnode_t, format.direction),
    NUMBER(descriptor_endnode_t, format.baud),  NUMBER(descriptor_endnode_t, has_checksum),
    NUMBER(descriptor_endnode_t, silence_us),   NUMBER(descriptor_endnode_t, retry_us),
    NUMBER(descriptor_endnode_t, longest_us),   NUMBER(descriptor_endnode_t, line),
};
static const descriptor_member_t subsystem_members[] = {
    TEXT(subsystem_descriptor_t, name),
    NUMBER(subsystem_descriptor_t, apid),
    NUMBER(subsystem_descriptor_t, interface_hash),
    NUMBER(subsystem_descriptor_t, configuration_hash),
    NUMBER(subsystem_descriptor_t, pool_warn_percent),
    NUMBER(subsystem_descriptor_t, pool_clear_percent),
    NUMBER(subsystem_descriptor_t, is_sync_first),
    NUMBERS(subsystem_descriptor_t, timeout_us),
    NUMBER(subsystem_descriptor_t, sampling_us),
    NUMBER(subsystem_descriptor_t, enumeration_count),
    NUMBER(subsystem_descriptor_t, failure_count),
    NUMBER(subsystem_descriptor_t, field_count),
    NUMBER(subsystem_descriptor_t, parameter_count),
    NUMBER(subsystem_descriptor_t, event_count),
    NUMBER(subsystem_descriptor_t, function_count),
    NUMBER(subsystem_descriptor_t, service_count),
    NUMBER(subsystem_descriptor_t, configuration_count),
    NUMBER(subsystem_descriptor_t, initial_count),
    NUMBER(subsystem_descriptor_t, reference_count),
    NUMBER(subsystem_descriptor_t, loop_count),
    NUMBER(subsystem_descriptor_t, structure_count),
    NUMBER(subsystem_descriptor_t, sampled_count),
    NUMBER(subsystem_descriptor_t, port_count),
    NUMBER(subsystem_descriptor_t, device_count),
    NUMBER(subsystem_descriptor_t, setting_count),
    NUMBER(subsystem_descriptor_t, quantity_count),
    NUMBER(subsystem_descriptor_t, supply_count),
    NUMBER(subsystem_descriptor_t, record_field_count),
    NUMBER(subsystem_descriptor_t, endnode_count),
};
static const descriptor_list_t subsystem_lists[] = {
    LIST(subsystem_descriptor_t, descriptor_enumeration_t, enumerations, enumeration_count),
    LIST(subsystem_descriptor_t, descriptor_failure_t, failures, failure_count),
    LIST(subsystem_descriptor_t, descriptor_field_t, fields, field_count),
    LIST(subsystem_descriptor_t, descriptor_parameter_t, parameters, parameter_count),
    LIST(subsystem_descriptor_t, descriptor_event_t, events, event_count),
    LIST(subsystem_descriptor_t, descriptor_function_t, functions, function_count),
    LIST(subsystem_descriptor_t, descriptor_service_t, services, service_count),
    LIST(subsystem_descriptor_t, descriptor_configuration_t, configurations, configuration_count),
    LIST(subsystem_descriptor_t, descriptor_initial_t, initials, initial_count),
    {"uint16_t", "references", NULL, 0U, sizeof(uint16_t), offsetof(subsystem_descriptor_t, references),
     offsetof(subsystem_descriptor_t, reference_count)},
    LIST(subsystem_descriptor_t, descriptor_loop_t, loops, loop_count),
    LIST(subsystem_descriptor_t, descriptor_structure_t, structures, structure_count),
    LIST(subsystem_descriptor_t, descriptor_sampled_t, sampled, sampled_count),
    LIST(subsystem_descriptor_t, descriptor_port_t, ports, port_count),
    LIST(subsystem_descriptor_t, descriptor_device_t, devices, device_count),
    LIST(subsystem_descriptor_t, descriptor_setting_t, settings, setting_count),
    LIST(subsystem_descriptor_t, descriptor_quantity_t, quantities, quantity_count),
    LIST(subsystem_descriptor_t, descriptor_supply_t, supplies, supply_count),
    LIST(subsystem_descriptor_t, descriptor_record_field_t, record_fields, record_field_count),
    LIST(subsystem_descriptor_t, descriptor_endnode_t, endnodes, endnode_count),
};

// A subsystem needs only these members of the model of a mission.
static const descriptor_member_t subsystems[] = {
    TEXT(mission_subsystem_t, name),
    NUMBER(mission_subsystem_t, apid),
    TEXT(mission_subsystem_t, executable),
    TEXT(mission_subsystem_t, descriptor),
    NUMBER(mission_subsystem_t, is_autostart),
    NUMBER(mission_subsystem_t, memory_kib),
    NUMBER(mission_subsystem_t, restart_budget),
    NUMBER(mission_subsystem_t, restart_period_us),
    NUMBER(mission_subsystem_t, is_recommissioned),
    NUMBER(mission_subsystem_t, boot_time_us),
    NUMBER(mission_subsystem_t, device_deadline_us),
    NUMBER(mission_subsystem_t, hang_after_us),
    NUMBER(mission_subsystem_t, supervisor_timeout_us),
    NUMBER(mission_subsystem_t, computer),
    NUMBERS(mission_subsystem_t, power_w),
    NUMBER(mission_subsystem_t, interface_hash),
    NUMBER(mission_subsystem_t, configuration_hash),
    NUMBER(mission_subsystem_t, line),
};
static const descriptor_member_t links[] = {
    TEXT(mission_link_t, name),
    NUMBER(mission_link_t, number),
    NUMBER(mission_link_t, producer_apid),
    NUMBER(mission_link_t, producer_port),
    NUMBER(mission_link_t, consumer_apid),
    NUMBER(mission_link_t, consumer_port),
    NUMBER(mission_link_t, is_required),
    NUMBER(mission_link_t, line),
};
static const descriptor_member_t buses[] = {
    TEXT(mission_bus_t, name),       TEXT(mission_bus_t, redundant_to),
    NUMBER(mission_bus_t, bit_rate), NUMBER(mission_bus_t, data_bit_rate),
    NUMBER(mission_bus_t, line),
};
static const descriptor_member_t mission_members[] = {
    TEXT(mission_descriptor_t, name),
    NUMBER(mission_descriptor_t, epoch_s),
    NUMBER(mission_descriptor_t, interface_hash),
    NUMBER(mission_descriptor_t, configuration_hash),
    NUMBER(mission_descriptor_t, power_available_w),
    NUMBER(mission_descriptor_t, initial_mode),
    NUMBER(mission_descriptor_t, fallback_mode),
    NUMBER(mission_descriptor_t, time_reports),
    NUMBER(mission_descriptor_t, log_strategy),
    NUMBER(mission_descriptor_t, log_ring_records),
    NUMBER(mission_descriptor_t, message_method),
    NUMBER(mission_descriptor_t, link_method),
    NUMBER(mission_descriptor_t, ground_port),
    NUMBER(mission_descriptor_t, is_ground_open),
    TEXT(mission_descriptor_t, ground_key),
    NUMBER(mission_descriptor_t, subsystem_count),
    NUMBER(mission_descriptor_t, link_count),
    NUMBER(mission_descriptor_t, bus_count),
};
static const descriptor_list_t mission_lists[] = {
    LIST(mission_descriptor_t, mission_subsystem_t, subsystems, subsystem_count),
    LIST(mission_descriptor_t, mission_link_t, links, link_count),
    LIST(mission_descriptor_t, mission_bus_t, buses, bus_count),
};

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

const descriptor_model_t descriptor_model_of_subsystem = {"subsystem_descriptor_t", subsystem_lists,
                                                          COUNT(subsystem_lists), subsystem_members,
                                                          COUNT(subsystem_members)};
const descriptor_model_t descriptor_model_of_mission   = {"const mission_descriptor_t", mission_lists,
                                                          COUNT(mission_lists), mission_members,
                                                          COUNT(mission_members)};
