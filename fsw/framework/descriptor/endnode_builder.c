// SPDX-License-Identifier: Apache-2.0
// End nodes of a device: address and octet format of a data flow, fields of its records.
#include "fsw/framework/descriptor/subsystem_builder.h"

// Attributes as bits, in the order of the table of elements: bus, redundantBus, node, name, address, port,
// framing, order, direction, baud, checksum, silence, retry, retryLongest.
#define BUS 0x005U // bus and node
#define REDUNDANT_BUS 0x002U
#define NAME 0x008U
#define PORT 0x030U // address and port
#define FRAMING 0x040U
#define ORDER 0x080U
#define DIRECTION 0x100U
#define BAUD 0x200U
#define STREAM 0x3C00U // checksum to retryLongest
#define ATTRIBUTES 14U

typedef struct { // Attributes that an end node of one type must have, and may have; others are refused.
    uint16_t needed;
    uint16_t allowed;
} endnode_rule_t;

static const endnode_rule_t rules[] = {
    [DESCRIPTOR_ENDNODE_CAN]    = {BUS, REDUNDANT_BUS},
    [DESCRIPTOR_ENDNODE_SHM]    = {NAME, ORDER | STREAM},
    [DESCRIPTOR_ENDNODE_MQUEUE] = {NAME, ORDER | STREAM},
    [DESCRIPTOR_ENDNODE_UDP]    = {PORT, ORDER | STREAM},
    [DESCRIPTOR_ENDNODE_TCP]    = {PORT, FRAMING | ORDER | STREAM},
    [DESCRIPTOR_ENDNODE_SERIAL] = {NAME, FRAMING | ORDER | BAUD | STREAM},
    [DESCRIPTOR_ENDNODE_FILE]   = {NAME, FRAMING | ORDER | DIRECTION | STREAM},
};

/// Read an end node. Defaults of its format: raw, most significant octet first, both directions, 115200
/// bit/s.
void descriptor_endnode_builder_start(source_t* const source)
{
    static const uint32_t bit_rates[] = {9600U, 19200U, 38400U, 57600U, 115200U, 230400U, 460800U, 921600U};
    const source_attribute_t* const attributes = source->open[source->depth - 1U]->attributes;
    descriptor_endnode_t* const endnode        = source->item;
    const endnode_rule_t* const rule           = &rules[endnode->type];
    for (uint32_t i = 0U; i < ATTRIBUTES; i++) {
        const char* const name = attributes[i + 1U].name; // The attribute `type` is the first one.
        const bool is_needed   = ((rule->needed >> i) & 1U) != 0U;
        const bool is_allowed  = (((uint32_t)rule->allowed >> i) & 1U) != 0U;
        const bool is_there    = descriptor_source_has(source, name);
        if ((is_there != is_needed) && !(is_there && is_allowed)) {
            descriptor_source_refuse(source, source->line,
                                     is_needed ? "<Endnode> of type % needs attribute %"
                                               : "<Endnode> of type % cannot have attribute %",
                                     descriptor_source_raw(source, "type"), name, 0U);
        }
    }
    if (endnode->retry_us > endnode->longest_us) {
        descriptor_source_refuse(source, source->line,
                                 "<Endnode>: expected a retryLongest of at least retry, # us", NULL, NULL,
                                 endnode->retry_us);
    }
    endnode->format.baud = ((rule->allowed & BAUD) != 0U) ? bit_rates[endnode->format.baud] : 0U;
}

static double real_of(source_t* const source, const char* const attribute, const double otherwise)
{
    double real = otherwise;
    if (descriptor_source_has(source, attribute)) {
        (void)descriptor_source_number(source, attribute, VALUE_DOUBLE, &real);
    }
    return real;
}

void descriptor_endnode_builder_field(source_t* const source)
{
    descriptor_record_field_t* const field = source->item;
    field->scale                           = real_of(source, "scale", 1.0);
    field->offset                          = real_of(source, "offset", 0.0);
    field->safe                            = real_of(source, "safe", 0.0);
    if (field->scale == 0.0) {
        descriptor_source_wrong(source, "scale", "a number other than 0");
    }
    if (!field->is_out && descriptor_source_has(source, "safe")) {
        descriptor_source_refuse(source, source->line, "<Field> of direction IN cannot have attribute %",
                                 "safe", NULL, 0U);
    }
    if (field->type == VALUE_BOOL) {
        descriptor_source_wrong(source, "type", "an integer type, FLOAT or DOUBLE");
    }
}
