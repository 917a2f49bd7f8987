// SPDX-License-Identifier: Apache-2.0
// Sends reports to ground. Reports that cannot be sent to `communication` now wait, by class; if there is no
// room, they are dropped and counted.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"

#define AWAY_NS 1000000000ULL ///< If no report was sent for this time, senders stop waiting.

/// True if `communication` can receive packets. Packets that are sent while its process is dead, or before
/// its first report in a new life, are lost without notice.
static bool is_there(const supervisor_t* const supervisor)
{
    const mission_subsystem_t* const one =
        descriptor_mission_find_subsystem(supervisor->mission, COMMUNICATION_APID);
    return (one != NULL) &&
           supervisor_registry_is_there(&supervisor->registry[one - supervisor->mission->subsystems]);
}

static status_t send_by_class(supervisor_t* const supervisor, const pus_class_t class,
                              const uint8_t* const packet, const size_t size)
{
    message_endpoint_t* const endpoint = supervisor->config.endpoint;
    if (!is_there(supervisor)) {
        return STATUS_FULL;
    }
    return (class == PUS_CLASS_FIRM) ? message_send(endpoint, COMMUNICATION_APID, packet, size)
                                     : message_send_plain(endpoint, COMMUNICATION_APID, packet, size);
}

static bool is_open_for(const supervisor_t* const supervisor, const pus_class_t class)
{
    const message_endpoint_t* const endpoint = supervisor->config.endpoint;
    return is_there(supervisor) &&
           ((class == PUS_CLASS_FIRM) ? message_credit(endpoint, COMMUNICATION_APID)
                                      : message_credit_plain(endpoint, COMMUNICATION_APID)) > 0U;
}

void supervisor_ground_flush(supervisor_t* const supervisor)
{
    ground_backlog_t* const backlog = &supervisor->ground_backlog;
    ground_report_t report;
    while (is_open_for(supervisor, PUS_CLASS_FIRM) &&
           supervisor_ground_backlog_next(backlog, is_open_for(supervisor, PUS_CLASS_PLAIN), &report) &&
           (send_by_class(supervisor, report.class, report.packet, report.size) != STATUS_FULL)) {
        supervisor_ground_backlog_sent(backlog, &report);
        supervisor->ground_moved_ns = supervisor->now_ns;
    }
    if (supervisor_ground_backlog_is_empty(backlog)) {
        supervisor->is_ground_behind = false;
        supervisor->ground_moved_ns  = supervisor->now_ns;
    }
}

bool supervisor_ground_accepts(const supervisor_t* const supervisor, const pus_class_t class,
                               const size_t size)
{
    const bool has_stalled = (supervisor->now_ns - supervisor->ground_moved_ns) > AWAY_NS;
    return has_stalled || supervisor_ground_backlog_accepts(&supervisor->ground_backlog, class, size) ||
           (supervisor_ground_backlog_is_empty(&supervisor->ground_backlog) &&
            is_open_for(supervisor, class));
}

bool supervisor_ground_is_waiting(const supervisor_t* const supervisor)
{
    return !supervisor_ground_backlog_is_empty(&supervisor->ground_backlog) ||
           !is_open_for(supervisor, PUS_CLASS_PLAIN);
}

bool supervisor_ground_takes_requests(const supervisor_t* const supervisor)
{
    return supervisor_ground_backlog_takes_requests(&supervisor->ground_backlog);
}

static void count_dropped(supervisor_t* const supervisor, const pus_class_t class)
{
    supervisor_ground_t* const ground = &supervisor->ground;
    ground->dropped_firm += (class == PUS_CLASS_FIRM) ? 1U : 0U;
    ground->dropped_plain += (class == PUS_CLASS_PLAIN) ? 1U : 0U;
    ground->dropped_bulk += (class == PUS_CLASS_BULK) ? 1U : 0U;
    if (!supervisor->is_ground_behind) {
        supervisor->is_ground_behind          = true;
        supervisor->is_ground_loss_unreported = true;
    }
}

void supervisor_ground_report(supervisor_t* const supervisor)
{
    if (supervisor->is_ground_loss_unreported) { // Raised here, because no report is being sent now.
        supervisor->is_ground_loss_unreported = false;
        (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_GROUND_BEHIND, NULL, 0U);
    }
}

static void wait_for_ground(supervisor_t* const supervisor, const uint16_t apid, const uint8_t* const packet,
                            const size_t size, uint8_t* const block)
{
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, apid);
    FSW_ASSERT(entry != NULL); // Routing has checked that the sender is known.
    const uint8_t source = (uint8_t)(entry - supervisor->registry);
    if (supervisor_ground_backlog_put(&supervisor->ground_backlog, source, packet, size, block) !=
        STATUS_OK) {
        count_dropped(supervisor, pus_class_of(packet, size)); // The dropped packet is still in the log.
    }
}

void supervisor_ground_send(supervisor_t* const supervisor, const uint16_t apid, const uint8_t* const packet,
                            const size_t size, uint8_t* const block)
{
    // While reports wait, a new one joins them, so that the order is kept.
    if (!supervisor_ground_backlog_is_empty(&supervisor->ground_backlog) ||
        (send_by_class(supervisor, pus_class_of(packet, size), packet, size) == STATUS_FULL)) {
        wait_for_ground(supervisor, apid, packet, size, block);
    }
}

void supervisor_ground_update(supervisor_t* const supervisor)
{
    const ground_backlog_t* const backlog = &supervisor->ground_backlog;
    supervisor_ground_t* const ground     = &supervisor->ground;
    ground->waiting_firm  = GROUND_FIRM_OCTETS - supervisor_ground_backlog_room(backlog, PUS_CLASS_FIRM);
    ground->waiting_plain = GROUND_PLAIN_OCTETS - supervisor_ground_backlog_room(backlog, PUS_CLASS_PLAIN);
    ground->waiting_bulk  = GROUND_BULK_OCTETS - supervisor_ground_backlog_room(backlog, PUS_CLASS_BULK);
    ground->block_peak    = 0U;
    ground->block_refused = 0U;
    for (size_t i = 0U; i < GROUND_SIZES; i++) {
        ground->block_peak = (uint16_t)(ground->block_peak + backlog->blocks.pools[i].stats.peak);
        ground->block_refused += backlog->blocks.pools[i].stats.refused;
    }
}

void supervisor_ground_keep(supervisor_t* const supervisor)
{
    message_ring_t* const kept = &supervisor->ground_kept;
    message_ring_init(kept, supervisor->ground_storage, sizeof supervisor->ground_storage);
    if (!supervisor_ground_backlog_is_empty(&supervisor->ground_backlog)) {
        supervisor_ground_backlog_copy(&supervisor->ground_backlog, kept);
    }
}

void supervisor_ground_resume(supervisor_t* const supervisor)
{
    size_t size = 0U;
    while (message_ring_take(&supervisor->ground_kept, supervisor->packet, sizeof supervisor->packet,
                             &size) == STATUS_OK) {
        pus_tm_t tm;
        pus_failure_t failure;
        if ((pus_tm_decode(supervisor->packet, size, &tm, &failure) == STATUS_OK) &&
            (supervisor_registry_find(supervisor, tm.apid) != NULL)) {
            wait_for_ground(supervisor, tm.apid, supervisor->packet, size, NULL);
        }
    }
}

status_t supervisor_router_send_time(void* const context, const uint8_t* const packet, const size_t size)
{
    supervisor_t* const supervisor = (supervisor_t*)context;
    if (supervisor_ground_is_waiting(supervisor) ||
        (message_send_plain(supervisor->config.endpoint, COMMUNICATION_APID, packet, size) != STATUS_OK)) {
        return STATUS_FULL; // Waiting reports must be sent first.
    }
    supervisor_router_log(supervisor, packet, size);
    return STATUS_OK;
}

status_t supervisor_router_send_stored(void* const context, const uint8_t virtual_channel,
                                       const uint8_t* const packet, const size_t size)
{
    (void)virtual_channel; // Not used, because there is only one connection to ground.
    return supervisor_router_send_time(context, packet, size);
}
