// SPDX-License-Identifier: Apache-2.0
/// Converts the fields of a message to text, according to its layout.
#ifndef PUS_TOOL_PUSDUMP_FIELDS_H
#define PUS_TOOL_PUSDUMP_FIELDS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Write the fields as `name=value name=[..]`, or as a JSON object, NUL-terminated. False if the data does
/// not match the layout exactly, or if the text does not fit the buffer. `layout` comes from message_layout.
bool dump_fields(const char* layout, const uint8_t* data, size_t size, bool as_json, char* text,
                 size_t capacity);

#endif // PUS_TOOL_PUSDUMP_FIELDS_H
