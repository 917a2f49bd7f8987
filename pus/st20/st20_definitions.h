// SPDX-License-Identifier: Apache-2.0
/// Parameters of ST[20] that are defined by a place in memory, by TC[20,4] (address) and [20,5] (object and
/// offset), and the parameter port that provides them and those of the dictionary.
///
/// Such a parameter has an id of its own APID that the dictionary does not have, whose layout bits are the
/// scalar type of PTC and PFC; its value is in memory in the machine's byte order. Defining it again
/// moves it. PTC, PFC: unsigned 3 and 4, 12, 14, 16 for 8 to 64 bits; signed 4 and the same PFCs; real 5 and
/// 1, 2; boolean 1 and 0 (one octet). Definitions are persistent records (key: parameter id).
///
/// Ownership  The caller places the structure and its array `places`.
/// Context    The loop of the process.
/// Time       O(places).
#ifndef PUS_ST20_ST20_DEFINITIONS_H
#define PUS_ST20_ST20_DEFINITIONS_H

#include "osal/include/osal/mutex.h"
#include "pus/core/persistence.h"
#include "pus/st06/st06_memory.h"
#include "pus/st20/st20_parameters.h"

typedef struct { // Private.
    bool in_use;
    uint8_t memory; // Its index in the list.
    uint8_t type;   // value_type_t
    uint32_t id;
    uint32_t address;
} pus_parameter_place_t;

typedef struct {
    uint16_t apid;             ///< APID of ids that may be defined.
    pus_parameter_port_t port; ///< To the parameters of the dictionary.
    const pus_memory_t* memories;
    const pus_memory_state_t* states; ///< States of ST[06]: a parameter in protected memory is not set.
    uint8_t memory_count;
    pus_parameter_place_t* places;
    uint16_t capacity;                    ///< <= 1024.
    const pus_persistence_t* persistence; ///< Null: nothing is kept.
    osal_mutex_t* guard; ///< Held by other loops that use the port and while a definition changes; or null.
} pus_parameter_definitions_config_t;

typedef struct { // Private.
    pus_parameter_definitions_config_t config;
} pus_parameter_definitions_t;

void pus_parameter_definitions_init(pus_parameter_definitions_t* definitions,
                                    const pus_parameter_definitions_config_t* config);
/// What ST[20] needs of them (pus_parameters_define). Failures of `define`: PUS_FAILURE_ACCESS (the
/// dictionary has that id), PUS_FAILURE_UNKNOWN_ID (another APID's, no such memory or object),
/// PUS_FAILURE_OUT_OF_RANGE (PTC, PFC), PUS_FAILURE_ADDRESS, PUS_FAILURE_TABLE_FULL, PUS_FAILURE_IO (it
/// cannot be kept).
pus_parameter_definer_t pus_parameter_definitions_definer(pus_parameter_definitions_t* definitions);

#endif // PUS_ST20_ST20_DEFINITIONS_H
