// SPDX-License-Identifier: Apache-2.0
/// Private to pus/st19/: the table of event-action definitions and their persistent records.
#ifndef PUS_ST19_ST19_DEFINITIONS_H
#define PUS_ST19_ST19_DEFINITIONS_H

#include "pus/st19/st19_event_action.h"

#define NONE 0xFFFFU // No definition.

typedef pus_event_action_t event_action_t;
typedef pus_event_action_definition_t definition_t;

/// Returns the detail of a failure that names a definition: APID << 16 | event.
uint32_t event_action_key(uint16_t apid, uint16_t event);
/// Returns the pointer to the index in its list that refers to the definition; the index is NONE if there is
/// no such definition.
uint16_t* event_action_link(const event_action_t* self, uint16_t apid, uint16_t event);
/// Set the content of a free definition.
void event_action_enter(event_action_t* self, uint16_t slot, const definition_t* content);
/// Remove the definition to which `link` refers.
void event_action_leave(event_action_t* self, uint16_t* link);
/// Drop the requests of a definition that wait for the port, and count them.
void event_action_drop_waiting(event_action_t* self, definition_t* definition);
/// Copy the request of a definition to `out_octets` (PUS_PACKET_MAX). Returns its size.
size_t event_action_request(const definition_t* definition, uint8_t* out_octets);
/// True if the octets are a well-formed request that a definition may have.
bool event_action_is_request(const uint8_t* octets, size_t size);

/// Store the record of a definition with this status. STATUS_OK, or the status of the persistence port.
MUST_USE status_t event_action_put(event_action_t* self, uint16_t slot, bool is_enabled);
/// Store whether the function is enabled. STATUS_OK, or the status of the persistence port.
MUST_USE status_t event_action_put_function(event_action_t* self);
/// Erase the record of a definition. STATUS_OK, also if there is no record; or the status of the persistence
/// port.
MUST_USE status_t event_action_erase(const event_action_t* self, uint16_t slot);

#endif // PUS_ST19_ST19_DEFINITIONS_H
