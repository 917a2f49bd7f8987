// SPDX-License-Identifier: Apache-2.0
/// Further memories of the supervisor's ST[06]: a buffer for the transfer of files between ground and the
/// file store, and the files themselves.
///
/// Uplink: the ground loads the buffer piece by piece (TC[6,2]), then dumps it to a file (TC[6,20]).
/// Downlink: it loads the buffer from a file (TC[6,19]), then dumps the buffer (TC[6,5]). All users share
/// the buffer.
#ifndef FSW_SUPERVISOR_SERVICES_MEMORY_H
#define FSW_SUPERVISOR_SERVICES_MEMORY_H

#include "fsw/framework/subsystem/subsystem.h"

#define SPACECRAFT_MEMORY_BUFFER 3U             ///< Memory id.
#define SPACECRAFT_MEMORY_BUFFER_OCTETS 131072U ///< Size of the buffer; its first address is 0.
#define SPACECRAFT_MEMORIES 1U

typedef struct { // Private to fsw/supervisor.
    pus_memory_t memories[SPACECRAFT_MEMORIES];
    uint8_t buffer[SPACECRAFT_MEMORY_BUFFER_OCTETS];
} spacecraft_memory_t;

/// Callback `memories` of the supervisor as a subsystem.
subsystem_memories_t spacecraft_memories(void* supervisor);

#endif // FSW_SUPERVISOR_SERVICES_MEMORY_H
