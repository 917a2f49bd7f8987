// SPDX-License-Identifier: Apache-2.0
/// Reads packets from a file that has lines of hexadecimal digits, lines of a packet log, or packets without
/// separators.
#ifndef PUS_TOOL_PUSDUMP_INPUT_H
#define PUS_TOOL_PUSDUMP_INPUT_H

#include "pus/tool/pusdump_print.h"

#include <stdio.h>

typedef enum {
    DUMP_AUTO,  ///< The format is recognized: binary if the file does not begin with text, else lines.
    DUMP_HEX,   ///< Lines: one packet each, in hexadecimal digits; spaces between digits are ignored.
    DUMP_LOG,   ///< Lines: `<time> TC|TM <hex>`.
    DUMP_BINARY ///< Packets without separators.
} dump_format_t;

/// Print every packet of a stream. Empty lines and lines that begin with '#' are skipped. Returns the number
/// of malformed packets and lines.
unsigned long dump_stream(FILE* stream, dump_format_t format, const dump_style_t* style);

#endif // PUS_TOOL_PUSDUMP_INPUT_H
