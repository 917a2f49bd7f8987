// SPDX-License-Identifier: Apache-2.0
#include "pus/st129_management.h"

#include "fsw/framework/base/assertion.h"

void pus_management_init(pus_management_t* const management, const pus_management_port_t* const port)
{
    FSW_ASSERT((management != NULL) && (port != NULL));
    FSW_ASSERT((port->request_state != NULL) && (port->select_configuration != NULL));
    FSW_ASSERT((port->reload_descriptor != NULL) && (port->read_status != NULL));
    *management = (pus_management_t){.port = *port};
}

status_t pus_transition_report(pus_process_t* const process, const pus_transition_t* const transition,
                               const uint64_t now_ns)
{
    FSW_ASSERT((process != NULL) && (transition != NULL));
    octet_writer_t writer =
        pus_tm_begin(process, PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_TRANSITION, PUS_USER_GROUND, now_ns);
    octet_write_u8(&writer, transition->previous);
    octet_write_u8(&writer, transition->state);
    octet_write_u8(&writer, transition->phase);
    octet_write_u16(&writer, transition->configuration);
    octet_write_u8(&writer, transition->cause);
    octet_write_u16(&writer, transition->code);
    octet_write_u32(&writer, transition->cycle);
    return pus_tm_post(process, &writer);
}

status_t pus_transition_read(octet_reader_t* const reader, pus_transition_t* const out_transition)
{
    FSW_ASSERT((reader != NULL) && (out_transition != NULL));
    out_transition->previous      = octet_read_u8(reader);
    out_transition->state         = octet_read_u8(reader);
    out_transition->phase         = octet_read_u8(reader);
    out_transition->configuration = octet_read_u16(reader);
    out_transition->cause         = octet_read_u8(reader);
    out_transition->code          = octet_read_u16(reader);
    out_transition->cycle         = octet_read_u32(reader);
    return octet_reader_is_done(reader) ? STATUS_OK : STATUS_INVALID;
}

status_t pus_subsystem_status_report(pus_process_t* const process, const uint16_t destination,
                                     const pus_subsystem_status_t* const status, const uint64_t now_ns)
{
    FSW_ASSERT((process != NULL) && (status != NULL));
    octet_writer_t writer =
        pus_tm_begin(process, PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_STATUS, destination, now_ns);
    octet_write_u8(&writer, status->state);
    octet_write_u8(&writer, status->phase);
    octet_write_u8(&writer, status->target);
    octet_write_u16(&writer, status->configuration);
    octet_write_u64(&writer, status->interface_hash);
    octet_write_u64(&writer, status->configuration_hash);
    octet_write_u32(&writer, status->epoch);
    octet_write_u32(&writer, status->cycle);
    return pus_tm_post(process, &writer);
}

status_t pus_subsystem_status_read(octet_reader_t* const reader, pus_subsystem_status_t* const out_status)
{
    FSW_ASSERT((reader != NULL) && (out_status != NULL));
    out_status->state              = octet_read_u8(reader);
    out_status->phase              = octet_read_u8(reader);
    out_status->target             = octet_read_u8(reader);
    out_status->configuration      = octet_read_u16(reader);
    out_status->interface_hash     = octet_read_u64(reader);
    out_status->configuration_hash = octet_read_u64(reader);
    out_status->epoch              = octet_read_u32(reader);
    out_status->cycle              = octet_read_u32(reader);
    return octet_reader_is_done(reader) ? STATUS_OK : STATUS_INVALID;
}

static pus_reply_t request_state(void* const self, pus_request_t* const request)
{
    const pus_management_port_t* const port = &((const pus_management_t*)self)->port;
    const uint8_t target                    = octet_read_u8(&request->reader);
    return port->request_state(port->context, target, &request->token, request->now_ns);
}

static pus_reply_t select_configuration(void* const self, pus_request_t* const request)
{
    const pus_management_port_t* const port = &((const pus_management_t*)self)->port;
    const uint16_t configuration            = octet_read_u16(&request->reader);
    return port->select_configuration(port->context, configuration, &request->token, request->now_ns);
}

static pus_reply_t report_status(void* const self, pus_request_t* const request)
{
    const pus_management_port_t* const port = &((const pus_management_t*)self)->port;
    pus_subsystem_status_t status           = {0};
    pus_request_perform(request);
    port->read_status(port->context, &status);
    (void)pus_subsystem_status_report(request->process, request->token.source, &status, request->now_ns);
    return pus_done();
}

static pus_reply_t reload_descriptor(void* const self, pus_request_t* const request)
{
    const pus_management_port_t* const port = &((const pus_management_t*)self)->port;
    return port->reload_descriptor(port->context, &request->token, request->now_ns);
}

pus_service_t pus_management_service(pus_management_t* const management)
{
    static const pus_subtype_t subtypes[] = {
        {PUS_MANAGEMENT_REQUEST_STATE, pus_shape_u8, request_state},
        {PUS_MANAGEMENT_SELECT, pus_shape_u16, select_configuration},
        {PUS_MANAGEMENT_REPORT_STATUS, pus_shape_empty, report_status},
        {PUS_MANAGEMENT_RELOAD, pus_shape_empty, reload_descriptor},
    };
    FSW_ASSERT(management != NULL);
    return (pus_service_t){.type          = PUS_SERVICE_MANAGEMENT,
                           .subtype_count = sizeof(subtypes) / sizeof(subtypes[0]),
                           .subtypes      = subtypes,
                           .self          = management};
}
