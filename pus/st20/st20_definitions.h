// SPDX-License-Identifier: Apache-2.0
/// Parameters of ST[20] that are defined by a place in memory, by TC[20,4] (address) and [20,5] (object and
/// offset), and the parameter port that provides them and those of the dictionary.
///
/// Such a parameter has an id of its own APID that the dictionary does not have, whose layout bits are the
/// scalar type of PTC and PFC; its value is in memory in the machine's byte order. Defining it again
/// moves it. PTC, PFC: unsigned 3 and 4, 12, 14, 16 for 8 to 64 bits; signed 4 and the same; real 5 and 1, 2;
/// boolean 1 and 0 (one octet). Definitions outlive a power cut by their records (key: parameter id).
///
/// Ownership  The caller places it and its places.
/// Context    The loop of the process.
/// Time       O(places).
#ifndef PUS_ST20_ST20_DEFINITIONS_H
#define PUS_ST20_ST20_DEFINITIONS_H

#include "osal/include/osal/mutex.h"
#include "pus/core/parameter_port.h"
#include "pus/core/persistence.h"
#include "pus/st06/st06_memory.h"

typedef struct { // Private.
    bool in_use;
    uint8_t memory; // Its place in the list.
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
    osal_mutex_t*
        guard; ///< Held by other loops that use the port, and while a definition changes; null: none does.
} pus_parameter_definitions_config_t;

typedef struct { // Private.
    pus_parameter_definitions_config_t config;
} pus_parameter_definitions_t;

/// Where a parameter lies, as in TM[20,7]; one of the dictionary has memory 0 and address 0.
typedef struct {
    uint8_t memory_id;
    uint32_t address;
    uint8_t ptc;
    uint16_t pfc;
} pus_parameter_definition_t;

void pus_parameter_definitions_init(pus_parameter_definitions_t* definitions,
                                    const pus_parameter_definitions_config_t* config);
/// The port to all parameters.
pus_parameter_port_t pus_parameter_definitions_port(pus_parameter_definitions_t* definitions);
/// Read one instruction of TC[20,4], or [20,5] if `is_object`, and perform it. The failure's code is
/// PUS_FAILURE_NONE, PUS_FAILURE_ACCESS (the dictionary has that id), PUS_FAILURE_UNKNOWN_ID (another APID's,
/// no such memory or object), PUS_FAILURE_OUT_OF_RANGE (PTC, PFC), PUS_FAILURE_ADDRESS,
/// PUS_FAILURE_TABLE_FULL, PUS_FAILURE_IO (it cannot be kept).
pus_failure_t pus_parameter_define(pus_parameter_definitions_t* definitions, octet_reader_t* reader,
                                   bool is_object);
/// Definition of a parameter by its id; false if there is none but perhaps in the dictionary, whose PTC and
/// PFC follow from the id alone.
bool pus_parameter_place_of(const pus_parameter_definitions_t* definitions, uint32_t id,
                            pus_parameter_definition_t* out_definition);
/// Restore a record. STATUS_OK, STATUS_INVALID (no such record), STATUS_NOT_FOUND (its memory),
/// STATUS_EXHAUSTED.
MUST_USE status_t pus_parameter_definitions_restore(pus_parameter_definitions_t* definitions, uint32_t key,
                                                    const uint8_t* octets, size_t size);

#endif // PUS_ST20_ST20_DEFINITIONS_H
