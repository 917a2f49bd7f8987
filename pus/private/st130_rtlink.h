// SPDX-License-Identifier: Apache-2.0
/// Mission service 130, real-time links: offers, negotiation, opening, status. Layout of its messages:
/// docs/services/st130.md. The members of a network (subsystems) and the link manager (supervisor) use the
/// same service with different ports.
#ifndef PUS_PRIVATE_ST130_RTLINK_H
#define PUS_PRIVATE_ST130_RTLINK_H

#include "pus/core/service.h"

#define PUS_ENDPOINT_MAX 32U ///< Octets of an endpoint's address or name.

enum {
    PUS_LINK_REPORT_OFFERS = 1,
    PUS_LINK_OFFERS        = 2,
    PUS_LINK_REQUEST       = 3,
    PUS_LINK_ACCEPT        = 4,
    PUS_LINK_REFUSE        = 5,
    PUS_LINK_OPEN          = 6,
    PUS_LINK_CLOSE         = 7,
    PUS_LINK_REPORT_STATUS = 8,
    PUS_LINK_STATUS        = 9,
    PUS_LINK_TRANSITION    = 10
};

typedef enum {
    PUS_LINK_PRODUCER = 0,
    PUS_LINK_CONSUMER = 1
} pus_link_role_t;

typedef enum {
    PUS_METHOD_SHARED_MEMORY = 0,
    PUS_METHOD_TIPC          = 1,
    PUS_METHOD_UDP           = 2,
    PUS_METHOD_STREAM        = 3,
    PUS_METHOD_QUEUE         = 4
} pus_link_method_t;

typedef enum {
    PUS_LINK_STATE_CLOSED    = 0,
    PUS_LINK_STATE_REQUESTED = 1,
    PUS_LINK_STATE_ACCEPTED  = 2,
    PUS_LINK_STATE_OPEN      = 3,
    PUS_LINK_STATE_STALE     = 4,
    PUS_LINK_STATE_FAILED    = 5
} pus_link_state_t;

/// Reasons of TM[130,5], TC[130,7] and causes of TM[130,10].
typedef enum {
    PUS_LINK_REASON_NONE     = 0, ///< A request is the cause.
    PUS_LINK_REASON_LAYOUT   = 1,
    PUS_LINK_REASON_ORDER    = 2,
    PUS_LINK_REASON_PERIOD   = 3,
    PUS_LINK_REASON_METHOD   = 4,
    PUS_LINK_REASON_RESOURCE = 5,
    PUS_LINK_REASON_STATE    = 6,
    PUS_LINK_REASON_PORT     = 7,
    PUS_LINK_REASON_DEADLINE = 8, ///< Accepted, but not opened in time.
    PUS_LINK_REASON_STALE    = 9, ///< The last sample is older than permitted.
    PUS_LINK_REASON_PEER     = 10 ///< The peer is lost or in error.
} pus_link_reason_t;

/// Field of the request for which TM[130,5] refuses it.
typedef enum {
    PUS_LINK_FIELD_NONE        = 0,
    PUS_LINK_FIELD_LAYOUT_HASH = 1,
    PUS_LINK_FIELD_LAYOUT_SIZE = 2,
    PUS_LINK_FIELD_BYTE_ORDER  = 3,
    PUS_LINK_FIELD_PERIOD      = 4,
    PUS_LINK_FIELD_TOLERANCE   = 5,
    PUS_LINK_FIELD_METHOD      = 6,
    PUS_LINK_FIELD_DEPTH       = 7,
    PUS_LINK_FIELD_AGE         = 8,
    PUS_LINK_FIELD_PORT        = 9,
    PUS_LINK_FIELD_ROLE        = 10
} pus_link_field_t;

/// Properties of a link: those that are offered, wanted, supported or agreed (P in docs/services/st130.md).
typedef struct {
    uint32_t layout_hash; ///< CRC-32 of the canonical text of the payload's layout.
    uint32_t layout_size; ///< [octets]
    uint8_t byte_order;   ///< 0 big, 1 little.
    uint32_t period_us;
    uint16_t tolerance_permille; ///< Permitted deviation of the period; subsystems offer 0.
    uint8_t method;              ///< pus_link_method_t.
    uint8_t depth;               ///< Samples that the link holds; subsystems offer 1.
    uint32_t age_max_us;         ///< A sample older than this is stale.
} pus_link_properties_t;

/// Endpoint of one side of a link (E in docs/services/st130.md).
typedef struct {
    uint8_t kind; ///< pus_link_method_t.
    uint8_t size; ///< 0..PUS_ENDPOINT_MAX.
    uint8_t octets[PUS_ENDPOINT_MAX];
} pus_endpoint_t;

/// The two ends of a link.
typedef struct {
    uint16_t producer_apid;
    uint16_t producer_port;
    uint16_t consumer_apid;
    uint16_t consumer_port;
} pus_link_ends_t;

/// One entry of TM[130,2].
typedef struct {
    uint16_t port;
    uint8_t role; ///< pus_link_role_t.
    pus_link_properties_t properties;
} pus_link_offer_t;

/// TC[130,3].
typedef struct {
    uint32_t transaction;
    uint16_t link; ///< 0: the manager assigns it.
    pus_link_ends_t ends;
    pus_link_properties_t properties;
} pus_link_request_t;

/// TM[130,4].
typedef struct {
    uint32_t transaction;
    uint16_t link;
    pus_link_properties_t properties;
    pus_endpoint_t endpoint;
} pus_link_accept_t;

/// TM[130,5].
typedef struct {
    uint32_t transaction;
    uint8_t reason; ///< pus_link_reason_t.
    uint8_t field;  ///< pus_link_field_t.
    pus_link_properties_t supported;
} pus_link_refuse_t;

/// TC[130,6].
typedef struct {
    uint16_t link;
    uint32_t epoch; ///< Number of this opening; larger than all before.
} pus_link_open_t;

/// TC[130,7].
typedef struct {
    uint16_t link;
    uint8_t reason; ///< pus_link_reason_t.
} pus_link_close_t;

/// One entry of TM[130,9].
typedef struct {
    uint16_t link;
    uint8_t state; ///< pus_link_state_t.
    pus_link_ends_t ends;
    pus_link_properties_t properties;
    uint32_t sent;          ///< Samples sent; 0 for a consumer.
    uint32_t received;      ///< Samples received and used; 0 for a producer.
    uint32_t lost;          ///< Samples that were missing when they were due.
    uint32_t late;          ///< Reads of a stale sample.
    uint32_t last_sequence; ///< Sequence number of the last sample that was sent, or received and used.
} pus_link_status_t;

/// TM[130,10].
typedef struct {
    uint16_t link;
    uint8_t previous; ///< pus_link_state_t.
    uint8_t state;    ///< pus_link_state_t.
    uint8_t cause;    ///< pus_link_reason_t.
    /// Decoded: time since 1958 TAI. To be reported: mission time, to which the process adds its epoch.
    uint64_t time_ns;
} pus_link_transition_t;

/// Answer of a port to TC[130,3]: if is_accepted, the service reports `accept`, else `refuse`.
typedef struct {
    bool is_accepted;
    pus_link_accept_t accept; ///< transaction is filled by the service.
    pus_link_refuse_t refuse; ///< transaction is filled by the service.
} pus_link_answer_t;

/// Port of the service to the links of a process. All functions are mandatory.
typedef struct {
    void* context;
    /// Get offer number `index` (0, 1, ...); false after the last one. Must not send reports.
    bool (*offer)(void* context, uint16_t index, pus_link_offer_t* out_offer);
    /// Negotiate. PUS_DONE: *out_answer is the result; the service sends TM[130,4] and completes, or sends
    /// TM[130,5] and fails the request with PUS_FAILURE_LINK_REFUSED. PUS_LATER: the port itself reports the
    /// result and completes the request.
    pus_reply_t (*request)(void* context, const pus_link_request_t* request, pus_link_answer_t* out_answer,
                           const pus_token_t* token, uint64_t now_ns);
    pus_reply_t (*open)(void* context, const pus_link_open_t* open, const pus_token_t* token,
                        uint64_t now_ns);
    pus_reply_t (*close)(void* context, const pus_link_close_t* close, const pus_token_t* token,
                         uint64_t now_ns);
    /// Get the status of link number `index` (0, 1, ...); false after the last one. Must not send reports.
    bool (*status)(void* context, uint16_t index, pus_link_status_t* out_status);
} pus_rtlink_port_t;

typedef struct { // Private.
    pus_rtlink_port_t port;
} pus_rtlink_t;

void pus_rtlink_init(pus_rtlink_t* rtlink, const pus_rtlink_port_t* port);
pus_service_t pus_rtlink_service(pus_rtlink_t* rtlink);

/// Send TM[130,4] or TM[130,5]. Status of pus_tm_post.
status_t pus_link_accept_report(pus_app_process_t* process, uint16_t destination,
                                const pus_link_accept_t* accept, uint64_t now_ns);
status_t pus_link_refuse_report(pus_app_process_t* process, uint16_t destination,
                                const pus_link_refuse_t* refuse, uint64_t now_ns);
/// Send TM[130,10] to all ground users; the supervisor, which forwards the report, also evaluates it. Status
/// of pus_tm_post.
status_t pus_link_transition_report(pus_app_process_t* process, const pus_link_transition_t* transition,
                                    uint64_t now_ns);

/// Write the application data of requests, for the link manager.
void pus_link_request_write(octet_writer_t* writer, const pus_link_request_t* request);
void pus_link_open_write(octet_writer_t* writer, const pus_link_open_t* open);
void pus_link_close_write(octet_writer_t* writer, const pus_link_close_t* close);

/// Decode application or source data, which must be complete. STATUS_OK, STATUS_INVALID (octets missing or
/// left over, or an endpoint longer than PUS_ENDPOINT_MAX).
MUST_USE status_t pus_link_request_read(octet_reader_t* reader, pus_link_request_t* out_request);
MUST_USE status_t pus_link_accept_read(octet_reader_t* reader, pus_link_accept_t* out_accept);
MUST_USE status_t pus_link_refuse_read(octet_reader_t* reader, pus_link_refuse_t* out_refuse);
MUST_USE status_t pus_link_open_read(octet_reader_t* reader, pus_link_open_t* out_open);
MUST_USE status_t pus_link_close_read(octet_reader_t* reader, pus_link_close_t* out_close);
MUST_USE status_t pus_link_transition_read(octet_reader_t* reader, pus_link_transition_t* out_transition);
/// Read TM[130,9]: first the count (*out_count, checked against the octets that follow), then that many
/// entries, in order. STATUS_OK, STATUS_INVALID.
MUST_USE status_t pus_link_statuses_read(octet_reader_t* reader, uint16_t* out_count);
void pus_link_status_read(octet_reader_t* reader, pus_link_status_t* out_status);

#endif // PUS_PRIVATE_ST130_RTLINK_H
