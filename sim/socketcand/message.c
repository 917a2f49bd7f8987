// SPDX-License-Identifier: Apache-2.0
#include "sim/socketcand/socketcand.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_S 1000000000U
#define NS_PER_US 1000U
#define STANDARD_DIGITS 3U // More digits mean a 29-bit identifier.

size_t socketcand_message(const osal_can_frame_t* const frame, char* const text)
{
    const unsigned long long seconds      = frame->time_ns / NS_PER_S;
    const unsigned long long microseconds = (frame->time_ns % NS_PER_S) / NS_PER_US;
    const unsigned id                     = frame->id & OSAL_CAN_ID_MASK;
    if ((frame->id & OSAL_CAN_ERROR) != 0U) {
        return (size_t)snprintf(text, SOCKETCAND_MESSAGE_MAX, "< error %08X %llu.%06llu >",
                                (unsigned)(frame->id & (OSAL_CAN_ERROR | OSAL_CAN_ID_MASK)), seconds,
                                microseconds);
    }
    const bool is_extended = (frame->id & OSAL_CAN_EXTENDED) != 0U;
    size_t size            = (size_t)snprintf(text, SOCKETCAND_MESSAGE_MAX,
                                   is_extended ? "< frame %08X %llu.%06llu " : "< frame %03X %llu.%06llu ",
                                              id, seconds, microseconds);
    for (unsigned i = 0U; i < frame->length; i++) {
        static const char digits[] = "0123456789ABCDEF";
        text[size++]               = digits[frame->data[i] >> 4];
        text[size++]               = digits[frame->data[i] & 15U];
    }
    memcpy(&text[size], " >", 3U);
    return size + 2U;
}

/// Read the next blank-separated hexadecimal word. Returns false if there is none, or if it is not a number
/// up to `limit`.
static bool next_number(const char** const text, const unsigned long limit, unsigned long* const out_value,
                        size_t* const out_digits)
{
    while (**text == ' ') {
        (*text)++;
    }
    char* end                 = NULL;
    const unsigned long value = strtoul(*text, &end, 16);
    const bool is_word        = (end != *text) && ((*end == ' ') || (*end == '\0')) && (**text != '-');
    *out_digits               = (size_t)(end - *text);
    *out_value                = value;
    *text                     = end;
    return is_word && (value <= limit);
}

status_t socketcand_parse_send(const char* text, osal_can_frame_t* out_frame)
{
    unsigned long value = 0U;
    size_t digits       = 0U;
    *out_frame          = (osal_can_frame_t){0};
    if (strncmp(text, "send ", 5U) != 0) {
        return STATUS_INVALID;
    }
    text += 5;
    if (!next_number(&text, OSAL_CAN_ID_MASK, &value, &digits)) {
        return STATUS_INVALID;
    }
    const bool is_extended = digits > STANDARD_DIGITS;
    if (!is_extended && (value > 0x7FFU)) {
        return STATUS_INVALID;
    }
    out_frame->id = (uint32_t)value | (is_extended ? OSAL_CAN_EXTENDED : 0U);
    if (!next_number(&text, 8U, &value, &digits)) {
        return STATUS_INVALID;
    }
    out_frame->length = (uint8_t)value;
    for (unsigned i = 0U; i < out_frame->length; i++) {
        if (!next_number(&text, 0xFFU, &value, &digits)) {
            return STATUS_INVALID;
        }
        out_frame->data[i] = (uint8_t)value;
    }
    while (*text == ' ') {
        text++;
    }
    return (*text == '\0') ? STATUS_OK : STATUS_INVALID;
}
