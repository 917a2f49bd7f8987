// SPDX-License-Identifier: Apache-2.0
/// Packets out of a file: lines of hexadecimal digits, lines of a packet log, or packets back to back.
#ifndef PUS_TOOL_PUSDUMP_INPUT_H
#define PUS_TOOL_PUSDUMP_INPUT_H

#include "pus/tool/pusdump_print.h"

#include <stdio.h>

typedef enum {
    DUMP_AUTO,  ///< Binary if the file begins like a packet, else lines of either kind.
    DUMP_HEX,   ///< Lines: one packet in hexadecimal digits each; spaces between digits do not matter.
    DUMP_LOG,   ///< Lines: `<time> TC|TM <hex>`.
    DUMP_BINARY ///< Packets back to back.
} dump_format_t;

/// Print every packet of a stream. Empty lines and lines that begin with '#' are skipped. Returns how many
/// packets or lines were malformed.
unsigned long dump_stream(FILE* stream, dump_format_t format, const dump_style_t* style);

#endif // PUS_TOOL_PUSDUMP_INPUT_H
