// SPDX-License-Identifier: Apache-2.0
/// ST[06] of a subsystem (`<Service type="6"/>` of its descriptor): memory 1 is the storage of the
/// published parameters, memory 2 the component itself, read-only. The subsystem's callback `memories` adds
/// further memories, and the port to files that loads from files and dumps to files (TC[6,19] to [6,22])
/// need. Layout of both memories: docs/services/st06.md.
///
/// With this service ST[20] accepts definitions of parameters by their addresses in these memories
/// (TC[20,4], [20,5]). Such parameters are not in the dictionary; therefore housekeeping and monitoring
/// cannot use them.
///
/// Ownership  The generated program provides memory_service_t.
/// Context    The main loop of the component.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_MEMORY_SERVICE_H
#define FSW_FRAMEWORK_SUBSYSTEM_MEMORY_SERVICE_H

#include "fsw/framework/subsystem/subsystem_core.h"
#include "pus/st06/st06_memory.h"
#include "pus/st20/st20_definitions.h"

#define MEMORY_PARAMETERS 1U
#define MEMORY_COMPONENT 2U
/// Objects of memory 2, which requests can use as base addresses.
#define MEMORY_OBJECT_CALL_TOKENS 0U
#define MEMORY_OBJECT_SAMPLES 1U
#define MEMORY_PARAMETERS_OCTETS 0x10000U ///< Size of the address range of memory 1.
#define MEMORY_COUNT 2U                   ///< Number of memories of every subsystem.
#define MEMORY_FURTHER 4U                 ///< Maximum number of further memories.
#define MEMORY_DEFINITIONS 16U            ///< Parameters defined by TC[20,4] and [20,5].

typedef struct { // Private, except `memory.counters`.
    pus_memory_service_t memory;
    pus_memory_t memories[MEMORY_COUNT + MEMORY_FURTHER];
    pus_memory_state_t states[MEMORY_COUNT + MEMORY_FURTHER];
    pus_parameter_definitions_t definitions;
    pus_parameter_definition_t definition_table[MEMORY_DEFINITIONS];
} memory_service_t;

/// Add the service to a component, with room for `count` operations that run at the same time.
void subsystem_memory_service_add(subsystem_t* subsystem, memory_service_t* service,
                                  pus_memory_operation_t* operations, uint8_t count);

#endif // FSW_FRAMEWORK_SUBSYSTEM_MEMORY_SERVICE_H
