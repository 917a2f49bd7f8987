// SPDX-License-Identifier: Apache-2.0
// Connects ST[15] to the supervisor: passes every report to the packet stores, and sends retrieved packets to
// ground after the reports that already wait. At first there are no packet stores; telecommands create them.
// Also connects ST[09].
#include "fsw/supervisor/services/spacecraft_services.h"

#include "fsw/supervisor/supervisor_internal.h"

// ---- A program without media for packets: every store is refused ----

static status_t read_nothing(void* const context, const uint64_t offset, uint8_t* const octets,
                             const size_t size)
{
    (void)context;
    (void)offset;
    (void)octets;
    (void)size;
    return STATUS_TRUNCATED;
}

static status_t write_nothing(void* const context, const uint64_t offset, const uint8_t* const octets,
                              const size_t size)
{
    (void)context;
    (void)offset;
    (void)octets;
    (void)size;
    return STATUS_FULL;
}

static status_t sync_nothing(void* const context)
{
    (void)context;
    return STATUS_OK;
}

static status_t size_of_nothing(void* const context, uint64_t* const out_size)
{
    (void)context;
    *out_size = 0U;
    return STATUS_OK;
}

static status_t resize_nothing(void* const context, const uint64_t size)
{
    (void)context;
    return (size == 0U) ? STATUS_OK : STATUS_FULL;
}

// ---- The service ----

static pus_service_t open_storage(supervisor_t* const supervisor)
{
    spacecraft_storage_t* const storage = &supervisor->spacecraft.storage;
    const medium_t nowhere              = {.read   = read_nothing,
                                           .write  = write_nothing,
                                           .sync   = sync_nothing,
                                           .size   = size_of_nothing,
                                           .resize = resize_nothing};
    for (uint8_t i = 0U; i < SPACECRAFT_STORES; i++) {
        storage->media[i] =
            (supervisor->config.store_media != NULL) ? supervisor->config.store_media[i] : nowhere;
    }
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        storage->apids[i] = supervisor->mission->subsystems[i].apid;
    }
    const pus_storage_config_t config = {
        .process         = subsystem_process(&supervisor->subsystem),
        .media           = storage->media,
        .store_count     = (uint8_t)spacecraft_capacity(supervisor, PUS_SERVICE_STORAGE, SPACECRAFT_STORES),
        .blocks_of_store = SPACECRAFT_STORE_BLOCKS,
        .blocks          = storage->blocks,
        .entries_of_selection   = SPACECRAFT_STORE_ENTRIES,
        .entries                = storage->entries,
        .candidate              = storage->candidate,
        .apids                  = storage->apids,
        .apid_count             = supervisor->mission->subsystem_count,
        .virtual_channels       = SPACECRAFT_VIRTUAL_CHANNELS,
        .port                   = {supervisor, supervisor_router_send_stored},
        .packets_per_step       = SPACECRAFT_RETRIEVAL_PACKETS,
        .octets_per_step        = SPACECRAFT_RETRIEVAL_OCTETS,
        .sync_interval_ns       = SPACECRAFT_STORE_INTERVAL_NS,
        .checkpoint_interval_ns = SPACECRAFT_STORE_INTERVAL_NS,
        .persistence            = spacecraft_persistence(supervisor)};
    storage->is_started = false;
    pus_storage_init(&storage->service, &config);
    return pus_storage_service(&storage->service);
}

static status_t restore_storage(supervisor_t* const supervisor, const uint32_t key,
                                const uint8_t* const octets, const size_t size)
{
    return pus_storage_restore(&supervisor->spacecraft.storage.service, key, octets, size);
}

static status_t start_storage(supervisor_t* const supervisor)
{
    spacecraft_storage_t* const storage = &supervisor->spacecraft.storage;
    storage->is_started                 = true;
    return pus_storage_start(&storage->service);
}

static uint64_t step_storage(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_storage_t* const service = &supervisor->spacecraft.storage.service;
    pus_storage_step(service, now_ns);
    const uint64_t due_ns = pus_storage_due_ns(service, now_ns);
    return (due_ns <= now_ns) ? (now_ns + SPACECRAFT_RETRY_NS) : due_ns;
}

static void observe_report(supervisor_t* const supervisor, const pus_tm_t* const tm,
                           const uint8_t* const packet, const size_t size)
{
    spacecraft_storage_t* const storage = &supervisor->spacecraft.storage;
    if (storage->is_started) { // Before the start, no store is known.
        pus_storage_observe(&storage->service, tm, packet, size, supervisor->now_ns);
    }
}

const spacecraft_binding_t spacecraft_storage = {.type    = PUS_SERVICE_STORAGE,
                                                 .open    = open_storage,
                                                 .restore = restore_storage,
                                                 .start   = start_storage,
                                                 .step    = step_storage,
                                                 .observe = observe_report};

// ---- ST[09] ----

static pus_service_t open_time(supervisor_t* const supervisor)
{
    pus_time_t* const time         = &supervisor->spacecraft.storage.time;
    const pus_time_config_t config = {.epoch_s     = supervisor->mission->epoch_s,
                                      .format      = (pus_time_format_t)supervisor->mission->time_reports,
                                      .exponent    = PUS_TIME_NO_REPORTS,
                                      .port        = {supervisor, supervisor_router_send_time},
                                      .persistence = spacecraft_persistence(supervisor)};
    pus_time_init(time, &config);
    return pus_time_service(time);
}

static status_t restore_time(supervisor_t* const supervisor, const uint32_t key, const uint8_t* const octets,
                             const size_t size)
{
    return pus_time_restore(&supervisor->spacecraft.storage.time, key, octets, size);
}

static uint64_t step_time(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_time_t* const time = &supervisor->spacecraft.storage.time;
    pus_time_step(time, now_ns);
    const uint64_t due_ns = pus_time_due_ns(time, now_ns);
    return (due_ns <= now_ns) ? (now_ns + SPACECRAFT_RETRY_NS) : due_ns;
}

const spacecraft_binding_t spacecraft_time = {
    .type = PUS_SERVICE_TIME, .open = open_time, .restore = restore_time, .step = step_time};
