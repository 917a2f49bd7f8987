// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/subsystem_descriptor.h"

#include "base/assertion.h"

#include <string.h>

/// First members of the entries that descriptor_numbered finds. The entries that descriptor_named finds begin
/// with their name.
typedef struct {
    const char* name;
    uint16_t id;
} head_t;

#define HAS_HEAD(type)                                                                                       \
    ((offsetof(type, name) == offsetof(head_t, name)) && (offsetof(type, id) == offsetof(head_t, id)))
typedef char entries_fit[(HAS_HEAD(descriptor_event_t) && HAS_HEAD(descriptor_function_t) &&
                          HAS_HEAD(descriptor_configuration_t) && HAS_HEAD(descriptor_port_t))
                             ? 1
                             : -1];

void descriptor_subsystem_use_storage(subsystem_descriptor_t* const descriptor)
{
    FSW_ASSERT(descriptor != NULL);
    const subsystem_storage_t* const storage = &descriptor->storage;
    descriptor->enumerations                 = storage->enumerations;
    descriptor->failures                     = storage->failures;
    descriptor->fields                       = storage->fields;
    descriptor->parameters                   = storage->parameters;
    descriptor->events                       = storage->events;
    descriptor->functions                    = storage->functions;
    descriptor->services                     = storage->services;
    descriptor->configurations               = storage->configurations;
    descriptor->initials                     = storage->initials;
    descriptor->references                   = storage->references;
    descriptor->loops                        = storage->loops;
    descriptor->structures                   = storage->structures;
    descriptor->sampled                      = storage->sampled;
    descriptor->ports                        = storage->ports;
    descriptor->devices                      = storage->devices;
    descriptor->settings                     = storage->settings;
    descriptor->quantities                   = storage->quantities;
    descriptor->supplies                     = storage->supplies;
    descriptor->record_fields                = storage->record_fields;
    descriptor->endnodes                     = storage->endnodes;
}

void descriptor_subsystem_clear(subsystem_descriptor_t* const descriptor)
{
    FSW_ASSERT(descriptor != NULL);
    (void)memset(descriptor, 0, sizeof *descriptor);
    descriptor->name = "";
    descriptor_subsystem_use_storage(descriptor);
}

const void* descriptor_named(const void* const entries, const uint16_t count, const size_t size,
                             const char* const name)
{
    const uint8_t* entry = entries;
    for (uint32_t left = count; left > 0U; left--) {
        const char* own = NULL;
        (void)memcpy(&own, entry, sizeof own);
        if (strcmp(own, name) == 0) {
            return entry;
        }
        entry += size;
    }
    return NULL;
}

const void* descriptor_numbered(const void* const entries, const uint16_t count, const size_t size,
                                const uint16_t id)
{
    const uint8_t* entry = entries;
    for (uint32_t left = count; left > 0U; left--) {
        const void* const member = &entry[offsetof(head_t, id)];
        uint16_t own             = 0U;
        (void)memcpy(&own, member, sizeof own);
        if (own == id) {
            return entry;
        }
        entry += size;
    }
    return NULL;
}

bool descriptor_is_stream(const descriptor_device_t* const device)
{
    FSW_ASSERT(device != NULL);
    return strcmp(device->type, DESCRIPTOR_STREAM_TYPE) == 0;
}

const descriptor_parameter_t* descriptor_find_parameter(const subsystem_descriptor_t* const descriptor,
                                                        const char* const name)
{
    FSW_ASSERT((descriptor != NULL) && (name != NULL));
    return descriptor_named(descriptor->parameters, descriptor->parameter_count,
                            sizeof descriptor->parameters[0], name);
}

const descriptor_event_t* descriptor_find_event(const subsystem_descriptor_t* const descriptor,
                                                const uint16_t id)
{
    FSW_ASSERT(descriptor != NULL);
    return descriptor_numbered(descriptor->events, descriptor->event_count, sizeof descriptor->events[0], id);
}

const descriptor_event_t* descriptor_find_event_name(const subsystem_descriptor_t* const descriptor,
                                                     const char* const name)
{
    FSW_ASSERT((descriptor != NULL) && (name != NULL));
    return descriptor_named(descriptor->events, descriptor->event_count, sizeof descriptor->events[0], name);
}

const descriptor_configuration_t*
descriptor_find_configuration(const subsystem_descriptor_t* const descriptor, const uint16_t id)
{
    FSW_ASSERT(descriptor != NULL);
    return descriptor_numbered(descriptor->configurations, descriptor->configuration_count,
                               sizeof descriptor->configurations[0], id);
}

const descriptor_port_t* descriptor_find_port(const subsystem_descriptor_t* const descriptor,
                                              const descriptor_configuration_t* const configuration,
                                              const uint16_t id)
{
    FSW_ASSERT((descriptor != NULL) && (configuration != NULL));
    return descriptor_numbered(&descriptor->ports[configuration->first_port], configuration->port_count,
                               sizeof descriptor->ports[0], id);
}

const char* descriptor_state_name(const uint8_t state)
{
    static const char names[DESCRIPTOR_STATES][18] = {
        "OFFLINE",     "SOFTWARE_INIT",     "HARDWARE_INIT",    "PRE_OPERATIONAL", "SAFE_OPERATIONAL",
        "OPERATIONAL", "ERROR_OPERATIONAL", "POST_OPERATIONAL", "HARDWARE_DEINIT", "SOFTWARE_DEINIT"};
    return (state < DESCRIPTOR_STATES) ? names[state] : "UNKNOWN";
}

void descriptor_state_words(const uint16_t states, text_t* const out_words)
{
    FSW_ASSERT(out_words != NULL);
    for (uint8_t state = 0U; state < DESCRIPTOR_STATES; state++) {
        if ((((uint32_t)states >> state) & 1U) != 0U) {
            text_add(out_words, (out_words->length > 0U) ? " " : "");
            text_add(out_words, descriptor_state_name(state));
        }
    }
}

status_t descriptor_state_of(const char* const name, uint8_t* const out_state)
{
    FSW_ASSERT((name != NULL) && (out_state != NULL));
    for (uint8_t state = 0U; state < DESCRIPTOR_STATES; state++) {
        if (strcmp(name, descriptor_state_name(state)) == 0) {
            *out_state = state;
            return STATUS_OK;
        }
    }
    return STATUS_NOT_FOUND;
}
