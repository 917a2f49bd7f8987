// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/subsystem_host.h"

#include "base/assertion.h"
#include "base/text.h"
#include "fsw/framework/subsystem/fitting.h"
#include "osal/include/osal/console.h"

#include <string.h>

#define LINE_CHARACTERS (DESCRIPTOR_ERROR_CHARACTERS + 64U)

static status_t check(const subsystem_host_t* const host, const subsystem_descriptor_t* const descriptor,
                      text_t* const error)
{
    subsystem_misfit_t misfit = {0U, "", 0U};
    const status_t status = descriptor_check_interface(error, host->path, descriptor, host->interface_hash);
    if ((status == STATUS_OK) && !subsystem_fits(descriptor, host->callbacks, &misfit)) {
        return descriptor_refuse(error, host->path, misfit.line, misfit.reason, misfit.most);
    }
    return status;
}

bool subsystem_host_load(subsystem_host_t* const host, component_runtime_t* const runtime,
                         const uint64_t interface_hash, const subsystem_callbacks_t* const callbacks)
{
    FSW_ASSERT((host != NULL) && (runtime != NULL) && (callbacks != NULL));
    const mission_subsystem_t* const subsystem =
        descriptor_mission_find_subsystem(runtime->mission, runtime->apid);
    FSW_ASSERT(subsystem != NULL);
    host->runtime        = runtime;
    host->in_force       = runtime->own;
    host->interface_hash = interface_hash;
    host->callbacks      = callbacks;
    text_t error         = text_in(runtime->error, sizeof runtime->error);
    if ((descriptor_path_of(&error, runtime->run->mission_path, subsystem, host->path, sizeof host->path) !=
         STATUS_OK) ||
        (check(host, runtime->own, &error) != STATUS_OK)) {
        return false;
    }
    return (component_runtime_open_inbox(runtime, host->inbox, 1U) == STATUS_OK) &&
           (record_store_open(&host->records, runtime, host->slots, SUBSYSTEM_HOST_RECORDS,
                              runtime->clock.mode != OSAL_CLOCK_REAL) == STATUS_OK);
}

/// Print file, line, found value and expected value, which the failure report in telemetry cannot contain.
static void print_refusal(const char* const refusal)
{
    char line[LINE_CHARACTERS];
    text_t text = text_in(line, sizeof line);
    text_add(&text, refusal);
    text_add(&text, " (not reloaded: the descriptor in force stays)");
    osal_console_print_error(line);
}

/// Load the descriptor again for TC[129,6]. If it is refused, the old one stays in force.
static status_t reload(void* const context, const subsystem_descriptor_t** const out_descriptor)
{
    subsystem_host_t* const host                     = (subsystem_host_t*)context;
    const component_descriptors_t* const descriptors = host->runtime->descriptors;
    subsystem_descriptor_t* model                    = NULL;
    char refusal[DESCRIPTOR_ERROR_CHARACTERS];
    text_t error    = text_in(refusal, sizeof refusal);
    status_t status = descriptors->read(descriptors->context, host->path, &model, &error);
    if (status == STATUS_OK) {
        status = check(host, model, &error);
    }
    if (status == STATUS_OK) {
        // The old descriptor provides the memory for the next load.
        descriptors->exchange(descriptors->context, host->in_force);
        host->in_force  = model;
        *out_descriptor = model;
    } else {
        print_refusal(refusal);
    }
    return status;
}

/// Pass a record of an earlier life to the service that has stored it.
static void restore_record(void* const context, const uint8_t table, const uint32_t key,
                           const uint8_t* const octets, const size_t size)
{
    subsystem_host_t* const host = (subsystem_host_t*)context;
    if (subsystem_restore(&host->subsystem, table, key, octets, size) != STATUS_OK) {
        host->records_refused++;
    }
}

void subsystem_host_begin(subsystem_host_t* const host, void* const self, const subsystem_services_t services)
{
    component_runtime_t* const runtime = host->runtime;
    host->persistence =
        (pus_persistence_t){&host->records.journal, journal_put, journal_erase, journal_commit};
    const mission_subsystem_t* const subsystem =
        descriptor_mission_find_subsystem(runtime->mission, runtime->apid);
    const bool is_real              = (runtime->clock.mode == OSAL_CLOCK_REAL);
    const subsystem_config_t config = {
        .device_deadline_ns    = is_real ? ((uint64_t)subsystem->device_deadline_us * 1000U) : 0U,
        .descriptor            = host->in_force,
        .is_descriptor_valid   = true,
        .callbacks             = host->callbacks,
        .self                  = self,
        .mission_epoch_s       = runtime->mission->epoch_s,
        .start_count           = runtime->life,
        .port                  = runtime->uplink,
        .links                 = &runtime->links,
        .link_methods          = runtime->run->link_methods,
        .supervisor_timeout_ns = (uint64_t)subsystem->supervisor_timeout_us * 1000U,
        .status_interval_ns    = SUBSYSTEM_STATUS_INTERVAL_NS,
        .has_loop_tasks        = (runtime->clock.mode == OSAL_CLOCK_REAL),
        .optional              = services,
        .persistence           = &host->persistence,
        .reload                = reload,
        .reload_context        = host};
    subsystem_init(&host->subsystem, &config);
    if (journal_replay(&host->records.journal, restore_record, host) != STATUS_OK) {
        host->records_refused++;
    }
}

/// Copy the first octets of the next block, if it is longer than a packet of this program.
static void keep_head(message_endpoint_t* const endpoint, uint8_t out_head[MESSAGE_HEAD_OCTETS])
{
    const uint8_t* head = NULL;
    uint16_t from       = 0U;
    size_t size         = 0U;
    if ((message_next(endpoint, NULL, &from, &head, &size) == STATUS_OK) && (size > PUS_PACKET_MAX)) {
        (void)memcpy(out_head, head, MESSAGE_HEAD_OCTETS);
    }
}

void subsystem_host_take_in(subsystem_host_t* const host, const uint64_t now_ns)
{
    uint16_t from   = 0U;
    size_t size     = 0U;
    status_t status = STATUS_OK;
    // Credit is processed even while requests are not accepted.
    message_take_control(&host->runtime->endpoint);
    while ((status != STATUS_EMPTY) && subsystem_may_accept(&host->subsystem)) {
        uint8_t head[MESSAGE_HEAD_OCTETS] = {0U};
        keep_head(&host->runtime->endpoint, head);
        status = message_receive(&host->runtime->endpoint, &from, host->packet, sizeof host->packet, &size);
        if ((status == STATUS_OK) && (size > 0U)) {
            subsystem_accept(&host->subsystem, host->packet, size, now_ns);
        } else if (status == STATUS_TOO_LARGE) {
            // The component rejects the head alone, because it is shorter than its length field states.
            subsystem_accept(&host->subsystem, head, sizeof head, now_ns);
        } else {
            // No packet, or an empty one.
        }
    }
}

/// Report lost records as soon as events can be raised. The event is called JOURNAL_DAMAGED in every
/// descriptor.
static void report_damage(subsystem_host_t* const host)
{
    uint8_t octets[JOURNAL_DAMAGE_SIZE];
    if (host->has_reported_damage) {
        return;
    }
    const descriptor_event_t* const event = descriptor_find_event_name(host->in_force, "JOURNAL_DAMAGED");
    if ((event != NULL) && (event->octets == JOURNAL_DAMAGE_SIZE) &&
        journal_report_damage(&host->records.journal, host->records_refused, octets)) {
        (void)subsystem_raise(&host->subsystem, event->id, octets, sizeof octets);
    }
    host->has_reported_damage = true;
}

uint64_t subsystem_host_step(subsystem_host_t* const host, const uint64_t now_ns)
{
    subsystem_host_take_in(host, now_ns);
    const uint64_t wake_ns = subsystem_step(&host->subsystem, now_ns);
    report_damage(host);
    return wake_ns;
}

void subsystem_host_link_datagram(void* const self, const uint8_t* const frame, const size_t size)
{
    subsystem_link_datagram(&((subsystem_host_t*)self)->subsystem, frame, size);
}

void subsystem_host_close(void* const self)
{
    FSW_ASSERT(self != NULL);
    subsystem_host_t* const host = (subsystem_host_t*)self;
    subsystem_release(&host->subsystem);
    record_store_close(&host->records);
    host->runtime->own = host->in_force; // A reload may have replaced the descriptor.
}

static uint64_t step(void* const self, const uint64_t now_ns, const uint32_t octets_due)
{
    (void)octets_due;
    return subsystem_host_step((subsystem_host_t*)self, now_ns);
}

component_instance_t subsystem_host_instance(subsystem_host_t* const host, void* const storage,
                                             const size_t size)
{
    FSW_ASSERT((host != NULL) && (storage != NULL));
    return (component_instance_t){.self          = host,
                                  .step          = step,
                                  .link_datagram = subsystem_host_link_datagram,
                                  .close         = subsystem_host_close,
                                  .component     = &host->subsystem,
                                  .storage       = storage,
                                  .size          = size};
}
