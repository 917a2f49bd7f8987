// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/services/spacecraft_services.h"

#include "base/assertion.h"
#include "fsw/supervisor/supervisor_internal.h"

#include <string.h>

/// All bindings, in the order in which they are stepped. It is the order of released requests and of reports
/// within a step, so another order would change the octets of the logs.
static const spacecraft_binding_t* const bindings[] = {
    &spacecraft_time_schedule, &spacecraft_position_schedule, &spacecraft_event_action, &spacecraft_sequences,
    &spacecraft_files,         &spacecraft_forwarding,        &spacecraft_connection,   &spacecraft_storage,
    &spacecraft_time,          &spacecraft_procedures,        &spacecraft_large_packets};
#define BINDINGS (sizeof bindings / sizeof bindings[0])

// ---- Definitions of the values that subsystems report ----

static void learn_telemetry(struct supervisor* const supervisor)
{
    spacecraft_services_t* const spacecraft      = &supervisor->spacecraft;
    const supervisor_descriptors_t* const others = &supervisor->config.descriptors;
    const telemetry_cache_sizes_t sizes = supervisor_telemetry_directory_sizes(&spacecraft->directory);
    supervisor_telemetry_directory_init(&spacecraft->directory);
    supervisor_telemetry_cache_init(&spacecraft->cache, &sizes);
    for (uint16_t i = 0U; (i < supervisor->mission->subsystem_count) && (others->load != NULL); i++) {
        const subsystem_descriptor_t* descriptor = NULL;
        if (others->load(others->context, i, &descriptor) == STATUS_OK) {
            supervisor_telemetry_directory_learn(&spacecraft->directory, descriptor);
        }
    }
}

/// Update the known housekeeping structures when a subsystem has applied a configuration: they are then
/// those of the descriptor.
static void follow_configuration(struct supervisor* const supervisor, const uint16_t apid)
{
    spacecraft_services_t* const spacecraft = &supervisor->spacecraft;
    const registry_entry_t* const entry     = supervisor_registry_find(supervisor, apid);
    if (entry == NULL) {
        return;
    }
    uint16_t* const defined = &spacecraft->defined[entry - supervisor->registry];
    if (*defined != entry->configuration) {
        *defined = entry->configuration;
        supervisor_telemetry_directory_define(&spacecraft->directory, &spacecraft->cache, apid,
                                              entry->configuration);
    }
}

// ---- Services ----

size_t spacecraft_open(struct supervisor* const supervisor, pus_service_t* const services)
{
    spacecraft_services_t* const spacecraft = &supervisor->spacecraft;
    learn_telemetry(supervisor);
    message_ring_init(&spacecraft->released, spacecraft->release_storage, sizeof spacecraft->release_storage);
    FSW_ASSERT(BINDINGS <= SPACECRAFT_SERVICES);
    for (size_t i = 0U; i < BINDINGS; i++) {
        services[i] = bindings[i]->open(supervisor);
    }
    return BINDINGS;
}

uint16_t spacecraft_capacity(const struct supervisor* const supervisor, const uint8_t type,
                             const uint16_t most)
{
    const subsystem_descriptor_t* const descriptor = supervisor->config.descriptor;
    for (uint16_t i = 0U; i < descriptor->service_count; i++) {
        const descriptor_service_t* const service = &descriptor->services[i];
        if (service->is_of_spacecraft && (service->type == type)) {
            return (service->capacity < most) ? service->capacity : most;
        }
    }
    return most;
}

const pus_persistence_t* spacecraft_persistence(struct supervisor* const supervisor)
{
    journal_t* const journal = supervisor->config.journal;
    supervisor->spacecraft.persistence =
        (pus_persistence_t){journal, journal_put, journal_erase, journal_commit};
    return (journal != NULL) ? &supervisor->spacecraft.persistence : NULL;
}

void spacecraft_report_refused(struct supervisor* const supervisor, const uint8_t table, const uint32_t key,
                               const status_t status)
{
    uint8_t octets[6];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, table);
    octet_write_u32(&writer, key);
    octet_write_u8(&writer, (uint8_t)status);
    supervisor->spacecraft.refused++;
    (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_RECORD_REFUSED, octets, writer.position);
}

/// Pass one record to the service to whose table it belongs.
static void restore_record(void* const context, const uint8_t table, const uint32_t key,
                           const uint8_t* const octets, const size_t size)
{
    struct supervisor* const supervisor = (struct supervisor*)context;
    size_t index                        = 0U;
    while ((index < BINDINGS) && (bindings[index]->type != table)) {
        index++;
    }
    status_t status = STATUS_OK;
    if (table == PUS_SERVICE_MISSION) {
        status = supervisor_mode_restore(supervisor, octets, size);
    } else if ((index < BINDINGS) && (bindings[index]->restore != NULL)) {
        status = bindings[index]->restore(supervisor, key, octets, size);
    } else {
        status = subsystem_restore(&supervisor->subsystem, table, key, octets, size);
    }
    if (status != STATUS_OK) {
        spacecraft_report_refused(supervisor, table, key, status);
    }
}

void spacecraft_restore(struct supervisor* const supervisor)
{
    if (supervisor->config.journal != NULL) {
        const status_t status = journal_replay(supervisor->config.journal, restore_record, supervisor);
        if (status != STATUS_OK) {
            spacecraft_report_refused(supervisor, 0U, 0U, status);
        }
    }
    for (size_t i = 0U; i < BINDINGS; i++) {
        const status_t status = (bindings[i]->start != NULL) ? bindings[i]->start(supervisor) : STATUS_OK;
        if (status != STATUS_OK) {
            spacecraft_report_refused(supervisor, bindings[i]->type, 0U, status);
        }
    }
}

void spacecraft_report_damage(struct supervisor* const supervisor)
{
    uint8_t octets[JOURNAL_DAMAGE_SIZE];
    const journal_t* const journal = supervisor->config.journal;
    if ((journal != NULL) && journal_report_damage(journal, 0U, octets)) {
        (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_JOURNAL_DAMAGED, octets,
                              sizeof octets);
        supervisor_mode_fall_back(supervisor);
    }
}

status_t spacecraft_release(void* const context, const uint8_t* const packet, const size_t size)
{
    struct supervisor* const supervisor = (struct supervisor*)context;
    return message_ring_put(&supervisor->spacecraft.released, packet, size);
}

/// True if the first released request may be routed now: its addressee has credit, is not running, or has
/// been without credit for SPACECRAFT_CREDIT_TIMEOUT_NS.
static bool may_go(struct supervisor* const supervisor, const size_t size)
{
    spacecraft_services_t* const spacecraft = &supervisor->spacecraft;
    pus_tc_t tc;
    pus_failure_t failure;
    const bool is_whole                 = pus_tc_decode(spacecraft->packet, size, &tc, &failure) == STATUS_OK;
    const registry_entry_t* const entry = is_whole ? supervisor_registry_find(supervisor, tc.apid) : NULL;
    if ((entry == NULL) || (entry->process != PROCESS_RUNNING)) {
        return true; // Routing refuses the request immediately.
    }
    uint64_t* const since_ns = &spacecraft->full_since_ns[entry - supervisor->registry];
    if (supervisor_router_has_room(supervisor, tc.apid)) {
        *since_ns = 0U;
        return true;
    }
    if (*since_ns == 0U) {
        *since_ns = supervisor->now_ns;
    }
    return (supervisor->now_ns - *since_ns) >= SPACECRAFT_CREDIT_TIMEOUT_NS;
}

static void route_released(struct supervisor* const supervisor)
{
    spacecraft_services_t* const spacecraft = &supervisor->spacecraft;
    size_t size                             = 0U;
    while ((message_ring_peek(&spacecraft->released, spacecraft->packet, sizeof spacecraft->packet, &size) ==
            STATUS_OK) &&
           may_go(supervisor, size)) {
        const status_t status =
            message_ring_take(&spacecraft->released, spacecraft->packet, sizeof spacecraft->packet, &size);
        FSW_ASSERT(status == STATUS_OK);
        supervisor_router_route_released(supervisor, spacecraft->packet, size);
    }
    if (spacecraft->released.blocks == 0U) { // No request waits.
        (void)memset(spacecraft->full_since_ns, 0, sizeof spacecraft->full_since_ns);
    }
}

uint64_t spacecraft_step(struct supervisor* const supervisor, const uint64_t now_ns)
{
    uint64_t wake_ns = SPACECRAFT_NEVER;
    for (size_t i = 0U; i < BINDINGS; i++) {
        const uint64_t next_ns =
            (bindings[i]->step != NULL) ? bindings[i]->step(supervisor, now_ns) : SPACECRAFT_NEVER;
        wake_ns = (next_ns < wake_ns) ? next_ns : wake_ns;
    }
    route_released(supervisor);
    return wake_ns;
}

void spacecraft_observe(struct supervisor* const supervisor, const pus_tm_t* const tm,
                        const uint8_t* const packet, const size_t size)
{
    // The known structures come first, because the cache reads this report by them.
    follow_configuration(supervisor, tm->apid);
    supervisor_telemetry_cache_observe(&supervisor->spacecraft.cache, tm);
    for (size_t i = 0U; i < BINDINGS; i++) {
        if (bindings[i]->observe != NULL) {
            bindings[i]->observe(supervisor, tm, packet, size);
        }
    }
}
