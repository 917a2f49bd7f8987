// SPDX-License-Identifier: Apache-2.0
#include "pus/st08/st08_functions.h"

#include "base/assertion.h"

#include <string.h>

#define PERFORM 1U
#define COUNT_OFFSET PUS_NAME_SIZE // Offset of the argument count in the application data.

static size_t size_of(const pus_argument_t* const argument)
{
    return value_size(argument->type) * argument->count;
}

void pus_functions_init(pus_functions_t* const functions, const pus_function_t* const table,
                        const uint16_t count, const pus_function_port_t* const port, uint64_t* const area,
                        const size_t area_size)
{
    FSW_ASSERT((functions != NULL) && ((table != NULL) || (count == 0U)) && (port != NULL) &&
               (port->perform != NULL) && ((area != NULL) || (area_size == 0U)));
    for (uint16_t i = 0U; i < count; i++) {
        FSW_ASSERT(table[i].argument_count <= PUS_ARGUMENTS_MAX);
        for (uint8_t k = 0U; k < table[i].argument_count; k++) {
            const pus_argument_t* const argument = &table[i].arguments[k];
            FSW_ASSERT((argument->count >= 1U) && ((argument->offset % value_size(argument->type)) == 0U) &&
                       ((argument->offset + size_of(argument)) <= area_size));
        }
    }
    *functions = (pus_functions_t){
        .functions = table, .count = count, .port = *port, .area = (uint8_t*)area, .area_size = area_size};
}

/// Returns the index of the function with this name, or `count` if there is none or the name is null.
static uint16_t function_of(const pus_functions_t* const functions, const uint8_t* const name)
{
    uint16_t index = 0U;
    while ((index < functions->count) &&
           ((name == NULL) || (memcmp(functions->functions[index].name, name, PUS_NAME_SIZE) != 0))) {
        index++; // It is sufficient to compare the octets, because both names are padded with NUL.
    }
    return index;
}

/// Returns the index of an argument of a function, or the argument count if the function has no such
/// argument.
static uint8_t argument_of(const pus_function_t* const function, const uint16_t id)
{
    uint8_t index = 0U;
    while ((index < function->argument_count) && (function->arguments[index].id != id)) {
        index++;
    }
    return index;
}

static bool has_format(void* const self, octet_reader_t* const reader)
{
    const pus_functions_t* const functions = self;
    const uint16_t index                   = function_of(functions, octet_read_octets(reader, PUS_NAME_SIZE));
    const uint8_t count                    = octet_read_u8(reader);
    if (index >= functions->count) {
        // The end of an unknown function's arguments cannot be found. The format is accepted, and `execute`
        // refuses the function.
        (void)octet_read_octets(reader, octet_reader_left(reader));
        return true;
    }
    const pus_function_t* const function = &functions->functions[index];
    if (count != function->argument_count) {
        reader->position = COUNT_OFFSET;
        return false;
    }
    for (uint8_t i = 0U; (i < count) && !reader->failed; i++) {
        const uint8_t argument = argument_of(function, octet_read_u16(reader));
        if (!reader->failed && (argument >= function->argument_count)) {
            // The length of its value is unknown, so the end of the arguments cannot be found.
            (void)octet_read_octets(reader, octet_reader_left(reader));
            return true;
        }
        (void)octet_read_octets(reader, reader->failed ? 0U : size_of(&function->arguments[argument]));
    }
    return true;
}

/// True if an IEEE 754 value in wire order is neither infinite nor not-a-number.
static bool is_finite(const value_type_t type, const uint8_t* const octets)
{
    const unsigned high = octets[0] & 0x7FU;
    if (type == VALUE_FLOAT) {
        return (high != 0x7FU) || ((octets[1] & 0x80U) == 0U);
    }
    return (type != VALUE_DOUBLE) || (high != 0x7FU) || ((octets[1] & 0xF0U) != 0xF0U);
}

/// Decode all elements of one argument to the area. False: a value is not possible for its type, or is not
/// finite.
static bool decode_argument(const pus_functions_t* const functions, const pus_argument_t* const argument,
                            octet_reader_t* const reader)
{
    const size_t size = value_size(argument->type);
    for (uint16_t i = 0U; i < argument->count; i++) {
        // The dispatcher has checked the format.
        const uint8_t* const octets = &reader->octets[reader->position];
        uint8_t* const memory       = &functions->area[argument->offset + (i * size)];
        if (!is_finite(argument->type, octets) ||
            (value_decode(reader, argument->type, memory) != STATUS_OK)) {
            return false;
        }
    }
    return true;
}

/// Decode all arguments. False: they are refused for the reason *out_reply.
static bool decode(const pus_functions_t* const functions, const pus_function_t* const function,
                   octet_reader_t* const reader, pus_reply_t* const out_reply)
{
    uint32_t seen       = 0U; // One bit for each argument.
    const uint8_t count = octet_read_u8(reader);
    (void)memset(functions->area, 0, functions->area_size);
    for (uint8_t i = 0U; i < count; i++) {
        const uint16_t id              = octet_read_u16(reader);
        const uint8_t argument         = argument_of(function, id);
        const uint32_t offset          = (uint32_t)reader->position;
        *out_reply                     = pus_refused(PUS_FAILURE_UNKNOWN_ID, id);
        out_reply->failure.instruction = (uint16_t)(i + 1U);
        if (argument >= function->argument_count) {
            return false;
        }
        if ((seen & (1UL << argument)) != 0U) {
            out_reply->failure.code = PUS_FAILURE_DUPLICATE;
            return false;
        }
        seen |= (uint32_t)(1UL << argument);
        if (!decode_argument(functions, &function->arguments[argument], reader)) {
            out_reply->failure.code   = PUS_FAILURE_OUT_OF_RANGE;
            out_reply->failure.detail = offset;
            return false;
        }
    }
    return true;
}

static pus_reply_t perform(void* const self, pus_request_t* const request)
{
    const pus_functions_t* const functions = self;
    octet_reader_t name_reader             = request->reader;
    const uint32_t id                      = octet_read_u32(&name_reader); // First half of the name.
    const uint16_t index = function_of(functions, octet_read_octets(&request->reader, PUS_NAME_SIZE));
    pus_reply_t reply    = pus_refused(PUS_FAILURE_UNKNOWN_ID, id);
    if ((index < functions->count) &&
        decode(functions, &functions->functions[index], &request->reader, &reply)) {
        reply = functions->port.perform(functions->port.context, index, functions->area, &request->token,
                                        request->now_ns);
    }
    return reply;
}

pus_service_t pus_functions_service(pus_functions_t* const functions)
{
    static const pus_subtype_t subtypes[] = {{PERFORM, has_format, perform, NULL}};
    FSW_ASSERT(functions != NULL);
    return (pus_service_t){
        .type = PUS_SERVICE_FUNCTIONS, .subtype_count = 1U, .subtypes = subtypes, .self = functions};
}
