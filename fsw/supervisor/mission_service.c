// SPDX-License-Identifier: Apache-2.0
// Service 131 of the supervisor: modes, packet log, processes, tables, shutdown.
#include "fsw/supervisor/supervisor_internal.h"

static pus_reply_t set_mode(void* const context, const uint8_t mode, const pus_token_t* const token,
                            const uint64_t now_ns)
{
    (void)token;
    supervisor_t* const supervisor = (supervisor_t*)context;
    supervisor->now_ns             = now_ns;
    if (descriptor_mission_find_mode(supervisor->mission, mode) == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, mode);
    }
    supervisor_mode_set(supervisor, mode, (uint8_t)PUS_CAUSE_REQUEST);
    return pus_done();
}

static pus_reply_t select_log(void* const context, const uint8_t strategy, const pus_token_t* const token,
                              const uint64_t now_ns)
{
    (void)token;
    supervisor_t* const supervisor = (supervisor_t*)context;
    supervisor->now_ns             = now_ns;
    const uint8_t previous         = (uint8_t)supervisor->log.strategy;
    const status_t status = supervisor_packet_log_select(&supervisor->log, (packet_log_strategy_t)strategy);
    if (status == STATUS_UNSUPPORTED) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, strategy);
    }
    if (status != STATUS_OK) {
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    supervisor->is_log_failure_reported   = false;
    const pus_log_transition_t transition = {.previous     = previous,
                                             .strategy     = strategy,
                                             .first_record = supervisor->log.first_number,
                                             .code         = PUS_FAILURE_NONE};
    (void)pus_log_transition_report(subsystem_process(&supervisor->subsystem), &transition, now_ns);
    return pus_done();
}

static pus_reply_t shut_down(void* const context, const pus_token_t* const token, const uint64_t now_ns)
{
    supervisor_t* const supervisor = (supervisor_t*)context;
    supervisor->now_ns             = now_ns;
    if (supervisor->shutdown_step != 0U) {
        return pus_refused(PUS_FAILURE_STATE, 0U);
    }
    supervisor_sequence_shutdown_begin(supervisor, token);
    return pus_later();
}

static pus_reply_t start_process(void* const context, const uint16_t apid, const pus_token_t* const token,
                                 const uint64_t now_ns)
{
    (void)token;
    supervisor_t* const supervisor = (supervisor_t*)context;
    supervisor->now_ns             = now_ns;
    registry_entry_t* const entry  = supervisor_registry_find(supervisor, apid);
    if (entry == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, apid);
    }
    if ((apid == SUPERVISOR_APID) || (entry->process == PROCESS_RUNNING) ||
        (supervisor->shutdown_step != 0U)) { // During the shutdown no process is started.
        return pus_refused(PUS_FAILURE_STATE, apid);
    }
    supervisor_registry_start(supervisor, entry);
    return pus_done();
}

static pus_reply_t stop_process(void* const context, const uint16_t apid, const pus_token_t* const token,
                                const uint64_t now_ns)
{
    (void)token;
    supervisor_t* const supervisor = (supervisor_t*)context;
    supervisor->now_ns             = now_ns;
    registry_entry_t* const entry  = supervisor_registry_find(supervisor, apid);
    if (entry == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, apid);
    }
    // `communication` may be stopped, too: a schedule on board can start it again.
    if ((apid == SUPERVISOR_APID) || (entry->process != PROCESS_RUNNING) || (entry->state != STATE_OFFLINE)) {
        return pus_refused(PUS_FAILURE_STATE, apid);
    }
    supervisor_output_commit_stop(supervisor, entry, false);
    entry->process          = PROCESS_STOPPED;
    entry->is_order_pending = false;
    supervisor_registry_end_pending(supervisor, apid);
    return pus_done();
}

static bool list_subsystem(void* const context, const uint16_t index, pus_subsystem_entry_t* const out_entry)
{
    const supervisor_t* const supervisor = (const supervisor_t*)context;
    if (index >= supervisor->mission->subsystem_count) {
        return false;
    }
    const registry_entry_t* const entry = &supervisor->registry[index];
    *out_entry                          = (pus_subsystem_entry_t){.apid          = entry->mission->apid,
                                                                  .process       = (uint8_t)entry->process,
                                                                  .state         = (uint8_t)entry->state,
                                                                  .phase         = (uint8_t)entry->phase,
                                                                  .configuration = entry->configuration,
                                                                  .restarts      = entry->restarts};
    return true;
}

static bool list_network(void* const context, const uint16_t index, pus_network_entry_t* const out_entry)
{
    supervisor_t* const supervisor  = (supervisor_t*)context;
    const link_graph_t* const graph = &supervisor->graph;
    uint16_t left                   = index;
    for (uint16_t i = 0U; i < graph->count; i++) {
        const uint16_t member  = graph->edges[i].ends.producer_apid;
        const uint16_t network = supervisor_link_graph_network(graph, member);
        if (!supervisor_link_graph_is_first(graph, i)) {
            continue;
        }
        if (left > 0U) {
            left--;
            continue;
        }
        uint16_t links = 0U;
        for (uint16_t k = i; k < graph->count; k++) {
            if (supervisor_link_graph_network(graph, graph->edges[k].ends.producer_apid) == network) {
                supervisor->network_links[links] = graph->edges[k].link;
                links++;
            }
        }
        *out_entry = (pus_network_entry_t){
            .network      = network,
            .member_count = supervisor_link_graph_members(graph, member, supervisor->network_members),
            .link_count   = links,
            .members      = supervisor->network_members,
            .links        = supervisor->network_links};
        return true;
    }
    return false;
}

pus_mission_port_t supervisor_mission_service_port(supervisor_t* const supervisor)
{
    return (pus_mission_port_t){supervisor,    set_mode,     select_log,     shut_down,
                                start_process, stop_process, list_subsystem, list_network};
}
