// SPDX-License-Identifier: Apache-2.0
// Connects ST[13] to the supervisor: a request that arrived in parts is routed like any other, and reports of
// its own process that are longer than a packet are sent in parts.
#include "fsw/supervisor/services/onboard.h"

#include "fsw/supervisor/supervisor_internal.h"

static size_t limit(void* const context, const uint16_t apid)
{
    (void)context;
    return (apid == SUPERVISOR_APID) ? PUS_LARGE_MAX : PUS_PACKET_MAX;
}

static status_t take(void* const context, const uint8_t* const packet, const size_t size,
                     const uint64_t now_ns)
{
    (void)now_ns; // It is the supervisor's.
    return router_route_whole(context, packet, size);
}

static pus_service_t open_large_packets(supervisor_t* const supervisor)
{
    onboard_large_packets_t* const large = &supervisor->onboard.large_packets;
    const pus_large_config_t config      = {.process        = component_process(&supervisor->component),
                                            .reports        = large->reports,
                                            .report_octets  = large->report_octets,
                                            .report_count   = ONBOARD_LARGE_REPORTS,
                                            .report_size    = PUS_LARGE_MAX,
                                            .parts_per_step = ONBOARD_LARGE_PARTS,
                                            .uplinks        = large->uplinks,
                                            .uplink_octets  = large->uplink_octets,
                                            .uplink_count   = ONBOARD_LARGE_UPLINKS,
                                            .uplink_size    = PUS_LARGE_MAX,
                                            .timeout_ns     = ONBOARD_LARGE_TIMEOUT_NS,
                                            .context        = supervisor,
                                            .limit          = limit,
                                            .take           = take};
    pus_large_init(&large->service, &config);
    pus_service_t service = pus_large_service(&large->service);
    service.step          = NULL; // Stepped by the binding.
    return service;
}

/// The component has its process by now.
static status_t start_large_packets(supervisor_t* const supervisor)
{
    const pus_long_port_t port = pus_large_port(&supervisor->onboard.large_packets.service);
    pus_process_lengthen(component_process(&supervisor->component), &port);
    return STATUS_OK;
}

static uint64_t step_large_packets(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_large_t* const service = &supervisor->onboard.large_packets.service;
    pus_large_step(service, now_ns);
    return pus_large_is_busy(service) ? (now_ns + ONBOARD_RETRY_NS) : ONBOARD_NEVER;
}

const onboard_binding_t onboard_large_packets = {.type  = PUS_SERVICE_LARGE_PACKETS,
                                                 .open  = open_large_packets,
                                                 .start = start_large_packets,
                                                 .step  = step_large_packets};
