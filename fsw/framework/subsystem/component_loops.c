// SPDX-License-Identifier: Apache-2.0
// Loops of services beside the component's own: each with its rate, its priority and its mailbox.
#include "fsw/framework/subsystem/component_internal.h"

#include "base/assertion.h"
#include "base/octets.h"

#include <string.h>

#define OFFSET_TIME 2U ///< In the header of an entry of a mailbox, after the structure's id [octets].
#define REPORT 0U      ///< In the place of a structure's id, which is never 0 in a loop: a whole report.

static void lock(osal_mutex_t* const mutex)
{
    (void)osal_mutex_lock(mutex); // A holder that dies takes this process with it.
}

/// What a loop has finished goes into its mailbox behind a header.
static status_t put(component_t* const component, const uint16_t id, const uint64_t time_ns,
                    const uint8_t* const octets, const size_t size)
{
    component_loop_t* const loop = component->present_loop;
    uint8_t header[COMPONENT_LOOP_HEADER];
    octets_put_u16(header, id);
    octets_put_u64(&header[OFFSET_TIME], time_ns);
    lock(&loop->mutex);
    const status_t status = octet_ring_put_parts(&loop->mailbox, header, sizeof header, octets, size);
    osal_mutex_unlock(&loop->mutex);
    return status;
}

/// The port of loop_process: reports without numbers yet. What has no room the process keeps.
static status_t put_report(void* const context, const uint8_t* const packet, const size_t size)
{
    return put((component_t*)context, REPORT, 0U, packet, size);
}

/// Values of housekeeping, which lie in place; what has no room is lost and counted.
static void put_housekeeping(void* const context, const uint16_t id, const uint64_t now_ns,
                             const uint8_t* const values, const size_t size)
{
    component_t* const component = (component_t*)context;
    FSW_ASSERT(id != REPORT);
    if (put(component, id, now_ns, values, size) != STATUS_OK) {
        lock(&component->present_loop->mutex);
        component->present_loop->lost++;
        osal_mutex_unlock(&component->present_loop->mutex);
    }
}

/// The loop that performs a request; null: the component's own.
static component_loop_t* loop_for(component_t* const component, const pus_token_t* const token)
{
    const bool is_test = (token->service == PUS_SERVICE_TEST) && (token->subtype == PUS_TEST_ARE_YOU_ALIVE);
    const bool is_values =
        (token->service == PUS_SERVICE_PARAMETERS) && (token->subtype == PUS_PARAMETERS_REPORT);
    const unsigned wanted =
        (is_test ? DESCRIPTOR_LOOP_TEST : 0U) | (is_values ? DESCRIPTOR_LOOP_PARAMETERS : 0U);
    for (uint16_t i = 0U; i < component->loop_count; i++) {
        if ((component->loops[i].services & wanted) != 0U) {
            return &component->loops[i];
        }
    }
    return NULL;
}

static pus_reply_t take_request(void* const context, const pus_token_t* const token,
                                const uint8_t* const data, const size_t size)
{
    component_t* const component = (component_t*)context;
    component_loop_t* const loop = loop_for(component, token);
    if (loop == NULL) {
        return pus_done();
    }
    FSW_ASSERT(size <= COMPONENT_LOOP_REQUEST_MAX);
    lock(&loop->mutex);
    const status_t status =
        octet_ring_put_parts(&loop->inbox, (const uint8_t*)token, sizeof *token, data, size);
    const uint32_t waiting = loop->inbox.blocks;
    osal_mutex_unlock(&loop->mutex);
    return (status == STATUS_OK) ? pus_started() : pus_refused(PUS_FAILURE_TABLE_FULL, waiting);
}

void component_create_guards(component_t* const component)
{
    status_t status = osal_mutex_create(&component->loop_guard, false);
    FSW_ASSERT(status == STATUS_OK);
    for (uint8_t i = 0U; i < COMPONENT_LOOPS; i++) {
        status = osal_mutex_create(&component->loops[i].mutex, false);
        FSW_ASSERT(status == STATUS_OK);
    }
}

void component_init_loops(component_t* const component, const pus_parameter_port_t* const values)
{
    const pus_port_t port                = {component, put_report};
    const pus_performer_t performer      = {component, take_request};
    const pus_parameter_port_t read_only = {values->context, values->find, values->read, NULL};
    for (uint8_t i = 0U; i < COMPONENT_LOOPS; i++) {
        component_loop_t* const loop = &component->loops[i];
        octet_ring_init(&loop->inbox, loop->inbox_storage, sizeof loop->inbox_storage);
        octet_ring_init(&loop->mailbox, loop->storage, sizeof loop->storage);
    }
    pus_process_init(&component->loop_process, component->descriptor->apid, component->config.mission_epoch_s,
                     &port);
    pus_process_keep_in_order(&component->loop_process, component->loop_kept, sizeof component->loop_kept);
    pus_test_init(&component->loop_test, NULL);
    pus_parameters_init(&component->loop_parameters, &read_only);
    if (component->parameters.definitions != NULL) {
        pus_parameters_define(&component->loop_parameters, component->parameters.definitions);
    }
    component->loop_services[0] = pus_test_service(&component->loop_test);
    component->loop_services[1] = pus_parameters_service(&component->loop_parameters);
    pus_dispatcher_defer(&component->dispatcher, &performer);
}

void component_begin_loops(component_t* const component)
{
    const descriptor_configuration_t* const configuration = component->configuration;
    lock(&component->loop_guard);
    for (uint16_t i = 0U; i < configuration->loop_count; i++) {
        const descriptor_loop_t* const described =
            &component->descriptor->loops[configuration->first_loop + i];
        component_loop_t* const loop = &component->loops[i];
        loop->period_ns              = (uint64_t)described->sampling_us * 1000U;
        loop->first_tick             = component->now_ns / loop->period_ns;
        loop->cycle                  = 0U;
        loop->priority               = described->priority;
        loop->services               = described->services;
    }
    component->loop_count = configuration->loop_count;
    osal_mutex_unlock(&component->loop_guard);
}

/// The oldest request of a loop, performed if the mailbox has room for whatever it brings. False if it waits
/// or there is none.
static bool perform_one(component_t* const component, component_loop_t* const loop, const uint64_t now_ns)
{
    pus_process_t* const process = &component->loop_process;
    const uint32_t lost_before   = process->counters.lost + process->counters.oversized;
    size_t size                  = 0U;
    status_t status              = STATUS_EMPTY;
    pus_token_t token;
    component->present_loop = loop;
    const bool is_free      = (pus_process_flush(process) == STATUS_OK);
    lock(&loop->mutex);
    if (is_free && (octet_ring_room(&loop->mailbox) >= COMPONENT_MAILBOX_RESERVE)) {
        status =
            octet_ring_take(&loop->inbox, component->loop_scratch, sizeof component->loop_scratch, &size);
    }
    osal_mutex_unlock(&loop->mutex);
    if (status != STATUS_OK) {
        return false;
    }
    (void)memcpy(&token, component->loop_scratch, sizeof token);
    const unsigned index = (token.service == PUS_SERVICE_TEST) ? 0U : 1U;
    pus_perform(process, &component->loop_services[index], &token, &component->loop_scratch[sizeof token],
                size - sizeof token, now_ns);
    lock(&loop->mutex);
    loop->reports_lost += (process->counters.lost + process->counters.oversized) - lost_before;
    osal_mutex_unlock(&loop->mutex);
    return true;
}

/// Send the oldest that a loop has finished. False if there is none.
static bool forward_one(component_t* const component, component_loop_t* const loop, const bool has_ended)
{
    size_t size = 0U;
    lock(&loop->mutex);
    const status_t status =
        octet_ring_take(&loop->mailbox, component->loop_octets, sizeof component->loop_octets, &size);
    pus_hk_count_lost(&component->housekeeping, loop->lost);
    component->loop_reports_lost += loop->reports_lost;
    loop->lost         = 0U;
    loop->reports_lost = 0U;
    osal_mutex_unlock(&loop->mutex);
    if (status != STATUS_OK) {
        FSW_ASSERT(status == STATUS_EMPTY);
        return false;
    }
    FSW_ASSERT(size >= COMPONENT_LOOP_HEADER);
    const uint16_t id           = octets_u16_at(component->loop_octets);
    const uint64_t taken_ns     = octets_u64_at(&component->loop_octets[OFFSET_TIME]);
    const uint8_t* const octets = &component->loop_octets[COMPONENT_LOOP_HEADER];
    if (id == REPORT) {
        (void)pus_tm_forward(&component->process, octets, size - COMPONENT_LOOP_HEADER);
    } else if (has_ended) {
        pus_hk_count_lost(&component->housekeeping, 1U);
    } else {
        pus_hk_forward(&component->housekeeping, id, taken_ns, octets, size - COMPONENT_LOOP_HEADER);
    }
    return true;
}

void component_end_loops(component_t* const component)
{
    lock(&component->loop_guard);
    for (uint16_t i = 0U; i < component->loop_count; i++) {
        component_loop_t* const loop = &component->loops[i];
        bool has_more                = true;
        while (has_more) {
            has_more = forward_one(component, loop, true);
            has_more = perform_one(component, loop, component->now_ns) || has_more;
        }
        loop->period_ns = 0U;
        loop->priority  = 0U;
        loop->services  = 0U;
    }
    component->loop_count = 0U;
    osal_mutex_unlock(&component->loop_guard);
}

static void run_loop(component_t* const component, const uint8_t index, const uint64_t now_ns)
{
    component_loop_t* const loop = &component->loops[index];
    const pus_hk_outlet_t outlet = {
        .context = component, .put = put_housekeeping, .values = component->loop_scratch};
    component->present_loop = loop;
    pus_hk_loop_step(&component->housekeeping, (uint8_t)(index + 1U), now_ns, loop->cycle, &outlet);
    for (unsigned i = 0U; (i < COMPONENT_LOOP_REQUESTS) && perform_one(component, loop, now_ns); i++) {
    }
}

uint64_t component_loop_step(component_t* const component, const uint8_t index, const uint64_t now_ns)
{
    FSW_ASSERT((component != NULL) && (index < COMPONENT_LOOPS));
    component_loop_t* const loop = &component->loops[index];
    uint64_t wake_ns             = COMPONENT_NEVER;
    lock(&component->loop_guard);
    if (loop->period_ns > 0U) {
        const uint64_t tick  = now_ns / loop->period_ns;
        const uint32_t cycle = (uint32_t)(tick - loop->first_tick);
        wake_ns              = (tick + 1U) * loop->period_ns;
        if (cycle != loop->cycle) {
            loop->cycle = cycle;
            run_loop(component, index, now_ns);
        }
    }
    osal_mutex_unlock(&component->loop_guard);
    return wake_ns;
}

uint8_t component_priority(const component_t* const component)
{
    FSW_ASSERT(component != NULL);
    const subsystem_descriptor_t* const descriptor  = subsystem_descriptor(component);
    const descriptor_configuration_t* const applied = subsystem_configuration(component);
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

uint8_t component_loop_priority(component_t* const component, const uint8_t index)
{
    FSW_ASSERT((component != NULL) && (index < COMPONENT_LOOPS));
    lock(&component->loop_guard);
    const uint8_t priority = component->loops[index].priority;
    osal_mutex_unlock(&component->loop_guard);
    return priority;
}

void component_empty_mailboxes(component_t* const component)
{
    for (uint16_t i = 0U; i < component->loop_count; i++) {
        component_loop_t* const loop = &component->loops[i];
        for (unsigned k = 0U; (k < COMPONENT_LOOP_REPORTS) && forward_one(component, loop, false); k++) {
        }
    }
}

uint64_t component_step_loops(component_t* const component)
{
    uint64_t wake_ns = COMPONENT_NEVER;
    for (uint8_t i = 0U; (i < component->loop_count) && !component->config.has_loop_tasks; i++) {
        const uint64_t loop_wake_ns = component_loop_step(component, i, component->now_ns);
        wake_ns                     = (loop_wake_ns < wake_ns) ? loop_wake_ns : wake_ns;
    }
    return wake_ns;
}
