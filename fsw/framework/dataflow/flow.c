// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/dataflow/flow.h"

#include "base/assertion.h"
#include "base/text.h"

#include <string.h>

enum { // Indices of the two queues of SHM and MQUEUE.
    TO_FLIGHT,
    TO_DEVICE
};

static bool is_stream(const flow_t* const flow)
{
    const flow_endnode_kind_t kind = flow->setup.kind;
    return (kind == ENDNODE_TCP) || (kind == ENDNODE_SERIAL) || (kind == ENDNODE_FILE);
}

static uint32_t octets_of(const flow_t* const flow, const unsigned direction)
{
    return (direction == TO_FLIGHT) ? flow->setup.octets_in : flow->setup.octets_out;
}

static const char* name_of(const flow_t* const flow, const unsigned direction)
{
    return (direction == TO_FLIGHT) ? flow->local : flow->peer;
}

// ---- Beginning ----

/// Returns the text that begins with the last colon: ":PORT".
static const char* port_of(const char* const name)
{
    const char* const colon = strrchr(name, ':');
    return (colon != NULL) ? colon : name;
}

static void init_udp(flow_t* const flow, const flow_resolver_t* const resolver)
{
    const flow_setup_t* const setup = &flow->setup;
    (void)text_join(flow->local, sizeof flow->local, (const char* const[]){port_of(setup->name), NULL});
    flow_udp_init(&flow->udp,
                  &(flow_udp_setup_t){.local            = flow->local,
                                      .peer             = setup->name,
                                      .order            = setup->format.order,
                                      .retry_first_ns   = setup->retry_first_ns,
                                      .retry_longest_ns = setup->retry_longest_ns,
                                      .quota            = setup->quota},
                  resolver);
}

static void init_stream(flow_t* const flow, const flow_resolver_t* const resolver)
{
    const flow_setup_t* const setup = &flow->setup;
    flow_stream_init(&flow->stream,
                     &(flow_stream_setup_t){.kind             = setup->kind,
                                            .name             = setup->name,
                                            .format           = setup->format,
                                            .frame            = flow->frame,
                                            .frame_octets     = sizeof flow->frame,
                                            .outbox           = flow->outbox,
                                            .outbox_octets    = sizeof flow->outbox,
                                            .retry_first_ns   = setup->retry_first_ns,
                                            .retry_longest_ns = setup->retry_longest_ns,
                                            .quota            = setup->quota},
                     resolver);
}

static void init_queue(flow_t* const flow, const unsigned direction, const flow_resolver_t* const resolver)
{
    const flow_setup_t* const setup = &flow->setup;
    if (setup->kind == ENDNODE_SHM) {
        flow_shm_init(&flow->shm[direction],
                      &(flow_shm_setup_t){.name             = name_of(flow, direction),
                                          .is_writer        = (direction == TO_DEVICE),
                                          .shape            = {.kind         = FLOW_SHM_QUEUE,
                                                               .value_octets = octets_of(flow, direction),
                                                               .depth        = FLOW_DEPTH},
                                          .order            = setup->format.order,
                                          .retry_first_ns   = setup->retry_first_ns,
                                          .retry_longest_ns = setup->retry_longest_ns,
                                          .quota            = setup->quota},
                      resolver);
    } else {
        flow_mqueue_init(&flow->mqueue[direction],
                         &(flow_mqueue_setup_t){.name             = name_of(flow, direction),
                                                .is_receiver      = (direction == TO_FLIGHT),
                                                .depth            = FLOW_DEPTH,
                                                .message_octets   = octets_of(flow, direction),
                                                .order            = setup->format.order,
                                                .retry_first_ns   = setup->retry_first_ns,
                                                .retry_longest_ns = setup->retry_longest_ns,
                                                .quota            = setup->quota},
                         resolver);
    }
}

static void init_queues(flow_t* const flow, const flow_resolver_t* const resolver)
{
    const char* const name = flow->setup.name;
    (void)text_join(flow->local, sizeof flow->local, (const char* const[]){name, ".in", NULL});
    (void)text_join(flow->peer, sizeof flow->peer, (const char* const[]){name, ".out", NULL});
    for (unsigned direction = TO_FLIGHT; direction <= TO_DEVICE; direction++) {
        if (octets_of(flow, direction) > 0U) {
            init_queue(flow, direction, resolver);
        }
    }
}

void flow_init(flow_t* const flow, const flow_setup_t* const setup, const flow_resolver_t* const resolver)
{
    FSW_ASSERT((flow != NULL) && (setup != NULL) && (setup->name != NULL) && (resolver != NULL));
    FSW_ASSERT((setup->kind != ENDNODE_CAN) && (setup->octets_in <= FLOW_OCTETS_MAX) &&
               (setup->octets_out <= FLOW_OCTETS_MAX));
    (void)memset(flow, 0, sizeof *flow);
    flow->setup = *setup;
    if (setup->kind == ENDNODE_UDP) {
        init_udp(flow, resolver);
    } else if (is_stream(flow)) {
        init_stream(flow, resolver);
    } else {
        init_queues(flow, resolver);
    }
}

// ---- The links of the end node ----

/// Returns a link of a flow. SHM and MQUEUE have one for each queue, other end nodes one. Null if there is
/// no such link.
static const flow_link_t* link_of(const flow_t* const flow, const unsigned direction)
{
    if (flow->setup.kind == ENDNODE_UDP) {
        return (direction == TO_FLIGHT) ? &flow->udp.link : NULL;
    }
    if (is_stream(flow)) {
        return (direction == TO_FLIGHT) ? &flow->stream.link : NULL;
    }
    if (octets_of(flow, direction) == 0U) {
        return NULL;
    }
    return (flow->setup.kind == ENDNODE_SHM) ? &flow->shm[direction].link : &flow->mqueue[direction].link;
}

static status_t step_link(flow_t* const flow, const unsigned direction, const uint64_t now_ns)
{
    if (flow->setup.kind == ENDNODE_UDP) {
        return flow_udp_step(&flow->udp, now_ns);
    }
    if (is_stream(flow)) {
        return flow_stream_step(&flow->stream, now_ns);
    }
    return (flow->setup.kind == ENDNODE_SHM) ? flow_shm_step(&flow->shm[direction], now_ns)
                                             : flow_mqueue_step(&flow->mqueue[direction], now_ns);
}

status_t flow_step(flow_t* const flow, const uint64_t now_ns)
{
    FSW_ASSERT(flow != NULL);
    status_t status = STATUS_OK;
    for (unsigned direction = TO_FLIGHT; direction <= TO_DEVICE; direction++) {
        const status_t of_link =
            (link_of(flow, direction) != NULL) ? step_link(flow, direction, now_ns) : STATUS_OK;
        status = (status == STATUS_OK) ? of_link : status;
    }
    return status;
}

flow_counters_t flow_counters(const flow_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    flow_counters_t counters = {0U, 0U, 0U, 0U};
    for (unsigned direction = TO_FLIGHT; direction <= TO_DEVICE; direction++) {
        const flow_link_t* const link = link_of(flow, direction);
        if (link != NULL) {
            counters.connected += link->reconnect.connected;
            counters.lost += link->reconnect.lost;
        }
    }
    if (flow->setup.kind == ENDNODE_UDP) {
        counters.malformed = flow->udp.counters.oversize;
    } else if (is_stream(flow)) {
        const flow_frame_counters_t* const frames = &flow->stream.assembler.counters;
        counters.octets                           = flow->stream.counters.octets_in;
        counters.malformed                        = frames->oversize + frames->malformed + frames->cut;
    } else {
        // Queues carry whole messages of the agreed size.
    }
    return counters;
}

// ---- Messages ----

status_t flow_send(flow_t* const flow, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((flow != NULL) && (octets != NULL) && (size == flow->setup.octets_out) && (size > 0U));
    if (flow->setup.kind == ENDNODE_UDP) {
        return flow_udp_send(&flow->udp, octets, size);
    }
    if (is_stream(flow)) {
        return flow_stream_send(&flow->stream, octets, size);
    }
    return (flow->setup.kind == ENDNODE_SHM) ? flow_shm_write(&flow->shm[TO_DEVICE], octets)
                                             : flow_mqueue_send(&flow->mqueue[TO_DEVICE], octets, size);
}

static status_t receive_frame(flow_t* const flow, uint8_t octets[FLOW_OCTETS_MAX], size_t* const out_size)
{
    const uint8_t* payload = NULL;
    const status_t status  = flow_stream_receive(&flow->stream, &payload, out_size);
    if (status == STATUS_OK) {
        (void)memcpy(octets, payload, *out_size);
    }
    return status;
}

status_t flow_receive(flow_t* const flow, uint8_t octets[FLOW_OCTETS_MAX], size_t* const out_size)
{
    FSW_ASSERT((flow != NULL) && (octets != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (flow->setup.kind == ENDNODE_UDP) {
        return flow_udp_receive(&flow->udp, octets, FLOW_OCTETS_MAX, out_size);
    }
    if (is_stream(flow)) {
        return receive_frame(flow, octets, out_size);
    }
    if (flow->setup.octets_in == 0U) {
        return STATUS_EMPTY;
    }
    if (flow->setup.kind == ENDNODE_MQUEUE) {
        return flow_mqueue_receive(&flow->mqueue[TO_FLIGHT], octets, FLOW_OCTETS_MAX, out_size);
    }
    const status_t status = flow_shm_read(&flow->shm[TO_FLIGHT], octets);
    *out_size             = (status == STATUS_OK) ? flow->setup.octets_in : 0U;
    return status;
}

void flow_give_up(flow_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    if (is_stream(flow)) {
        flow_stream_give_up(&flow->stream);
    }
}

void flow_close(flow_t* const flow)
{
    FSW_ASSERT(flow != NULL);
    if (flow->setup.kind == ENDNODE_UDP) {
        flow_udp_close(&flow->udp);
    } else if (is_stream(flow)) {
        flow_stream_close(&flow->stream);
    } else {
        for (unsigned direction = TO_FLIGHT; direction <= TO_DEVICE; direction++) {
            if ((octets_of(flow, direction) > 0U) && (flow->setup.kind == ENDNODE_SHM)) {
                flow_shm_close(&flow->shm[direction]);
            } else if (octets_of(flow, direction) > 0U) {
                flow_mqueue_close(&flow->mqueue[direction]);
            } else {
                // This flow has no queue in this direction.
            }
        }
    }
}
