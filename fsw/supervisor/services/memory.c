// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/services/memory.h"

#include "fsw/supervisor/supervisor_internal.h"

#include <string.h>

/// Callback of ST[06], which passes only areas within the memory.
static status_t read_buffer(void* const context, const uint32_t address, uint8_t* const octets,
                            const size_t size)
{
    const spacecraft_memory_t* const memory = context;
    (void)memcpy(octets, &memory->buffer[address], size);
    return STATUS_OK;
}

/// Callback of ST[06], which passes only areas within the memory, as for read_buffer.
static status_t write_buffer(void* const context, const uint32_t address, const uint8_t* const octets,
                             const size_t size)
{
    spacecraft_memory_t* const memory = context;
    (void)memcpy(&memory->buffer[address], octets, size);
    return STATUS_OK;
}

subsystem_memories_t spacecraft_memories(void* const self)
{
    supervisor_t* const supervisor    = self;
    spacecraft_memory_t* const memory = &supervisor->spacecraft.memory;
    memory->memories[0]               = (pus_memory_t){.id      = SPACECRAFT_MEMORY_BUFFER,
                                                       .access  = 1U,
                                                       .size    = SPACECRAFT_MEMORY_BUFFER_OCTETS,
                                                       .context = memory,
                                                       .read    = read_buffer,
                                                       .write   = write_buffer};
    return (subsystem_memories_t){memory->memories, SPACECRAFT_MEMORIES, spacecraft_file_port(supervisor)};
}
