// SPDX-License-Identifier: Apache-2.0
/// Parameters of ST[20] that a request defines by an address in memory: TC[20,4] by address, TC[20,5] by
/// object and offset. The parameter port gives access to these parameters and to those of the dictionary.
///
/// The id of such a parameter has the APID of the process and is not in the dictionary; its layout bits are
/// the scalar type that PTC and PFC define. The value is in memory in the byte order of the machine. A new
/// definition of the same id replaces the earlier one. The permitted types are PTC 3 (unsigned) and 4
/// (signed) with PFC 4, 12, 14 and 16 (8, 16, 32 and 64 bits), PTC 5 (real) with PFC 1 and 2, and PTC 1
/// (boolean, one octet) with PFC 0. Definitions are persistent records (key: parameter id).
///
/// Ownership  The caller provides the structure and its array `table`.
/// Context    The loop of the process.
/// Time       O(capacity).
#ifndef PUS_ST20_ST20_DEFINITIONS_H
#define PUS_ST20_ST20_DEFINITIONS_H

#include "osal/include/osal/mutex.h"
#include "pus/core/persistence.h"
#include "pus/st06/st06_memory.h"
#include "pus/st20/st20_parameters.h"

typedef struct { // Private.
    bool in_use;
    uint8_t memory; // Index of the memory.
    uint8_t type;   // value_type_t
    uint32_t id;
    uint32_t address;
} pus_parameter_definition_t;

typedef struct {
    uint16_t apid;             ///< APID in the ids that may be defined.
    pus_parameter_port_t port; ///< Port to the parameters of the dictionary.
    const pus_memory_t* memories;
    const pus_memory_state_t* states; ///< States of ST[06]: a parameter in protected memory cannot be set.
    uint8_t memory_count;
    pus_parameter_definition_t* table;
    uint16_t capacity;                    ///< <= 1024.
    const pus_persistence_t* persistence; ///< Null: the service stores no records.
    /// Locked while another loop uses the port, and while a definition changes; null: no other loop uses it.
    osal_mutex_t* mutex;
} pus_parameter_definitions_config_t;

typedef struct { // Private.
    pus_parameter_definitions_config_t config;
} pus_parameter_definitions_t;

void pus_parameter_definitions_init(pus_parameter_definitions_t* definitions,
                                    const pus_parameter_definitions_config_t* config);
/// Functions of the definitions for ST[20] (pus_parameters_define). Failures of `define`: PUS_FAILURE_ACCESS
/// (the id is in the dictionary), PUS_FAILURE_UNKNOWN_ID (id of another APID, no such memory or object),
/// PUS_FAILURE_OUT_OF_RANGE (PTC, PFC), PUS_FAILURE_ADDRESS, PUS_FAILURE_TABLE_FULL, PUS_FAILURE_IO (the
/// record cannot be stored).
pus_parameter_definer_t pus_parameter_definitions_definer(pus_parameter_definitions_t* definitions);

#endif // PUS_ST20_ST20_DEFINITIONS_H
