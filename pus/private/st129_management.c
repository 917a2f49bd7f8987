// SPDX-License-Identifier: Apache-2.0
#include "pus/private/st129_management.h"

#include "base/assertion.h"
#include "pus/core/record_codec.h"

void pus_management_init(pus_management_t* const management, const pus_management_port_t* const port)
{
    FSW_ASSERT((management != NULL) && (port != NULL) && (port->request_state != NULL) &&
               (port->select_configuration != NULL) && (port->reload_descriptor != NULL) &&
               (port->read_status != NULL));
    *management = (pus_management_t){.port = *port};
}

static const pus_codec_field_t transition_fields[] = {
    PUS_CODEC_FIELD(pus_transition_t, previous), PUS_CODEC_FIELD(pus_transition_t, state),
    PUS_CODEC_FIELD(pus_transition_t, phase),    PUS_CODEC_FIELD(pus_transition_t, configuration),
    PUS_CODEC_FIELD(pus_transition_t, cause),    PUS_CODEC_FIELD(pus_transition_t, code),
    PUS_CODEC_FIELD(pus_transition_t, cycle),    PUS_CODEC_END};

static const pus_codec_field_t status_fields[] = {PUS_CODEC_FIELD(pus_subsystem_status_t, state),
                                                  PUS_CODEC_FIELD(pus_subsystem_status_t, phase),
                                                  PUS_CODEC_FIELD(pus_subsystem_status_t, target),
                                                  PUS_CODEC_FIELD(pus_subsystem_status_t, configuration),
                                                  PUS_CODEC_FIELD(pus_subsystem_status_t, interface_hash),
                                                  PUS_CODEC_FIELD(pus_subsystem_status_t, configuration_hash),
                                                  PUS_CODEC_FIELD(pus_subsystem_status_t, epoch),
                                                  PUS_CODEC_FIELD(pus_subsystem_status_t, cycle),
                                                  PUS_CODEC_END};

static const pus_codec_field_t notice_fields[] = {
    PUS_CODEC_FIELD(pus_event_notice_t, event), PUS_CODEC_FIELD(pus_event_notice_t, severity), PUS_CODEC_END};

status_t pus_transition_report(pus_app_process_t* const process, const pus_transition_t* const transition,
                               const uint64_t now_ns)
{
    static const pus_layout_t layout = {PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_TRANSITION, transition_fields};
    return pus_codec_post(process, &layout, PUS_USER_GROUND, transition, now_ns);
}

status_t pus_transition_read(octet_reader_t* const reader, pus_transition_t* const out_transition)
{
    return pus_codec_read_all(reader, transition_fields, out_transition);
}

status_t pus_subsystem_status_report(pus_app_process_t* const process, const uint16_t destination,
                                     const pus_subsystem_status_t* const status, const uint64_t now_ns)
{
    static const pus_layout_t layout = {PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_STATUS, status_fields};
    return pus_codec_post(process, &layout, destination, status, now_ns);
}

status_t pus_subsystem_status_read(octet_reader_t* const reader, pus_subsystem_status_t* const out_status)
{
    return pus_codec_read_all(reader, status_fields, out_status);
}

status_t pus_event_notice_report(pus_app_process_t* const process, const pus_event_notice_t* const notice,
                                 const uint64_t now_ns)
{
    static const pus_layout_t layout = {PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_NOTICE, notice_fields};
    return pus_codec_post(process, &layout, PUS_USER_SUPERVISOR, notice, now_ns);
}

status_t pus_event_notice_read(octet_reader_t* const reader, pus_event_notice_t* const out_notice)
{
    return pus_codec_read_all(reader, notice_fields, out_notice);
}

/// Perform TC[129,1] or TC[129,8]; only the second contains the cause.
static pus_reply_t request_state(void* const self, pus_request_t* const request)
{
    const pus_management_port_t* const port = &((const pus_management_t*)self)->port;
    const bool is_order                     = (request->token.subtype == (uint8_t)PUS_MANAGEMENT_ORDER_STATE);
    pus_state_order_t order                 = {.target = octet_read_u8(&request->reader),
                                               .cause  = (uint8_t)PUS_CAUSE_REQUEST};
    if (is_order) {
        order.cause = octet_read_u8(&request->reader);
        if (request->token.source != PUS_USER_SUPERVISOR) {
            return pus_refused(PUS_FAILURE_SOURCE, request->token.source);
        }
        if (order.cause > (uint8_t)PUS_CAUSE_SUPERVISOR_LOST) {
            return pus_refused(PUS_FAILURE_OUT_OF_RANGE, sizeof order.target);
        }
    }
    return port->request_state(port->context, &order, &request->token, request->now_ns);
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
        {PUS_MANAGEMENT_REQUEST_STATE, pus_request_format_u8, request_state, NULL},
        {PUS_MANAGEMENT_SELECT, pus_request_format_u16, select_configuration, NULL},
        {PUS_MANAGEMENT_REPORT_STATUS, pus_request_format_empty, report_status, NULL},
        {PUS_MANAGEMENT_RELOAD, pus_request_format_empty, reload_descriptor, NULL},
        // TC[129,8] has two octets: target and cause.
        {PUS_MANAGEMENT_ORDER_STATE, pus_request_format_u16, request_state, NULL},
    };
    return pus_service_of(PUS_SERVICE_MANAGEMENT, subtypes, sizeof subtypes / sizeof subtypes[0], management);
}
