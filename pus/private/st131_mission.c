// SPDX-License-Identifier: Apache-2.0
#include "pus/private/st131_mission.h"

#include "base/assertion.h"
#include "pus/core/record_codec.h"

void pus_mission_init(pus_mission_t* const mission, const pus_mission_port_t* const port)
{
    FSW_ASSERT((mission != NULL) && (port != NULL) && (port->set_mode != NULL) &&
               (port->select_log != NULL) && (port->shut_down != NULL) && (port->start_process != NULL) &&
               (port->stop_process != NULL) && (port->subsystem != NULL) && (port->network != NULL));
    *mission = (pus_mission_t){.port = *port};
}

static const pus_codec_field_t mode_fields[] = {PUS_CODEC_FIELD(pus_mode_transition_t, previous),
                                                PUS_CODEC_FIELD(pus_mode_transition_t, mode),
                                                PUS_CODEC_FIELD(pus_mode_transition_t, cause), PUS_CODEC_END};

static const pus_codec_field_t log_fields[] = {PUS_CODEC_FIELD(pus_log_transition_t, previous),
                                               PUS_CODEC_FIELD(pus_log_transition_t, strategy),
                                               PUS_CODEC_FIELD(pus_log_transition_t, first_record),
                                               PUS_CODEC_FIELD(pus_log_transition_t, code), PUS_CODEC_END};

static const pus_codec_field_t subsystem_fields[] = {PUS_CODEC_FIELD(pus_subsystem_entry_t, apid),
                                                     PUS_CODEC_FIELD(pus_subsystem_entry_t, process),
                                                     PUS_CODEC_FIELD(pus_subsystem_entry_t, state),
                                                     PUS_CODEC_FIELD(pus_subsystem_entry_t, phase),
                                                     PUS_CODEC_FIELD(pus_subsystem_entry_t, configuration),
                                                     PUS_CODEC_FIELD(pus_subsystem_entry_t, restarts),
                                                     PUS_CODEC_END};

status_t pus_mode_transition_report(pus_app_process_t* const process,
                                    const pus_mode_transition_t* const transition, const uint64_t now_ns)
{
    static const pus_layout_t layout = {PUS_SERVICE_MISSION, PUS_MISSION_MODE_TRANSITION, mode_fields};
    return pus_codec_post(process, &layout, PUS_USER_GROUND, transition, now_ns);
}

status_t pus_log_transition_report(pus_app_process_t* const process,
                                   const pus_log_transition_t* const transition, const uint64_t now_ns)
{
    static const pus_layout_t layout = {PUS_SERVICE_MISSION, PUS_MISSION_LOG_TRANSITION, log_fields};
    return pus_codec_post(process, &layout, PUS_USER_GROUND, transition, now_ns);
}

static pus_reply_t set_mode(void* const self, pus_request_t* const request)
{
    const pus_mission_port_t* const port = &((const pus_mission_t*)self)->port;
    const uint8_t mode                   = octet_read_u8(&request->reader);
    return port->set_mode(port->context, mode, &request->token, request->now_ns);
}

static pus_reply_t select_log(void* const self, pus_request_t* const request)
{
    const pus_mission_port_t* const port = &((const pus_mission_t*)self)->port;
    const uint8_t strategy               = octet_read_u8(&request->reader);
    if (strategy > PUS_LOG_RING) {
        return pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    return port->select_log(port->context, strategy, &request->token, request->now_ns);
}

static pus_reply_t shut_down(void* const self, pus_request_t* const request)
{
    const pus_mission_port_t* const port = &((const pus_mission_t*)self)->port;
    return port->shut_down(port->context, &request->token, request->now_ns);
}

static pus_reply_t start_process(void* const self, pus_request_t* const request)
{
    const pus_mission_port_t* const port = &((const pus_mission_t*)self)->port;
    const uint16_t apid                  = octet_read_u16(&request->reader);
    return port->start_process(port->context, apid, &request->token, request->now_ns);
}

static pus_reply_t stop_process(void* const self, pus_request_t* const request)
{
    const pus_mission_port_t* const port = &((const pus_mission_t*)self)->port;
    const uint16_t apid                  = octet_read_u16(&request->reader);
    return port->stop_process(port->context, apid, &request->token, request->now_ns);
}

static pus_reply_t report_subsystems(void* const self, pus_request_t* const request)
{
    const pus_mission_port_t* const port = &((const pus_mission_t*)self)->port;
    pus_subsystem_entry_t entry          = {0};
    uint16_t count                       = 0U;
    pus_request_perform(request);
    octet_writer_t writer = pus_list_begin(request, PUS_MISSION_SUBSYSTEMS);
    while (!writer.failed && port->subsystem(port->context, count, &entry)) {
        pus_codec_write(&writer, subsystem_fields, &entry);
        count++;
    }
    return pus_list_end(request, &writer, count);
}

static void write_ids(octet_writer_t* const writer, const uint16_t* const ids, const uint16_t count)
{
    octet_write_u16(writer, count);
    for (uint16_t i = 0U; i < count; i++) {
        octet_write_u16(writer, ids[i]);
    }
}

static pus_reply_t report_networks(void* const self, pus_request_t* const request)
{
    const pus_mission_port_t* const port = &((const pus_mission_t*)self)->port;
    pus_network_entry_t entry            = {0};
    uint16_t count                       = 0U;
    pus_request_perform(request);
    octet_writer_t writer = pus_list_begin(request, PUS_MISSION_NETWORKS);
    while (!writer.failed && port->network(port->context, count, &entry)) {
        octet_write_u16(&writer, entry.network);
        write_ids(&writer, entry.members, entry.member_count);
        write_ids(&writer, entry.links, entry.link_count);
        count++;
    }
    return pus_list_end(request, &writer, count);
}

pus_service_t pus_mission_service(pus_mission_t* const mission)
{
    static const pus_subtype_t subtypes[] = {
        {PUS_MISSION_SET_MODE, pus_request_format_u8, set_mode, NULL},
        {PUS_MISSION_SELECT_LOG, pus_request_format_u8, select_log, NULL},
        {PUS_MISSION_SHUT_DOWN, pus_request_format_empty, shut_down, NULL},
        {PUS_MISSION_START_PROCESS, pus_request_format_u16, start_process, NULL},
        {PUS_MISSION_STOP_PROCESS, pus_request_format_u16, stop_process, NULL},
        {PUS_MISSION_REPORT_SUBSYSTEMS, pus_request_format_empty, report_subsystems, NULL},
        {PUS_MISSION_REPORT_NETWORKS, pus_request_format_empty, report_networks, NULL},
    };
    return pus_service_of(PUS_SERVICE_MISSION, subtypes, sizeof subtypes / sizeof subtypes[0], mission);
}
