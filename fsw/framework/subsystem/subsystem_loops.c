// SPDX-License-Identifier: Apache-2.0
// Loops of services that run in addition to the main loop. Each has its own rate, priority and mailbox.
#include "fsw/framework/subsystem/subsystem_internal.h"

#include "base/assertion.h"
#include "base/octets.h"

#include <string.h>

/// Offset of the time in the header of a mailbox entry, after the structure's id [octets].
#define OFFSET_TIME 2U
/// Value instead of a structure's id (never 0 in a loop), if the entry is a complete report.
#define REPORT 0U

static void lock(osal_mutex_t* const mutex)
{
    (void)osal_mutex_lock(mutex); // The owner of the mutex belongs to this process, so it cannot die alone.
}

/// Put a finished report of the present loop into its mailbox, preceded by a header.
static status_t put(subsystem_t* const subsystem, const uint16_t id, const uint64_t time_ns,
                    const uint8_t* const octets, const size_t size)
{
    subsystem_loop_t* const loop = subsystem->present_loop;
    uint8_t header[SUBSYSTEM_LOOP_HEADER];
    octets_put_u16(header, id);
    octets_put_u64(&header[OFFSET_TIME], time_ns);
    lock(&loop->mutex);
    const status_t status = message_ring_put_parts(&loop->mailbox, header, sizeof header, octets, size);
    osal_mutex_unlock(&loop->mutex);
    return status;
}

/// Port of loop_process; its reports have no sequence numbers yet. The process keeps reports for which
/// there is no room.
static status_t put_report(void* const context, const uint8_t* const packet, const size_t size)
{
    return put((subsystem_t*)context, REPORT, 0U, packet, size);
}

/// Put the values of a housekeeping report into the mailbox; if there is no room, the report is lost and
/// counted.
static void put_housekeeping(void* const context, const uint16_t id, const uint64_t now_ns,
                             const uint8_t* const values, const size_t size)
{
    subsystem_t* const subsystem = (subsystem_t*)context;
    FSW_ASSERT(id != REPORT);
    if (put(subsystem, id, now_ns, values, size) != STATUS_OK) {
        lock(&subsystem->present_loop->mutex);
        subsystem->present_loop->lost++;
        osal_mutex_unlock(&subsystem->present_loop->mutex);
    }
}

/// Returns the loop of services that performs a request; null if the main loop performs it.
static subsystem_loop_t* loop_for(subsystem_t* const subsystem, const pus_token_t* const token)
{
    const bool is_test = (token->service == PUS_SERVICE_TEST) && (token->subtype == PUS_TEST_ARE_YOU_ALIVE);
    const bool is_values =
        (token->service == PUS_SERVICE_PARAMETERS) && (token->subtype == PUS_PARAMETERS_REPORT);
    const unsigned wanted =
        (is_test ? DESCRIPTOR_LOOP_TEST : 0U) | (is_values ? DESCRIPTOR_LOOP_PARAMETERS : 0U);
    for (uint16_t i = 0U; i < subsystem->loop_count; i++) {
        if ((subsystem->loops[i].services & wanted) != 0U) {
            return &subsystem->loops[i];
        }
    }
    return NULL;
}

static pus_reply_t take_request(void* const context, const pus_token_t* const token,
                                const uint8_t* const data, const size_t size)
{
    subsystem_t* const subsystem = (subsystem_t*)context;
    subsystem_loop_t* const loop = loop_for(subsystem, token);
    if (loop == NULL) {
        return pus_done();
    }
    FSW_ASSERT(size <= SUBSYSTEM_LOOP_REQUEST_MAX);
    lock(&loop->mutex);
    const status_t status =
        message_ring_put_parts(&loop->inbox, (const uint8_t*)token, sizeof *token, data, size);
    const uint32_t waiting = loop->inbox.blocks;
    osal_mutex_unlock(&loop->mutex);
    return (status == STATUS_OK) ? pus_started() : pus_refused(PUS_FAILURE_TABLE_FULL, waiting);
}

void subsystem_create_mutexes(subsystem_t* const subsystem)
{
    status_t status = osal_mutex_create(&subsystem->loop_mutex, false);
    FSW_ASSERT(status == STATUS_OK);
    for (uint8_t i = 0U; i < SUBSYSTEM_LOOPS; i++) {
        status = osal_mutex_create(&subsystem->loops[i].mutex, false);
        FSW_ASSERT(status == STATUS_OK);
    }
}

void subsystem_init_loops(subsystem_t* const subsystem, const pus_parameter_port_t* const values)
{
    const pus_port_t port                = {subsystem, put_report};
    const pus_performer_t performer      = {subsystem, take_request};
    const pus_parameter_port_t read_only = {values->context, values->find, values->read, NULL};
    for (uint8_t i = 0U; i < SUBSYSTEM_LOOPS; i++) {
        subsystem_loop_t* const loop = &subsystem->loops[i];
        message_ring_init(&loop->inbox, loop->inbox_storage, sizeof loop->inbox_storage);
        message_ring_init(&loop->mailbox, loop->storage, sizeof loop->storage);
    }
    pus_app_process_init(&subsystem->loop_process, subsystem->descriptor->apid,
                         subsystem->config.mission_epoch_s, &port);
    pus_app_process_keep_in_order(&subsystem->loop_process, subsystem->loop_kept,
                                  sizeof subsystem->loop_kept);
    pus_test_init(&subsystem->loop_test, NULL);
    pus_parameters_init(&subsystem->loop_parameters, &read_only);
    if (subsystem->parameters.definer.define != NULL) {
        pus_parameters_define(&subsystem->loop_parameters, &subsystem->parameters.definer);
    }
    subsystem->loop_services[0] = pus_test_service(&subsystem->loop_test);
    subsystem->loop_services[1] = pus_parameters_service(&subsystem->loop_parameters);
    pus_dispatcher_defer(&subsystem->dispatcher, &performer);
}

void subsystem_begin_loops(subsystem_t* const subsystem)
{
    const descriptor_configuration_t* const configuration = subsystem->configuration;
    lock(&subsystem->loop_mutex);
    for (uint16_t i = 0U; i < configuration->loop_count; i++) {
        const descriptor_loop_t* const described =
            &subsystem->descriptor->loops[configuration->first_loop + i];
        subsystem_loop_t* const loop = &subsystem->loops[i];
        loop->period_ns              = (uint64_t)described->sampling_us * 1000U;
        loop->first_tick             = subsystem->now_ns / loop->period_ns;
        loop->cycle                  = 0U;
        loop->priority               = described->priority;
        loop->services               = described->services;
    }
    subsystem->loop_count = configuration->loop_count;
    osal_mutex_unlock(&subsystem->loop_mutex);
}

/// Perform the oldest request of a loop, if the mailbox has room for all its reports. False if there is no
/// request or no room.
static bool perform_request(subsystem_t* const subsystem, subsystem_loop_t* const loop, const uint64_t now_ns)
{
    pus_app_process_t* const process = &subsystem->loop_process;
    const uint32_t lost_before       = process->counters.lost + process->counters.oversized;
    size_t size                      = 0U;
    status_t status                  = STATUS_EMPTY;
    pus_token_t token;
    subsystem->present_loop = loop;
    const bool is_free      = (pus_app_process_flush(process) == STATUS_OK);
    lock(&loop->mutex);
    if (is_free && (message_ring_room(&loop->mailbox) >= SUBSYSTEM_MAILBOX_RESERVE)) {
        status =
            message_ring_take(&loop->inbox, subsystem->loop_scratch, sizeof subsystem->loop_scratch, &size);
    }
    osal_mutex_unlock(&loop->mutex);
    if (status != STATUS_OK) {
        return false;
    }
    (void)memcpy(&token, subsystem->loop_scratch, sizeof token);
    const unsigned index = (token.service == PUS_SERVICE_TEST) ? 0U : 1U;
    pus_perform(process, &subsystem->loop_services[index], &token, &subsystem->loop_scratch[sizeof token],
                size - sizeof token, now_ns);
    lock(&loop->mutex);
    loop->reports_lost += (process->counters.lost + process->counters.oversized) - lost_before;
    osal_mutex_unlock(&loop->mutex);
    return true;
}

/// Send the oldest report that a loop has finished. False if there is none.
static bool forward_report(subsystem_t* const subsystem, subsystem_loop_t* const loop, const bool has_ended)
{
    size_t size = 0U;
    lock(&loop->mutex);
    const status_t status =
        message_ring_take(&loop->mailbox, subsystem->loop_octets, sizeof subsystem->loop_octets, &size);
    pus_hk_count_lost(&subsystem->housekeeping, loop->lost);
    subsystem->loop_reports_lost += loop->reports_lost;
    loop->lost         = 0U;
    loop->reports_lost = 0U;
    osal_mutex_unlock(&loop->mutex);
    if (status != STATUS_OK) {
        FSW_ASSERT(status == STATUS_EMPTY);
        return false;
    }
    FSW_ASSERT(size >= SUBSYSTEM_LOOP_HEADER);
    const uint16_t id           = octets_u16_at(subsystem->loop_octets);
    const uint64_t taken_ns     = octets_u64_at(&subsystem->loop_octets[OFFSET_TIME]);
    const uint8_t* const octets = &subsystem->loop_octets[SUBSYSTEM_LOOP_HEADER];
    if (id == REPORT) {
        (void)pus_tm_forward(&subsystem->process, octets, size - SUBSYSTEM_LOOP_HEADER);
    } else if (has_ended) {
        pus_hk_count_lost(&subsystem->housekeeping, 1U);
    } else {
        pus_hk_forward(&subsystem->housekeeping, id, taken_ns, octets, size - SUBSYSTEM_LOOP_HEADER);
    }
    return true;
}

void subsystem_end_loops(subsystem_t* const subsystem)
{
    lock(&subsystem->loop_mutex);
    for (uint16_t i = 0U; i < subsystem->loop_count; i++) {
        subsystem_loop_t* const loop = &subsystem->loops[i];
        bool has_more                = true;
        while (has_more) {
            has_more = forward_report(subsystem, loop, true);
            has_more = perform_request(subsystem, loop, subsystem->now_ns) || has_more;
        }
        loop->period_ns = 0U;
        loop->priority  = 0U;
        loop->services  = 0U;
    }
    subsystem->loop_count = 0U;
    osal_mutex_unlock(&subsystem->loop_mutex);
}

static void run_loop(subsystem_t* const subsystem, const uint8_t index, const uint64_t now_ns)
{
    subsystem_loop_t* const loop = &subsystem->loops[index];
    const pus_hk_outlet_t outlet = {
        .context = subsystem, .put = put_housekeeping, .values = subsystem->loop_scratch};
    subsystem->present_loop = loop;
    pus_hk_loop_step(&subsystem->housekeeping, (uint8_t)(index + 1U), now_ns, loop->cycle, &outlet);
    for (unsigned i = 0U; (i < SUBSYSTEM_LOOP_REQUESTS) && perform_request(subsystem, loop, now_ns); i++) {
    }
}

uint64_t subsystem_loop_step(subsystem_t* const subsystem, const uint8_t index, const uint64_t now_ns)
{
    FSW_ASSERT((subsystem != NULL) && (index < SUBSYSTEM_LOOPS));
    subsystem_loop_t* const loop = &subsystem->loops[index];
    uint64_t wake_ns             = SUBSYSTEM_NEVER;
    lock(&subsystem->loop_mutex);
    if (loop->period_ns > 0U) {
        const uint64_t tick  = now_ns / loop->period_ns;
        const uint32_t cycle = (uint32_t)(tick - loop->first_tick);
        wake_ns              = (tick + 1U) * loop->period_ns;
        if (cycle != loop->cycle) {
            loop->cycle = cycle;
            run_loop(subsystem, index, now_ns);
        }
    }
    osal_mutex_unlock(&subsystem->loop_mutex);
    return wake_ns;
}

uint8_t subsystem_component_priority(const subsystem_t* const subsystem)
{
    FSW_ASSERT(subsystem != NULL);
    const subsystem_descriptor_t* const descriptor  = subsystem_descriptor(subsystem);
    const descriptor_configuration_t* const applied = subsystem_configuration(subsystem);
    uint8_t highest                                 = 0U;
    if (applied != NULL) {
        return applied->priority;
    }
    for (uint16_t i = 0U; i < descriptor->configuration_count; i++) {
        const uint8_t priority = descriptor->configurations[i].priority;
        highest                = (priority > highest) ? priority : highest;
    }
    return highest;
}

uint8_t subsystem_loop_priority(subsystem_t* const subsystem, const uint8_t index)
{
    FSW_ASSERT((subsystem != NULL) && (index < SUBSYSTEM_LOOPS));
    lock(&subsystem->loop_mutex);
    const uint8_t priority = subsystem->loops[index].priority;
    osal_mutex_unlock(&subsystem->loop_mutex);
    return priority;
}

void subsystem_empty_mailboxes(subsystem_t* const subsystem)
{
    for (uint16_t i = 0U; i < subsystem->loop_count; i++) {
        subsystem_loop_t* const loop = &subsystem->loops[i];
        for (unsigned k = 0U; (k < SUBSYSTEM_LOOP_REPORTS) && forward_report(subsystem, loop, false); k++) {
        }
    }
}

uint64_t subsystem_step_loops(subsystem_t* const subsystem)
{
    uint64_t wake_ns = SUBSYSTEM_NEVER;
    for (uint8_t i = 0U; (i < subsystem->loop_count) && !subsystem->config.has_loop_tasks; i++) {
        const uint64_t loop_wake_ns = subsystem_loop_step(subsystem, i, subsystem->now_ns);
        wake_ns                     = (loop_wake_ns < wake_ns) ? loop_wake_ns : wake_ns;
    }
    return wake_ns;
}
