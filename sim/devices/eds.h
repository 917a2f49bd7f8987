// SPDX-License-Identifier: Apache-2.0
/// Reader of electronic data sheets (CiA 306): makes the object dictionary of a device from its EDS file.
///
/// Keys that are read for each object: ParameterName (mandatory), ObjectType, DataType, AccessType, LowLimit,
/// HighLimit, DefaultValue (decimal, hexadecimal, or with $NODEID), PDOMapping. Sections that describe no
/// object are skipped, and so are objects whose type is not one of object_type_t (sim/devices/dictionary.h).
/// Keys and values are not case-sensitive. A hexadecimal number may be the two's complement of a negative
/// one.
#ifndef SIM_DEVICES_EDS_H
#define SIM_DEVICES_EDS_H

#include "base/status.h"
#include "sim/devices/dictionary.h"

#include <stdint.h>

#define EDS_ERROR_MAX 320U

/// Read an EDS file. STATUS_OK; STATUS_NOT_FOUND (file), STATUS_INVALID (content) or STATUS_EXHAUSTED
/// (memory): the dictionary is empty, and `error` contains "file:line: error".
MUST_USE status_t eds_load(const char* path, uint8_t node_id, dictionary_t* out_dictionary,
                           char error[EDS_ERROR_MAX]);

#endif // SIM_DEVICES_EDS_H
