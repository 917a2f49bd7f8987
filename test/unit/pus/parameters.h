// SPDX-License-Identifier: Apache-2.0
/// A small dictionary behind the parameter port. Values are octets 0, 1, 2 .. plus `tick`, so that a test
/// sees when a value was read.
#ifndef TEST_UNIT_PUS_PARAMETERS_H
#define TEST_UNIT_PUS_PARAMETERS_H

#include "pus/parameter_port.h"

#define ID_OF(layout, number) ((16U << 21U) | ((uint32_t)(layout) << 16U) | (number))

#define P_U8 ID_OF(0, 1)      ///< 1 octet.
#define P_U16 ID_OF(1, 2)     ///< 2 octets.
#define P_DOUBLE ID_OF(9, 3)  ///< 8 octets.
#define P_STRUCT ID_OF(24, 4) ///< 11 octets.
#define P_SECRET ID_OF(1, 5)  ///< Not readable.
#define P_FIXED ID_OF(2, 6)   ///< Read-only, 4 octets.
#define P_LIMIT ID_OF(0, 7)   ///< 1 octet, up to 9.
#define P_LOCKED ID_OF(0, 8)  ///< Settable, but not now.
#define P_LARGE ID_OF(25, 9)  ///< 2000 octets.
#define P_ODD ID_OF(0, 10)    ///< Refuses every value as malformed.
#define P_MANY ID_OF(0, 100)  ///< And the 255 numbers after it: 1 octet each.

#define P_UNKNOWN ID_OF(3, 999)        ///< Not there; the layout tells 8 octets.
#define P_UNKNOWN_ARRAY ID_OF(25, 999) ///< Not there; the layout tells no size.

/// What the port has seen.
typedef struct {
    uint8_t tick; ///< Added to every octet read.
    unsigned reads;
    unsigned writes;
    uint32_t written_id;
    size_t written_size;
    uint8_t written[2000];
} dictionary_t;

extern dictionary_t dictionary;

pus_parameter_port_t dictionary_port(void);
/// Write an id big-endian.
void put_id(uint8_t* octets, uint32_t id);

#endif // TEST_UNIT_PUS_PARAMETERS_H
