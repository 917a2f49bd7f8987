// SPDX-License-Identifier: Apache-2.0
/// Mission service 129, management of one subsystem.
///
///     TC 1 request state {target u8}        TC 3 select configuration {configuration u16}
///     TC 4 report status                    TC 6 reload descriptor
///     TC 8 order state {target u8, cause u8}: TC 1 of the supervisor, with the cause that TM 2 reports; from
///          another source it is refused (PUS_FAILURE_SOURCE)
///     TM 2 state transition {previous u8, state u8, phase u8, configuration u16, cause u8, code u16,
///                            cycle u32}
///     TM 5 status {state u8, phase u8, target u8, configuration u16, interface hash u64,
///                  configuration hash u64, epoch u32, cycle u32}
///     TM 7 event notice {event u16, severity u8}: an event occurred whose report is disabled (TC[5,6]). The
///          notice goes to the supervisor only, which reacts to it as to the report.
///
/// State numbers are those of the generic subsystem; this service does not interpret them.
#ifndef PUS_PRIVATE_ST129_MANAGEMENT_H
#define PUS_PRIVATE_ST129_MANAGEMENT_H

#include "pus/core/service.h"

enum {
    PUS_MANAGEMENT_REQUEST_STATE = 1,
    PUS_MANAGEMENT_TRANSITION    = 2,
    PUS_MANAGEMENT_SELECT        = 3
};
enum {
    PUS_MANAGEMENT_REPORT_STATUS = 4,
    PUS_MANAGEMENT_STATUS        = 5,
    PUS_MANAGEMENT_RELOAD        = 6,
    PUS_MANAGEMENT_NOTICE        = 7,
    PUS_MANAGEMENT_ORDER_STATE   = 8
};

/// Causes of a transition.
typedef enum {
    PUS_CAUSE_REQUEST         = 0,
    PUS_CAUSE_OWN_ERROR       = 1,
    PUS_CAUSE_NETWORK         = 2,
    PUS_CAUSE_PLAN            = 3,
    PUS_CAUSE_SHUTDOWN        = 4,
    PUS_CAUSE_TIMEOUT         = 5,
    PUS_CAUSE_SUPERVISOR_LOST = 6
} pus_cause_t;

/// TC[129,8]. For TC[129,1] the cause is PUS_CAUSE_REQUEST.
typedef struct {
    uint8_t target; ///< Rest state to which the subsystem shall go.
    uint8_t cause;  ///< pus_cause_t.
} pus_state_order_t;

/// TM[129,2].
typedef struct {
    uint8_t previous;
    uint8_t state;
    uint8_t phase;
    uint16_t configuration;
    uint8_t cause; ///< pus_cause_t.
    /// Failure code (PUS_FAILURE_*) or id of the event that caused the transition; 0: neither.
    uint16_t code;
    uint32_t cycle; ///< Cycles since the configuration was applied.
} pus_transition_t;

/// TM[129,5].
typedef struct {
    uint8_t state;
    uint8_t phase;
    uint8_t target; ///< Rest state to which the subsystem goes, or in which it is.
    uint16_t configuration;
    uint64_t interface_hash;
    uint64_t configuration_hash;
    uint32_t epoch; ///< Number of starts of the subsystem in this run.
    uint32_t cycle; ///< Cycles since the configuration was applied.
} pus_subsystem_status_t;

/// TM[129,7]: the notice of a disabled event.
typedef struct {
    uint16_t event;
    uint8_t severity; ///< pus_severity_t.
} pus_event_notice_t;

/// Port of the service to the subsystem. All functions are mandatory.
typedef struct {
    void* context;
    pus_reply_t (*request_state)(void* context, const pus_state_order_t* order, const pus_token_t* token,
                                 uint64_t now_ns);
    pus_reply_t (*select_configuration)(void* context, uint16_t configuration, const pus_token_t* token,
                                        uint64_t now_ns);
    pus_reply_t (*reload_descriptor)(void* context, const pus_token_t* token, uint64_t now_ns);
    void (*read_status)(void* context, pus_subsystem_status_t* out_status);
} pus_management_port_t;

typedef struct { // Private.
    pus_management_port_t port;
} pus_management_t;

void pus_management_init(pus_management_t* management, const pus_management_port_t* port);
pus_service_t pus_management_service(pus_management_t* management);

/// Send TM[129,2] to all ground users. Status of pus_tm_post.
status_t pus_transition_report(pus_app_process_t* process, const pus_transition_t* transition,
                               uint64_t now_ns);
/// Send TM[129,5]. Status of pus_tm_post.
status_t pus_subsystem_status_report(pus_app_process_t* process, uint16_t destination,
                                     const pus_subsystem_status_t* status, uint64_t now_ns);
/// Send TM[129,7] to PUS_USER_SUPERVISOR. Status of pus_tm_post.
status_t pus_event_notice_report(pus_app_process_t* process, const pus_event_notice_t* notice,
                                 uint64_t now_ns);
/// Decode source data. STATUS_OK, STATUS_INVALID (octets missing or left over).
MUST_USE status_t pus_transition_read(octet_reader_t* reader, pus_transition_t* out_transition);
MUST_USE status_t pus_subsystem_status_read(octet_reader_t* reader, pus_subsystem_status_t* out_status);
MUST_USE status_t pus_event_notice_read(octet_reader_t* reader, pus_event_notice_t* out_notice);

#endif // PUS_PRIVATE_ST129_MANAGEMENT_H
