// SPDX-License-Identifier: Apache-2.0
/// Quantities of devices in engineering units. The descriptor defines each as the value of an object times
/// a scale. In packets a quantity is a DOUBLE, whatever type its object has.
///
/// Context    The subsystem's task.
/// Time       O(devices and quantities of the configuration).
#ifndef FSW_DRIVES_DRIVES_QUANTITY_H
#define FSW_DRIVES_DRIVES_QUANTITY_H

#include "fsw/drives/drives.h"

#define DRIVES_QUANTITY_OCTETS 8U

/// Find a quantity of a device of the applied configuration, by node and id. STATUS_OK; STATUS_NOT_FOUND (no
/// configuration, no such device, or it has no quantities); STATUS_OUT_OF_RANGE (the device has quantities,
/// but not this one). *out_quantity is valid only after STATUS_OK.
MUST_USE status_t drives_quantity_find(const drives_t* drives, uint16_t node, uint32_t id,
                                       const descriptor_quantity_t** out_quantity);
/// Convert a value, most significant octet first, to the octets of the object, least significant first.
/// False: the object cannot represent the value.
bool drives_quantity_to_object(const descriptor_quantity_t* quantity,
                               const uint8_t value[DRIVES_QUANTITY_OCTETS],
                               uint8_t out_octets[DRIVES_QUANTITY_OCTETS]);
/// Convert the octets of the object, least significant first, to a value, most significant octet first.
void drives_quantity_of_object(const descriptor_quantity_t* quantity, const uint8_t* octets,
                               uint8_t out_value[DRIVES_QUANTITY_OCTETS]);

#endif // FSW_DRIVES_DRIVES_QUANTITY_H
