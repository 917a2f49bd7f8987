// SPDX-License-Identifier: Apache-2.0
/// Telemetry definitions from the descriptors of a mission's subsystems: sizes of parameters, scalars by
/// their names, and the housekeeping structures of each configuration. The values are in the telemetry
/// cache.
///
/// A scalar is named SUBSYSTEM.PARAMETER or, within a structured parameter, SUBSYSTEM.PARAMETER.FIELD; an
/// element of an array has its index, from 0, in brackets: ARM.VALUES.POSITION[1].
///
/// Ownership  The caller provides telemetry_directory_t.
/// Context    One loop.
/// Time       Learning O(content), once at start; finding a name O(fields).
#ifndef FSW_SUPERVISOR_TELEMETRY_DIRECTORY_H
#define FSW_SUPERVISOR_TELEMETRY_DIRECTORY_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/supervisor/telemetry_cache.h"

/// Number of parameters. This and the next capacities are for all subsystems together.
#define TELEMETRY_PARAMETERS 512U
#define TELEMETRY_FIELDS 2048U
#define TELEMETRY_STRUCTURES 128U ///< Structures; each counts once for each configuration.
#define TELEMETRY_CONTENT 16384U  ///< Size of the definitions of these structures [octets].
#define TELEMETRY_NAME_MAX (DESCRIPTOR_NAME_MAX + DESCRIPTOR_NAME_MAX + DESCRIPTOR_PATH_MAX + 16U)

typedef struct { ///< A scalar in the value of a parameter.
    uint32_t parameter_id;
    uint32_t offset; ///< Offset in the octets of the parameter on the wire.
    value_type_t type;
} telemetry_scalar_t;

typedef struct { // Private.
    uint32_t id;
    uint16_t size; // Size on the wire [octets].
} telemetry_parameter_t;

typedef struct {   // Private: a number of consecutive scalars.
    uint64_t name; // Hash of the name; collisions are not expected.
    telemetry_scalar_t first;
    uint16_t count;
} telemetry_field_t;

typedef struct { // Private.
    uint16_t apid;
    uint16_t configuration;
    uint16_t id;
    uint16_t offset; // Offset of its definition, which is the part of TM[3,10] that lists the parameters.
    uint16_t size;
} telemetry_structure_t;

typedef struct { // Private, except `full`.
    uint16_t parameter_count;
    uint16_t field_count;
    uint16_t structure_count;
    uint16_t content_used;
    telemetry_parameter_t parameters[TELEMETRY_PARAMETERS];
    telemetry_field_t fields[TELEMETRY_FIELDS];
    telemetry_structure_t structures[TELEMETRY_STRUCTURES];
    uint8_t content[TELEMETRY_CONTENT];
    uint32_t full; ///< Definitions dropped: no room, or a parameter with more than 65535 octets.
} telemetry_directory_t;

void supervisor_telemetry_directory_init(telemetry_directory_t* directory);
/// Add a subsystem's telemetry. Definitions for which there is no room are counted.
void supervisor_telemetry_directory_learn(telemetry_directory_t* directory,
                                          const subsystem_descriptor_t* descriptor);
/// Find a scalar by its name. STATUS_OK, STATUS_NOT_FOUND (no such name, or the name of an array or a
/// structure).
MUST_USE status_t supervisor_telemetry_directory_find(const telemetry_directory_t* directory,
                                                      const char* name, telemetry_scalar_t* out_scalar);
/// Returns the source of sizes for the telemetry cache; the directory must outlive the cache.
telemetry_cache_sizes_t supervisor_telemetry_directory_sizes(telemetry_directory_t* directory);
/// Define in the telemetry cache the housekeeping structures that a subsystem has in a configuration. Other
/// structures of the subsystem stay defined.
void supervisor_telemetry_directory_define(const telemetry_directory_t* directory, telemetry_cache_t* cache,
                                           uint16_t apid, uint16_t configuration);

#endif // FSW_SUPERVISOR_TELEMETRY_DIRECTORY_H
