// SPDX-License-Identifier: Apache-2.0
/// An application process: the sender of reports of one APID. It numbers them, counts them per message type
/// and destination, stamps mission time and passes them to a port.
///
///     octet_writer_t writer = pus_tm_begin(process, 129U, 2U, PUS_USER_GROUND, now_ns);
///     octet_write_u8(&writer, state);
///     status_t status = pus_tm_post(process, &writer);
///
/// A packet gets its sequence count when the port takes it, so a refused packet leaves no gap. If the port
/// refuses, pus_tm_send returns STATUS_FULL, and pus_tm_post keeps the report (docs/services.md, "Reports").
///
/// Ownership  The caller provides the process and its queues. The process has one buffer, in which one report
///            is built at a time. pus_tm_begin discards an unfinished report, whose writer can then no longer
///            be sent.
/// Context    One loop.
/// Time       O(size + PUS_MESSAGE_COUNTERS).
#ifndef PUS_CORE_APP_PROCESS_H
#define PUS_CORE_APP_PROCESS_H

#include "base/capacities.h"
#include "base/octets.h"
#include "base/status.h"
#include "pus/core/packet.h"
#include "pus/core/traffic_class.h"

#define PUS_MESSAGE_COUNTERS 128U ///< Pairs of message type and destination that are counted.
#define PUS_KEPT_PREFIX 2U        ///< Additional octets for each report in a queue.
/// Octets in a queue for the longest verification report: request id, step, failure notice.
#define PUS_FIRM_REPORT 48U
#define PUS_FIRM_OF_REQUEST (8U * PUS_FIRM_REPORT) ///< All verification reports of one request.
/// Room that stays reserved when a new request is accepted: a completion report for each of 16 requests in
/// progress, TM[129,2] and TM[1,5] for each of 10 state transitions, two reports for each of 8 links.
#define PUS_FIRM_STANDING ((16U + (10U * 2U) + (8U * 2U)) * PUS_FIRM_REPORT)
/// Kept reports of HIGH events: at most one report or notice of each event [octets].
#define PUS_FIRM_EVENTS CAPACITY_HIGH_EVENTS
#define PUS_FIRM_SIZE 5632U ///< Queue of FIRM reports [octets].
#ifndef PUS_PLAIN_SIZE
#define PUS_PLAIN_SIZE 8192U ///< Queue of PLAIN reports [octets].
#endif
/// Room for an answer and the verification reports that follow it.
#define PUS_ANSWER_ROOM (PUS_KEPT_PREFIX + PUS_PACKET_MAX + PUS_FIRM_OF_REQUEST)
CAPACITY_CHECK(firm_queue_holds_all_reports_due,
               PUS_FIRM_SIZE >= (PUS_FIRM_OF_REQUEST + PUS_FIRM_STANDING + PUS_FIRM_EVENTS));
CAPACITY_CHECK(high_event_head_has_room, CAPACITY_HIGH_EVENT_HEAD >= (PUS_KEPT_PREFIX + PUS_TM_MIN + 2U));
CAPACITY_CHECK(plain_queue_holds_an_answer_and_others, PUS_PLAIN_SIZE >= (PUS_ANSWER_ROOM + 2048U));

/// Port that takes packets. `send` copies the packet or refuses it, and must not call functions of the
/// process.
typedef struct {
    void* context;
    /// STATUS_OK, or any other status: the packet was refused, try again later.
    status_t (*send)(void* context, const uint8_t* packet, size_t size);
} pus_port_t;

/// Port of ST[13], which builds and sends reports that may be longer than a packet.
typedef struct {
    void* context;
    size_t data_max; ///< Source data of the longest report, >= PUS_TM_DATA_MAX [octets].
    /// STATUS_OK, or STATUS_FULL: no buffer is free now.
    status_t (*begin)(void* context, uint8_t service, uint8_t subtype, uint16_t destination, uint64_t now_ns,
                      octet_writer_t* out_writer);
    /// Statuses of pus_tm_post.
    status_t (*post)(void* context, octet_writer_t* writer);
} pus_long_port_t;

/// Private: message type counter of one service, subtype and destination.
typedef struct {
    uint8_t service; // 0: the entry is free.
    uint8_t subtype;
    uint16_t destination;
    uint16_t count;
} pus_message_counter_t;

/// Private: queue of reports that wait for the port, oldest first, each preceded by its size. When reports
/// have been sent, the others move to the beginning of `octets`.
typedef struct {
    uint8_t* octets;
    size_t capacity;
    size_t size;
} pus_kept_t;

/// Octets of the queues of one process.
typedef struct {
    uint8_t firm[PUS_FIRM_SIZE];
    uint8_t plain[PUS_PLAIN_SIZE];
} pus_report_queues_t;

typedef struct { // All fields are private, except `counters`: read-only, for telemetry.
    uint16_t apid;
    uint16_t sequence;
    uint64_t epoch_ns;
    pus_port_t port;
    pus_long_port_t longer; // `begin` is null if there is no such port.
    pus_message_counter_t messages[PUS_MESSAGE_COUNTERS];
    bool is_building;
    pus_kept_t firm;
    pus_kept_t plain;
    uint8_t building[PUS_PACKET_MAX];
    struct {
        uint32_t sent;      ///< Reports that the port took.
        uint32_t refused;   ///< Sends that the port refused.
        uint32_t oversized; ///< Reports that did not fit a packet.
        uint32_t kept;      ///< Reports that were stored in a queue.
        uint32_t lost;      ///< Reports lost, because the queue was full or the port refused a BULK report.
        uint32_t lost_firm; ///< Lost reports that were FIRM.
        uint32_t discarded; ///< Reports begun and not sent, or sent without having been begun.
        uint32_t uncounted; ///< Reports sent with message type counter 0 because the table was full.
    } counters;
} pus_app_process_t;

/// apid 1..2046. epoch_s: mission epoch [seconds since 1958-01-01 TAI]; the time of a packet is epoch +
/// now_ns.
void pus_app_process_init(pus_app_process_t* process, uint16_t apid, uint32_t epoch_s,
                          const pus_port_t* port);

/// From now on the process keeps reports that the port refuses. Call it before the first report.
void pus_app_process_keep(pus_app_process_t* process, pus_report_queues_t* queues);
/// Like pus_app_process_keep, with one queue of `size` octets for FIRM and PLAIN reports, for a port that
/// does not distinguish classes.
void pus_app_process_keep_in_order(pus_app_process_t* process, uint8_t* octets, size_t size);
/// From now on the process may send reports longer than a packet, by this port.
void pus_app_process_lengthen(pus_app_process_t* process, const pus_long_port_t* port);

/// Begin a report; the writer takes up to PUS_TM_DATA_MAX octets of source data.
octet_writer_t pus_tm_begin(pus_app_process_t* process, uint8_t service, uint8_t subtype,
                            uint16_t destination, uint64_t now_ns);
/// Finish and send the report. STATUS_OK, STATUS_FULL (the port refused it, or a kept report that comes
/// first), STATUS_TOO_LARGE (writer failed), STATUS_INVALID (no report was begun). After any status no report
/// is being built.
MUST_USE status_t pus_tm_send(pus_app_process_t* process, octet_writer_t* writer);
/// Finish the report, and send or keep it. STATUS_OK (sent or kept), STATUS_EXHAUSTED (the report is lost and
/// counted, because there is no room to keep it or it is BULK), STATUS_TOO_LARGE, STATUS_INVALID.
status_t pus_tm_post(pus_app_process_t* process, octet_writer_t* writer);
/// Send or keep a report that another process of the same APID has built. The report gets the counts of this
/// process; its time does not change. `packet` is complete with its checksum. Statuses of pus_tm_post except
/// STATUS_INVALID.
status_t pus_tm_forward(pus_app_process_t* process, const uint8_t* packet, size_t size);
/// Source data of the longest report of the process [octets]: PUS_TM_DATA_MAX, or more with ST[13].
size_t pus_tm_data_max(const pus_app_process_t* process);
/// Begin a report of `size` octets of source data, at most pus_tm_data_max. STATUS_OK, STATUS_FULL (the
/// report is longer than a packet, and no buffer is free).
MUST_USE status_t pus_tm_begin_sized(pus_app_process_t* process, uint8_t service, uint8_t subtype,
                                     uint16_t destination, uint64_t now_ns, size_t size,
                                     octet_writer_t* out_writer);
/// Finish a report begun by pus_tm_begin_sized, and send or keep it. Statuses of pus_tm_post.
status_t pus_tm_post_sized(pus_app_process_t* process, octet_writer_t* writer);
/// Begin a report that may be larger than a packet in a buffer of the caller, independent of the report in
/// the buffer of the process. capacity >= PUS_TM_MIN.
octet_writer_t pus_tm_begin_large(const pus_app_process_t* process, uint8_t* octets, size_t capacity,
                                  uint8_t service, uint8_t subtype, uint16_t destination, uint64_t now_ns);
/// Finish a report of pus_tm_begin_large without sending it. The report is counted by its message type and
/// has the sequence count of the next packet that is sent. STATUS_OK, STATUS_TOO_LARGE (writer failed, or
/// longer than PUS_LARGE_MAX).
MUST_USE status_t pus_tm_close_large(pus_app_process_t* process, octet_writer_t* writer, size_t* out_size);
/// Discard the report that is being built.
void pus_tm_cancel(pus_app_process_t* process);
/// Try to send the reports in the queues; to be called once per step. STATUS_OK (the queues are empty),
/// STATUS_FULL.
status_t pus_app_process_flush(pus_app_process_t* process);
/// True if reports wait for the port.
bool pus_app_process_is_waiting(const pus_app_process_t* process);
/// True if a report or notice of a HIGH event waits for the port.
bool pus_app_process_keeps_event(const pus_app_process_t* process, uint16_t event_id);
/// True if a request may be accepted: there is room for its verification and one answer, in addition to the
/// reports of earlier requests.
bool pus_app_process_may_answer(const pus_app_process_t* process);
/// True if there is room for a FIRM report that its sender may omit, in addition to all FIRM reports that
/// requests and events may still cause.
bool pus_app_process_has_firm_room(const pus_app_process_t* process);

#endif // PUS_CORE_APP_PROCESS_H
