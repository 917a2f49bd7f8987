// SPDX-License-Identifier: Apache-2.0
#include "pus/st19/st19_definitions.h"

#include "base/assertion.h"
#include "pus/core/stored_request.h"

#include <string.h>

// Keys of persistent records.
#define KEY_STATE 0U
#define KEY_DEFINITION 0x01000000U
#define SLOT_MASK 0xFFFFU

void pus_event_action_init(event_action_t* const self, const pus_event_action_config_t* const config)
{
    FSW_ASSERT((self != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->release.send != NULL) && (config->definitions != NULL) && (config->queue != NULL) &&
               (config->buckets != NULL) && (config->chains != NULL));
    FSW_ASSERT((config->definition_count >= 1U) && (config->definition_count < NONE) &&
               (config->bucket_count >= 1U) && ((config->bucket_count & (config->bucket_count - 1U)) == 0U));
    (void)memset(self, 0, sizeof *self);
    self->config = *config;
    self->free   = NONE;
    for (uint32_t i = 0U; i < config->bucket_count; i++) {
        config->buckets[i] = NONE;
    }
    // Link in reverse order, so that the definition with the lowest index is taken first.
    for (uint16_t i = config->definition_count; i > 0U; i--) {
        config->definitions[i - 1U] = (definition_t){.next = self->free};
        self->free                  = (uint16_t)(i - 1U);
    }
}

// ---- Definitions ----

uint32_t event_action_key(const uint16_t apid, const uint16_t event)
{
    return ((uint32_t)apid << 16U) | event;
}

static uint16_t* bucket_of(const event_action_t* const self, const uint16_t apid, const uint16_t event)
{
    uint32_t hash = event_action_key(apid, event) * 0x9E3779B1U;
    hash          = hash ^ (hash >> 16U);
    return &self->config.buckets[hash & (self->config.bucket_count - 1U)];
}

/// Returns the pointer to the index (of the bucket or of the definition before) that refers to the
/// definition; it contains NONE if there is no such definition.
uint16_t* event_action_link(const event_action_t* const self, const uint16_t apid, const uint16_t event)
{
    uint16_t* link = bucket_of(self, apid, event);
    while ((*link != NONE) && ((self->config.definitions[*link].apid != apid) ||
                               (self->config.definitions[*link].event != event))) {
        link = &self->config.definitions[*link].next;
    }
    return link;
}

/// Move a definition from the free list to its bucket.
void event_action_enter(event_action_t* const self, const uint16_t slot, const definition_t* const content)
{
    definition_t* const definition = &self->config.definitions[slot];
    uint16_t* link                 = &self->free;
    while (*link != slot) { // The slot is the first free one, except while records are restored.
        link = &self->config.definitions[*link].next;
    }
    *link                  = definition->next;
    uint16_t* const bucket = bucket_of(self, content->apid, content->event);
    // The slot may still be in the queue, from a definition that was deleted: it must not be queued twice.
    const bool is_queued  = definition->is_queued;
    *definition           = *content;
    definition->in_use    = true;
    definition->is_queued = is_queued;
    definition->next      = *bucket;
    *bucket               = slot;
    self->count++;
}

/// Drop the requests of a definition that wait for the port.
void event_action_drop_waiting(event_action_t* const self, definition_t* const definition)
{
    self->counters.dropped += definition->waiting;
    definition->waiting = 0U;
}

void event_action_leave(event_action_t* const self, uint16_t* const link)
{
    const uint16_t slot            = *link;
    definition_t* const definition = &self->config.definitions[slot];
    *link                          = definition->next;
    event_action_drop_waiting(self, definition);
    pus_block_chain_free(self->config.chains, &definition->request);
    definition->in_use     = false;
    definition->is_enabled = false;
    definition->next       = self->free;
    self->free             = slot;
    self->count--;
}

size_t event_action_request(const definition_t* const definition, uint8_t* const out_octets)
{
    pus_block_chain_reader_t reader = pus_block_chain_reader(&definition->request);
    return pus_block_chain_read(&reader, out_octets, PUS_PACKET_MAX);
}

// ---- Persistent records ----

static status_t put(const event_action_t* const self, const uint32_t key, const size_t size)
{
    const pus_persistence_t* const port = self->config.persistence;
    return (port != NULL) ? port->put(port->context, PUS_SERVICE_EVENT_ACTION, key, self->record, size)
                          : STATUS_OK;
}

status_t event_action_put_function(event_action_t* const self)
{
    self->record[0] = self->is_enabled ? 1U : 0U;
    return put(self, KEY_STATE, 1U);
}

status_t event_action_erase(const event_action_t* const self, const uint16_t slot)
{
    const pus_persistence_t* const port = self->config.persistence;
    const status_t status               = (port != NULL)
                                              ? port->erase(port->context, PUS_SERVICE_EVENT_ACTION, KEY_DEFINITION | slot)
                                              : STATUS_OK;
    return (status == STATUS_NOT_FOUND) ? STATUS_OK : status;
}

/// Write the persistent record of a definition, with this status.
status_t event_action_put(event_action_t* const self, const uint16_t slot, const bool is_enabled)
{
    const definition_t* const definition = &self->config.definitions[slot];
    octet_writer_t writer                = octet_writer(self->record, PUS_EVENT_ACTION_RECORD_HEAD);
    octet_write_u16(&writer, definition->apid);
    octet_write_u16(&writer, definition->event);
    octet_write_u8(&writer, is_enabled ? 1U : 0U);
    const size_t size = event_action_request(definition, &self->record[PUS_EVENT_ACTION_RECORD_HEAD]);
    return put(self, KEY_DEFINITION | slot, PUS_EVENT_ACTION_RECORD_HEAD + size);
}

bool event_action_is_request(const uint8_t* const octets, const size_t size)
{
    pus_tc_t tc;
    pus_failure_t failure;
    return (size <= PUS_EVENT_ACTION_REQUEST_MAX) &&
           (pus_stored_request_decode(octets, size, &tc, &failure) == STATUS_OK);
}

static status_t restore_definition(event_action_t* const self, const uint32_t slot,
                                   octet_reader_t* const reader)
{
    if (slot >= self->config.definition_count) {
        return STATUS_EXHAUSTED;
    }
    definition_t content        = {0};
    content.apid                = octet_read_u16(reader);
    content.event               = octet_read_u16(reader);
    content.is_enabled          = octet_read_u8(reader) != 0U;
    const size_t size           = octet_reader_left(reader);
    const uint8_t* const octets = octet_read_octets(reader, size);
    if ((octets == NULL) || !event_action_is_request(octets, size)) {
        return STATUS_INVALID;
    }
    if (self->config.definitions[slot].in_use ||
        (*event_action_link(self, content.apid, content.event) != NONE)) {
        return STATUS_EXISTS;
    }
    const status_t status = pus_block_chain_append(self->config.chains, &content.request, octets, size);
    if (status == STATUS_OK) {
        event_action_enter(self, (uint16_t)slot, &content);
    }
    return status;
}

status_t pus_event_action_restore(event_action_t* const self, const uint32_t key, const uint8_t* const octets,
                                  const size_t size)
{
    FSW_ASSERT((self != NULL) && (octets != NULL));
    octet_reader_t reader = octet_reader(octets, size);
    if ((key == KEY_STATE) && (size == 1U)) {
        self->is_enabled = octet_read_u8(&reader) != 0U;
        return STATUS_OK;
    }
    return ((key & ~SLOT_MASK) == KEY_DEFINITION) ? restore_definition(self, key & SLOT_MASK, &reader)
                                                  : STATUS_INVALID;
}
