// SPDX-License-Identifier: Apache-2.0
/// Prints one line per packet on standard output, as text or as a JSON object.
#ifndef PUS_TOOL_PUSDUMP_PRINT_H
#define PUS_TOOL_PUSDUMP_PRINT_H

#include "pus/tool/pusdump_packet.h"

typedef struct {
    bool as_json;
    uint64_t epoch_ns; ///< Packet times are printed relative to this if has_epoch.
    bool has_epoch;
} dump_style_t;

/// Print one packet. `log_time`: time of its line in a packet log, or null. `location` in the input, for
/// example "line 12" or "octet 300".
void dump_print(const dump_style_t* style, const dump_packet_t* packet, const char* log_time,
                const char* location);

#endif // PUS_TOOL_PUSDUMP_PRINT_H
