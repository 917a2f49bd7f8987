// SPDX-License-Identifier: Apache-2.0
/// Process data objects of CiA 301: communication and mapping parameters of one PDO, packing and unpacking.
///
/// When an object of a PDO has been written, pdo_configure updates the pdo_t; in a cycle only the values in
/// pdo_t are used. Mapped objects have whole octets, at most eight octets in total.
#ifndef SIM_DEVICES_PDO_H
#define SIM_DEVICES_PDO_H

#include "sim/devices/dictionary.h"

#include <stdbool.h>
#include <stdint.h>

#define PDO_ENTRIES_MAX 8U
#define PDO_OCTETS_MAX 8U

#define PDO_INVALID 0x80000000U  ///< In the COB-ID entry: the PDO does not exist.
#define PDO_EXTENDED 0x20000000U ///< In the COB-ID entry: 29-bit identifier.

#define PDO_SYNCHRONOUS_MAX 240U ///< Types 0..240 are sent or applied at SYNC.
#define PDO_EVENT_MANUFACTURER 254U

typedef enum {
    PDO_RECEIVE, ///< 0x1400, 0x1600
    PDO_TRANSMIT ///< 0x1800, 0x1A00
} pdo_direction_t;

typedef struct { // Read-only for other modules, except the fields of the running PDO.
    pdo_direction_t direction;
    uint16_t number; ///< 0-based.
    object_t* cob_entry;
    object_t* type_entry;
    object_t* event_entry; ///< Event timer [ms]; may be null.
    object_t* start_entry; ///< SYNC start value; may be null.
    object_t* count_entry;
    object_t* map_entry[PDO_ENTRIES_MAX];

    bool is_valid;
    uint32_t cob_id;
    uint8_t type;
    uint64_t event_ns;
    uint8_t octets;
    uint8_t entry_count;
    object_t* entry[PDO_ENTRIES_MAX];

    // State of the running PDO.
    bool is_pending;      ///< Received, to be applied at the next SYNC.
    uint8_t sync_count;   ///< SYNCs since the last transmission.
    bool is_waiting;      ///< Waits for its SYNC start value.
    uint64_t deadline_ns; ///< Time at which the event timer expires; UINT64_MAX: not running.
    uint8_t data[PDO_OCTETS_MAX];
} pdo_t;

/// Find the objects of PDO `number`. Returns false if the dictionary does not have it.
bool pdo_init(pdo_t* pdo, pdo_direction_t direction, uint16_t number, const dictionary_t* dictionary);

/// Sub-index of the first entry of the mapping whose object the device does not have, cannot map with this
/// length, or has no room for; 0 if there is none.
uint8_t pdo_unusable_entry(const pdo_t* pdo);
/// Read parameters and mapping from the objects.
void pdo_configure(pdo_t* pdo, const dictionary_t* dictionary);
/// True if the object is a parameter of this PDO.
bool pdo_owns(const pdo_t* pdo, const object_t* object);
/// Abort code for setting a parameter of this PDO to a value, or 0.
uint32_t pdo_check(const pdo_t* pdo, const dictionary_t* dictionary, const object_t* object, int64_t value);

/// Pack the mapped objects, little-endian. Returns true if the octets differ from those packed last.
bool pdo_pack(pdo_t* pdo);
/// Unpack `data` into the mapped objects.
void pdo_unpack(pdo_t* pdo);

#endif // SIM_DEVICES_PDO_H
