// SPDX-License-Identifier: Apache-2.0
// Connects ST[13] to the supervisor: a request that has arrived in parts is routed like any other request;
// reports of the supervisor that are longer than a packet are sent in parts.
#include "fsw/supervisor/services/spacecraft_services.h"

#include "fsw/supervisor/supervisor_internal.h"

static size_t limit(void* const context, const uint16_t apid)
{
    (void)context;
    return (apid == SUPERVISOR_APID) ? PUS_LARGE_MAX : PUS_PACKET_MAX;
}

static status_t take(void* const context, const uint8_t* const packet, const size_t size,
                     const uint64_t now_ns)
{
    (void)now_ns; // The router uses the time of the step.
    return supervisor_router_route_whole(context, packet, size);
}

static pus_service_t open_large_packets(supervisor_t* const supervisor)
{
    spacecraft_large_packets_t* const large = &supervisor->spacecraft.large_packets;
    const pus_large_config_t config         = {.process        = subsystem_process(&supervisor->subsystem),
                                               .reports        = large->reports,
                                               .report_octets  = large->report_octets,
                                               .report_count   = SPACECRAFT_LARGE_REPORTS,
                                               .report_size    = PUS_LARGE_MAX,
                                               .parts_per_step = SPACECRAFT_LARGE_PARTS,
                                               .uplinks        = large->uplinks,
                                               .uplink_octets  = large->uplink_octets,
                                               .uplink_count   = SPACECRAFT_LARGE_UPLINKS,
                                               .uplink_size    = PUS_LARGE_MAX,
                                               .timeout_ns     = SPACECRAFT_LARGE_TIMEOUT_NS,
                                               .context        = supervisor,
                                               .limit          = limit,
                                               .take           = take};
    pus_large_init(&large->service, &config);
    pus_service_t service = pus_large_service(&large->service);
    service.step          = NULL; // The binding calls the step.
    return service;
}

/// Start the service; the component has its application process now.
static status_t start_large_packets(supervisor_t* const supervisor)
{
    const pus_long_port_t port = pus_large_port(&supervisor->spacecraft.large_packets.service);
    pus_app_process_lengthen(subsystem_process(&supervisor->subsystem), &port);
    return STATUS_OK;
}

static uint64_t step_large_packets(supervisor_t* const supervisor, const uint64_t now_ns)
{
    pus_large_t* const service = &supervisor->spacecraft.large_packets.service;
    pus_large_step(service, now_ns);
    return pus_large_is_busy(service) ? (now_ns + SPACECRAFT_RETRY_NS) : SPACECRAFT_NEVER;
}

const spacecraft_binding_t spacecraft_large_packets = {.type  = PUS_SERVICE_LARGE_PACKETS,
                                                       .open  = open_large_packets,
                                                       .start = start_large_packets,
                                                       .step  = step_large_packets};
