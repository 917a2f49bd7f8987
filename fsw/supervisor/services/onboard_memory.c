// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/services/onboard_memory.h"

#include "fsw/supervisor/supervisor_internal.h"

#include <string.h>

static status_t read_buffer(void* const context, const uint32_t address, uint8_t* const octets,
                            const size_t size)
{
    const onboard_memory_t* const memory = context;
    (void)memcpy(octets, &memory->buffer[address], size);
    return STATUS_OK;
}

static status_t write_buffer(void* const context, const uint32_t address, const uint8_t* const octets,
                             const size_t size)
{
    onboard_memory_t* const memory = context;
    (void)memcpy(&memory->buffer[address], octets, size);
    return STATUS_OK;
}

subsystem_memories_t onboard_memories(void* const self)
{
    supervisor_t* const supervisor = self;
    onboard_memory_t* const memory = &supervisor->onboard.memory;
    memory->memories[0]            = (pus_memory_t){.id      = ONBOARD_MEMORY_BUFFER,
                                                    .access  = 1U,
                                                    .size    = ONBOARD_MEMORY_BUFFER_OCTETS,
                                                    .context = memory,
                                                    .read    = read_buffer,
                                                    .write   = write_buffer};
    return (subsystem_memories_t){memory->memories, ONBOARD_MEMORIES, onboard_file_port(supervisor)};
}
