// SPDX-License-Identifier: Apache-2.0
// End nodes of a device: where a data flow goes, and how octets travel on it.
#include "fsw/framework/descriptor/subsystem_builder.h"

static subsystem_descriptor_t* model(source_t* const source)
{
    return subsystem_builder_of(source)->descriptor;
}

typedef struct { // Attributes that an endnode of a type must have, and those it may have; it has no others.
    const char* name;
    bool has_bus;
    bool has_name;
    bool has_port;
    bool may_have_framing;
    bool may_have_order;
    bool may_have_direction;
    bool may_have_baud;
} endnode_rule_t;

static const endnode_rule_t endnode_rules[] = {
    [DESCRIPTOR_ENDNODE_CAN]    = {"CAN", true, false, false, false, false, false, false},
    [DESCRIPTOR_ENDNODE_SHM]    = {"SHM", false, true, false, false, true, false, false},
    [DESCRIPTOR_ENDNODE_MQUEUE] = {"MQUEUE", false, true, false, false, true, false, false},
    [DESCRIPTOR_ENDNODE_UDP]    = {"UDP", false, false, true, false, true, false, false},
    [DESCRIPTOR_ENDNODE_TCP]    = {"TCP", false, false, true, true, true, false, false},
    [DESCRIPTOR_ENDNODE_SERIAL] = {"SERIAL", false, true, false, true, true, false, true},
    [DESCRIPTOR_ENDNODE_FILE]   = {"FILE", false, true, false, true, true, true, false},
};
#define ENDNODE_TYPES (sizeof endnode_rules / sizeof endnode_rules[0])

static void check_endnode_attribute(source_t* const source, const char* const attribute, const bool is_needed)
{
    if ((source_has(source, attribute) != is_needed) &&
        source_fail(source, source->line, STATUS_INVALID, "<Endnode> of type ")) {
        text_add(source->error, source_raw(source, "type"));
        text_add(source->error, is_needed ? " needs attribute " : " has no attribute ");
        text_add(source->error, attribute);
    }
}

static void check_optional_attribute(source_t* const source, const char* const attribute,
                                     const bool is_allowed)
{
    if (source_has(source, attribute)) {
        check_endnode_attribute(source, attribute, is_allowed);
    }
}

/// How octets travel; what is not said is raw, most significant octet first, both ways, 115200 bit/s.
static flow_format_t read_format(source_t* const source, const endnode_rule_t* const rule)
{
    static const char* const framings[FLOW_FRAMINGS]     = {"RAW", "LENGTH", "SLIP", "LINE"};
    static const char* const orders[FLOW_ORDERS]         = {"BIG", "LITTLE"};
    static const char* const directions[FLOW_DIRECTIONS] = {"BOTH", "READ", "WRITE"};
    static const char* const bauds[]                     = {"9600",   "19200",  "38400",  "57600",
                                                            "115200", "230400", "460800", "921600"};
    static const uint32_t bit_rates[] = {9600U, 19200U, 38400U, 57600U, 115200U, 230400U, 460800U, 921600U};
    check_optional_attribute(source, "framing", rule->may_have_framing);
    check_optional_attribute(source, "order", rule->may_have_order);
    check_optional_attribute(source, "direction", rule->may_have_direction);
    check_optional_attribute(source, "baud", rule->may_have_baud);
    const uint32_t baud = source_word(source, "baud", bauds, sizeof bauds / sizeof bauds[0], 4U);
    return (flow_format_t){
        .framing   = (flow_framing_t)source_word(source, "framing", framings, FLOW_FRAMINGS, 0U),
        .order     = (flow_order_t)source_word(source, "order", orders, FLOW_ORDERS, 0U),
        .direction = (flow_direction_t)source_word(source, "direction", directions, FLOW_DIRECTIONS, 0U),
        .baud      = rule->may_have_baud ? bit_rates[baud] : 0U};
}

void endnode_builder_start(source_t* const source)
{
    subsystem_descriptor_t* const descriptor = model(source);
    const char* names[ENDNODE_TYPES];
    for (size_t i = 0U; i < ENDNODE_TYPES; i++) {
        names[i] = endnode_rules[i].name;
    }
    const uint32_t type              = source_word(source, "type", names, ENDNODE_TYPES, 0U);
    const endnode_rule_t* const rule = &endnode_rules[type];
    check_endnode_attribute(source, "bus", rule->has_bus);
    check_endnode_attribute(source, "node", rule->has_bus);
    check_endnode_attribute(source, "name", rule->has_name);
    check_endnode_attribute(source, "address", rule->has_port);
    check_endnode_attribute(source, "port", rule->has_port);
    const flow_format_t format = read_format(source, rule);
    if (!source_has_room(source, descriptor->endnode_count, DESCRIPTOR_ENDNODES_MAX, "<Endnode>")) {
        return;
    }
    descriptor->endnodes[descriptor->endnode_count] =
        (descriptor_endnode_t){.type    = (descriptor_endnode_type_t)type,
                               .bus     = rule->has_bus ? source_lower_identifier(source, "bus") : "",
                               .node    = (uint8_t)source_unsigned(source, "node", 1U, 127U, 0U),
                               .name    = source_text(source, "name", 255U),
                               .address = source_text(source, "address", 255U),
                               .port    = (uint16_t)source_unsigned(source, "port", 1U, 65535U, 0U),
                               .format  = format,
                               .line    = source->line};
    descriptor->endnode_count++;
    descriptor->devices[descriptor->device_count - 1U].endnode_count++;
}
