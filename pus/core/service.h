// SPDX-License-Identifier: Apache-2.0
/// Services of one application process, and the dispatcher that verifies requests and passes them on.
///
/// The dispatcher checks a request (TM[1,1] or TM[1,2]): packet, APID, service, subtype, and the format of
/// the application data, which must have no further octets. Then it calls the service's `execute`, whose
/// reply decides on the reports of start and completion (TM[1,3], [1,4], [1,7], [1,8]). A service that
/// answers PUS_LATER copies the token of the request and ends the request itself (functions of ST[01]).
///
/// If a request has several instructions, the service refuses each faulty one with its own TM[1,4]
/// (instruction index from 1) and performs the others: `pus_request_refuse`, `pus_request_perform`, and reply
/// pus_done(). If only some failed, the request ends with TM[1,8] PUS_FAILURE_SOME_FAILED; if all failed,
/// with the TM[1,4].
///
/// Ownership  The caller provides dispatcher, service list and services; all outlive the dispatcher.
/// Context    The loop of the process.
/// Time       O(packet), and the time of the service.
#ifndef PUS_CORE_SERVICE_H
#define PUS_CORE_SERVICE_H

#include "base/octets.h"
#include "pus/core/packet.h"
#include "pus/core/persistence.h"
#include "pus/core/app_process.h"

typedef enum {
    PUS_DONE,    ///< Performed: TM[1,3] and TM[1,7], as requested.
    PUS_LATER,   ///< Started: TM[1,3] as requested; the service keeps the token and completes.
    PUS_STARTED, ///< Like PUS_LATER, but the service has sent TM[1,3] itself, because reports of progress
                 ///< had to follow it.
    PUS_REFUSED, ///< Not started: TM[1,4].
    PUS_FAILED   ///< Started and failed: TM[1,3] as requested, TM[1,8].
} pus_reply_kind_t;

/// Answer of a service, or of a service's port, to a request.
typedef struct {
    pus_reply_kind_t kind;
    pus_failure_t failure; ///< Valid for PUS_REFUSED and PUS_FAILED.
} pus_reply_t;

/// Make replies. PUS_LATER and PUS_STARTED differ only in who sends TM[1,3].
pus_reply_t pus_done(void);
pus_reply_t pus_later(void);
pus_reply_t pus_started(void);
pus_reply_t pus_refused(uint16_t code, uint32_t detail);
pus_reply_t pus_failed(uint16_t code, uint32_t detail);

/// A request under execution; valid during `execute` only.
typedef struct {
    pus_token_t token;     ///< A service copies it to complete the request later.
    octet_reader_t reader; ///< Reads the application data, whose format has been checked.
    uint64_t now_ns;
    pus_app_process_t* process; ///< Process that sends the answer.
    uint16_t performed;         ///< Private: instructions performed.
    uint16_t refused;           ///< Private: instructions refused.
    bool is_started;            ///< Private: TM[1,3] was sent.
    bool may_resume;            ///< Private: the dispatcher can execute it again in a later step.
    bool is_resumed;            ///< Private: the request is executed again.
    bool is_unfinished;         ///< Private: the port did not take a packet of the answer.
    uint16_t packets;           ///< Private: packets of the answer, in this execution.
    uint16_t packets_out;       ///< Private: packets sent or lost, in this or an earlier execution.
    uint16_t packets_lost;      ///< Private: packets neither sent nor kept.
} pus_request_t;

/// Note that an instruction is about to be performed; the first call sends TM[1,3] if requested.
void pus_request_perform(pus_request_t* request);
/// Refuse one instruction with TM[1,4]. instruction >= 1. While reports wait and there is little room, only
/// the first refusal has a report of its own; TM[1,8] has the number of all.
void pus_request_refuse(pus_request_t* request, uint16_t instruction, uint16_t code, uint32_t detail);

/// Finish and send one packet of an answer that may need several. A packet that the port does not take is
/// sent in a later step: the dispatcher executes the request again, without the reports and refusals already
/// sent. `execute` of such a request must not change any state. The request ends after the last packet; a
/// lost packet ends it with TM[1,8] (PUS_FAILURE_SOME_FAILED, packets).
void pus_answer_send(pus_request_t* request, octet_writer_t* writer);
/// Begin a report of the request's service that answers the request; the request's process finishes the
/// report.
octet_writer_t pus_answer_begin(const pus_request_t* request, uint8_t subtype);
/// Begin a report that is a list: its count comes first, and pus_list_end writes it.
octet_writer_t pus_list_begin(const pus_request_t* request, uint8_t subtype);
/// Finish a list and post it. PUS_DONE (also if the process could not keep the report, and has counted it as
/// lost); PUS_FAILED with PUS_FAILURE_TABLE_FULL if the list is too long for a packet.
pus_reply_t pus_list_end(const pus_request_t* request, octet_writer_t* writer, uint16_t count);

/// A performer executes requests of some services later, in another loop, with pus_perform.
typedef struct {
    void* context;
    /// Called for each accepted request. PUS_STARTED: it has copied token and `data` and will perform the
    /// request; PUS_REFUSED: it has no room; PUS_DONE: the request is not for the performer, and the
    /// dispatcher performs it now.
    pus_reply_t (*take)(void* context, const pus_token_t* token, const uint8_t* data, size_t size);
} pus_performer_t;

/// One subtype of a service.
typedef struct {
    uint8_t subtype;
    /// Read the application data without any other effect. The dispatcher refuses the request with
    /// PUS_FAILURE_DATA if the reader then has failed or is not at its end. False: the data is inconsistent
    /// at the position of the reader. Null: `format` is sufficient.
    bool (*has_format)(void* self, octet_reader_t* reader);
    pus_reply_t (*execute)(void* self, pus_request_t* request);
    const uint8_t*
        format; ///< Program of pus/core/request_format.h, PUS_REQUEST_FORMAT_<service>_<subtype>; or null.
} pus_subtype_t;

/// A request whose data has the format in the catalogue: `execute` may read it without checking its bounds.
#define PUS_REQUEST(service, subtype, execute)                                                               \
    {                                                                                                        \
        subtype, NULL, execute, PUS_REQUEST_FORMAT_##service##_##subtype                                     \
    }

/// One service of the dispatcher.
typedef struct {
    uint8_t type;
    uint8_t subtype_count;
    const pus_subtype_t* subtypes;
    void* self; ///< First argument of the functions.
    /// Called once per cycle; null if the service does no periodic work. `cycle` counts minimum sampling
    /// intervals and may jump forward.
    void (*step)(void* self, uint64_t now_ns, uint32_t cycle);
} pus_service_t;

/// Make the entry of a service without `step`; a service with periodic work sets `step` itself. Pointers must
/// not be null.
pus_service_t pus_service_of(uint8_t type, const pus_subtype_t* subtypes, size_t subtype_count, void* self);

/// Functions for `has_format` of a request without application data, with one u8, or with one u16.
bool pus_request_format_empty(void* self, octet_reader_t* reader);
bool pus_request_format_u8(void* self, octet_reader_t* reader);
bool pus_request_format_u16(void* self, octet_reader_t* reader);

/// Application data of the longest request that is executed again [octets]: a list of identifiers.
#define PUS_RESUMED_DATA_MAX (1U + (2U * PUS_COUNT_MAX))

/// Private: a request whose answer is not completely sent.
typedef struct {
    const pus_service_t* service; // Null: there is no such request.
    const pus_subtype_t* subtype;
    pus_token_t token;
    uint16_t packets_out;
    uint16_t packets_lost;
    uint16_t size;
    uint8_t data[PUS_RESUMED_DATA_MAX];
} pus_unfinished_t;

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_app_process_t* process;
    const pus_service_t* services;
    size_t service_count;
    pus_unfinished_t unfinished;
    pus_performer_t performer;            // `take` is null: requests are performed at once.
    const pus_persistence_t* persistence; // Null: changes are not persistent.
    struct {
        uint32_t accepted; ///< Requests accepted.
        uint32_t rejected; ///< Requests rejected with TM[1,2].
        uint32_t ignored;  ///< Packets too short to identify their request.
        uint32_t refused;  ///< Requests whose start failed as a whole.
    } counters;
} pus_dispatcher_t;

/// `services` may still be filled after the call, but not while a request is being dispatched.
void pus_dispatcher_init(pus_dispatcher_t* dispatcher, pus_app_process_t* process,
                         const pus_service_t* services, size_t service_count);
/// From now on `performer` is called for each accepted request.
void pus_dispatcher_defer(pus_dispatcher_t* dispatcher, const pus_performer_t* performer);
/// From now on changes of a request are committed before its completion is reported; a commit that fails ends
/// the request with TM[1,8] (PUS_FAILURE_IO, status).
void pus_dispatcher_persist(pus_dispatcher_t* dispatcher, const pus_persistence_t* persistence);
/// Perform a request that a performer has taken, and send all its reports from the start on. `service` has
/// the type and subtype of the request. `service` and `process` may be instances that the loop of the
/// dispatcher does not use: another instance of the service, and another process of the same APID.
void pus_perform(pus_app_process_t* process, const pus_service_t* service, const pus_token_t* token,
                 const uint8_t* data, size_t size, uint64_t now_ns);
/// Verify one packet and pass it on. STATUS_OK (accepted; verification reports the rest), STATUS_INVALID
/// (rejected with TM[1,2]), STATUS_TRUNCATED (too short to identify its request: ignored and counted).
status_t pus_dispatch(pus_dispatcher_t* dispatcher, const uint8_t* packet, size_t size, uint64_t now_ns);
/// Like pus_dispatch, for a request that may be larger than a packet, as ST[13] has assembled it.
status_t pus_dispatch_large(pus_dispatcher_t* dispatcher, const uint8_t* packet, size_t size,
                            uint64_t now_ns);
/// Send the reports that the process keeps, then continue an answer that is not completely sent. True if the
/// answer is still incomplete: a second request of that kind then fails if the port does not take its answer.
bool pus_dispatcher_resume(pus_dispatcher_t* dispatcher, uint64_t now_ns);
/// True if an answer is not completely sent. Sends nothing.
bool pus_dispatcher_is_answering(const pus_dispatcher_t* dispatcher);

#endif // PUS_CORE_SERVICE_H
