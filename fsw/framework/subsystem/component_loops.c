// SPDX-License-Identifier: Apache-2.0
// Loops of services beside the component's own: each with its rate, its priority and its mailbox.
#include "fsw/framework/subsystem/component_internal.h"

#include "fsw/framework/base/assertion.h"
#include "fsw/framework/base/octets.h"

static void lock(osal_mutex_t* const mutex)
{
    (void)osal_mutex_lock(mutex); // A holder that dies takes this process with it.
}

void component_init_loops(component_t* const component)
{
    status_t status = osal_mutex_create(&component->loop_guard, false);
    for (uint8_t i = 0U; i < COMPONENT_LOOPS; i++) {
        component_loop_t* const loop = &component->loops[i];
        octet_ring_init(&loop->mailbox, loop->storage, sizeof loop->storage);
        status = (status == STATUS_OK) ? osal_mutex_create(&loop->mutex, false) : status;
    }
    FSW_ASSERT(status == STATUS_OK);
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
    }
    component->loop_count = configuration->loop_count;
    osal_mutex_unlock(&component->loop_guard);
}

void component_end_loops(component_t* const component)
{
    lock(&component->loop_guard);
    for (uint16_t i = 0U; i < component->loop_count; i++) {
        component_loop_t* const loop = &component->loops[i];
        loop->period_ns              = 0U;
        loop->priority               = 0U;
        lock(&loop->mutex);
        pus_hk_count_lost(&component->housekeeping, loop->mailbox.blocks + loop->lost);
        loop->lost = 0U;
        octet_ring_init(&loop->mailbox, loop->storage, sizeof loop->storage);
        osal_mutex_unlock(&loop->mutex);
    }
    component->loop_count = 0U;
    osal_mutex_unlock(&component->loop_guard);
}

/// A report, whose values lie behind the room for its header, goes into the mailbox of its loop; what has no
/// room there is counted.
static void post(void* const context, const uint16_t id, const uint64_t now_ns, const uint8_t* const values,
                 const size_t size)
{
    component_loop_t* const loop = (component_loop_t*)context;
    octet_writer_t writer        = octet_writer(loop->report, COMPONENT_LOOP_HEADER);
    octet_write_u16(&writer, id);
    octet_write_u64(&writer, now_ns);
    FSW_ASSERT((writer.position == COMPONENT_LOOP_HEADER) && (values == &loop->report[writer.position]));
    lock(&loop->mutex);
    const status_t status = octet_ring_put(&loop->mailbox, loop->report, COMPONENT_LOOP_HEADER + size);
    loop->lost += (status == STATUS_OK) ? 0U : 1U;
    osal_mutex_unlock(&loop->mutex);
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
            const pus_hk_outlet_t outlet = {
                .context = loop, .put = post, .values = &loop->report[COMPONENT_LOOP_HEADER]};
            loop->cycle = cycle;
            pus_hk_loop_step(&component->housekeeping, (uint8_t)(index + 1U), now_ns, cycle, &outlet);
        }
    }
    osal_mutex_unlock(&component->loop_guard);
    return wake_ns;
}

uint8_t component_loop_priority(component_t* const component, const uint8_t index)
{
    FSW_ASSERT((component != NULL) && (index < COMPONENT_LOOPS));
    lock(&component->loop_guard);
    const uint8_t priority = component->loops[index].priority;
    osal_mutex_unlock(&component->loop_guard);
    return priority;
}

/// The oldest report of a mailbox into the component's buffer; 0 when there is none.
static size_t take(component_t* const component, component_loop_t* const loop)
{
    size_t size = 0U;
    lock(&loop->mutex);
    const status_t status =
        octet_ring_take(&loop->mailbox, component->loop_report, sizeof component->loop_report, &size);
    pus_hk_count_lost(&component->housekeeping, loop->lost);
    loop->lost = 0U;
    osal_mutex_unlock(&loop->mutex);
    FSW_ASSERT((status == STATUS_OK) || (status == STATUS_EMPTY));
    return size;
}

void component_empty_mailboxes(component_t* const component)
{
    for (uint16_t i = 0U; i < component->loop_count; i++) {
        size_t size = take(component, &component->loops[i]);
        for (unsigned k = 0U; (size > 0U) && (k < COMPONENT_LOOP_REPORTS); k++) {
            octet_reader_t reader   = octet_reader(component->loop_report, size);
            const uint16_t id       = octet_read_u16(&reader);
            const uint64_t taken_ns = octet_read_u64(&reader);
            FSW_ASSERT(reader.position == COMPONENT_LOOP_HEADER);
            pus_hk_forward(&component->housekeeping, id, taken_ns,
                           &component->loop_report[COMPONENT_LOOP_HEADER], size - COMPONENT_LOOP_HEADER);
            size = take(component, &component->loops[i]);
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
