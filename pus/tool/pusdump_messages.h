// SPDX-License-Identifier: Apache-2.0
/// The messages that pusdump knows: their names, the layouts of their fields, and words for failure codes.
#ifndef PUS_TOOL_PUSDUMP_MESSAGES_H
#define PUS_TOOL_PUSDUMP_MESSAGES_H

#include <stddef.h>
#include <stdint.h>

/// Returns the name of a message; never null.
const char* message_name(uint8_t service, uint8_t subtype);

/// Layout of a message's application or source data, or null if it is not known. Items are separated by one
/// space:
///     name:u8 u16 u32 u64    unsigned, decimal
///     name:x16 x32 x64       unsigned, hexadecimal
///     name:code              failure code, printed in words
///     name:id                request id, as APID/sequence
///     name:time              absolute time, 8 octets
///     name:text              function name, 8 octets
///     name:octets            u8 count, and as many octets
///     name:rest              all octets that are left
///     name[8 ... ]           list: u8 count, and as often the items up to the bracket; name[16: u16 count
const char* message_layout(uint8_t service, uint8_t subtype);

/// Words for a failure code of ST[01]; never null.
const char* failure_words(uint16_t code);

#endif // PUS_TOOL_PUSDUMP_MESSAGES_H
