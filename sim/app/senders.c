// SPDX-License-Identifier: Apache-2.0
#include "sim/app/senders.h"

#include <stdio.h>

#define TRANSMIT_PARAMETER 0x1800U // Communication parameter of the first transmit PDO; sub-index 1: COB-ID.
#define IDENTIFIER_MASK 0x1FFFFFFFU

/// Returns the COB-ID entry of a transmit PDO with its initial value; null: the device has no such PDO.
static const object_t* cob_of(const devices_t* const devices, const size_t device, const uint16_t number)
{
    return node_object(device_model(devices, device)->node, (uint16_t)(TRANSMIT_PARAMETER + number), 1U);
}

/// Returns the identifier of a transmit PDO of both devices, or 0.
static uint32_t common_identifier(const devices_t* const devices, const size_t a, const size_t b)
{
    const object_t* first  = NULL;
    const object_t* second = NULL;
    for (uint16_t i = 0U; (first = cob_of(devices, a, i)) != NULL; i++) {
        for (uint16_t k = 0U; (second = cob_of(devices, b, k)) != NULL; k++) {
            const uint32_t identifier = (uint32_t)first->initial & IDENTIFIER_MASK;
            if ((((first->initial | second->initial) & PDO_INVALID) == 0U) &&
                (((uint32_t)second->initial & IDENTIFIER_MASK) == identifier)) {
                return identifier;
            }
        }
    }
    return 0U;
}

status_t senders_check(const devices_t* const devices, const world_t* const world,
                       char error[SIMULATOR_ERROR_MAX])
{
    for (size_t i = 0U; i < devices_count(devices); i++) {
        const world_device_t* device = device_entry(devices, i);
        for (size_t k = 0U; k < i; k++) {
            const world_device_t* other = device_entry(devices, k);
            const uint32_t identifier   = (other->bus == device->bus) ? common_identifier(devices, k, i) : 0U;
            if (identifier != 0U) {
                (void)snprintf(
                    error, SIMULATOR_ERROR_MAX,
                    "simulator: %.100s:%u: %s sends process data with identifier 0x%X, as %s does in "
                    "line %u: expected data sheets with different identifiers on bus %s",
                    world->path, device->line, device->name, identifier, other->name, other->line,
                    world->bus[device->bus]);
                return STATUS_INVALID;
            }
        }
    }
    return STATUS_OK;
}
