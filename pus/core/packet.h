// SPDX-License-Identifier: Apache-2.0
/// Space packets with PUS-C secondary headers: decoding to views, encoding into a caller's buffer, time.
///
/// Ownership  A decoded view points into the octets of the packet and is valid as long as these exist.
/// Context    Any; no state.
/// Time       O(size), for the checksum.
/// Errors     Received octets never make an assertion fail. Each function lists its statuses.
#ifndef PUS_CORE_PACKET_H
#define PUS_CORE_PACKET_H

#include "base/octets.h"
#include "base/status.h"
#include "pus/core/tailoring.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// Failure notice of ST[01], 8 octets on the wire.
typedef struct {
    uint16_t code;        ///< PUS_FAILURE_*; PUS_FAILURE_NONE: no failure.
    uint16_t instruction; ///< Number of the failed instruction, from 1; 0: the whole request.
    uint32_t detail;      ///< The meaning of `detail` depends on `code`.
} pus_failure_t;

/// The fields of a request that its verification reports need; a service keeps them until the request ends.
typedef struct {
    uint32_t request_id; ///< First four octets of the request.
    uint16_t source;     ///< User that receives the reports.
    uint8_t ack;         ///< PUS_ACK_*.
    uint8_t service;
    uint8_t subtype;
} pus_token_t;

/// A request.
typedef struct {
    uint16_t apid;     ///< Addressee, 0..2047.
    uint16_t sequence; ///< 0..16383.
    uint8_t ack;       ///< PUS_ACK_*.
    uint8_t service;
    uint8_t subtype;
    uint16_t source;
    uint32_t request_id; ///< Filled by decoding; ignored by encoding.
    const uint8_t* data; ///< Application data; may be null if size is 0.
    size_t size;         ///< [octets]
} pus_tc_t;

/// A report.
typedef struct {
    uint16_t apid;     ///< Sender, 0..2047.
    uint16_t sequence; ///< 0..16383.
    uint8_t time_status;
    uint8_t service;
    uint8_t subtype;
    uint16_t counter;     ///< Message type counter.
    uint16_t destination; ///< User that receives the report.
    /// Time since 1958-01-01 TAI [ns]; on the wire it is rounded down to a multiple of 2^-24 s.
    uint64_t time_ns;
    const uint8_t* data; ///< Source data; may be null if size is 0.
    size_t size;         ///< [octets]
} pus_tm_t;

/// Size of the packet that starts at `octets`, from its length field; for framing a stream. STATUS_OK,
/// STATUS_TRUNCATED (incomplete; *out_size is its size if the primary header is complete, else 0),
/// STATUS_TOO_LARGE (longer than PUS_PACKET_MAX: the stream has lost its framing).
MUST_USE status_t pus_packet_frame(const uint8_t* octets, size_t size, size_t* out_size);
/// True if the packet type bit in the primary header is that of a request; needs one octet.
bool pus_packet_is_tc(const uint8_t* octets, size_t size);

/// Check and decode one request that fills `octets` exactly. The order of the checks is: size, length field,
/// checksum, packet version, type, secondary header flag, sequence flags, PUS version; the first failed check
/// is in *out_failure, as for TM[1,2]. *out_tc has the header fields that were received, and zeros for the
/// others (source below PUS_TC_MIN: PUS_USER_GROUND), so that the failure can be reported. STATUS_OK,
/// STATUS_TRUNCATED (shorter than PUS_TC_MIN), STATUS_TOO_LARGE (longer than PUS_PACKET_MAX),
/// STATUS_CHECKSUM, STATUS_INVALID (any other).
MUST_USE status_t pus_tc_decode(const uint8_t* octets, size_t size, pus_tc_t* out_tc,
                                pus_failure_t* out_failure);
/// Like pus_tc_decode, for a request larger than a packet, up to PUS_LARGE_MAX, as ST[13] assembles it.
MUST_USE status_t pus_tc_decode_large(const uint8_t* octets, size_t size, pus_tc_t* out_tc,
                                      pus_failure_t* out_failure);
/// Like pus_tc_decode, for a report; a P-field other than the mission's is STATUS_INVALID with
/// PUS_FAILURE_DATA.
MUST_USE status_t pus_tm_decode(const uint8_t* octets, size_t size, pus_tm_t* out_tm,
                                pus_failure_t* out_failure);

/// Write a whole request. STATUS_OK, STATUS_TOO_LARGE (buffer or packet limit).
MUST_USE status_t pus_tc_encode(const pus_tc_t* tc, uint8_t* octets, size_t capacity, size_t* out_size);
/// Write a whole report. STATUS_OK, STATUS_TOO_LARGE.
MUST_USE status_t pus_tm_encode(const pus_tm_t* tm, uint8_t* octets, size_t capacity, size_t* out_size);

/// Token of a decoded request.
pus_token_t pus_token_of(const pus_tc_t* tc);

/// Failure notice of the whole request.
pus_failure_t pus_failure(uint16_t code, uint32_t detail);
/// Failure notice with PUS_FAILURE_NONE.
pus_failure_t pus_no_failure(void);
/// Write or read a failure notice; 8 octets.
void pus_failure_write(octet_writer_t* writer, const pus_failure_t* failure);
pus_failure_t pus_failure_read(octet_reader_t* reader);

/// Write an absolute time, PUS_TIME_SIZE octets with P-field. Times after 2094 exceed the field and wrap.
void pus_time_write(octet_writer_t* writer, uint64_t time_ns);
/// Read an absolute time. STATUS_OK, STATUS_TRUNCATED, STATUS_INVALID (other P-field). The result is rounded
/// up to the next ns, so that pus_time_write gives the same octets again.
MUST_USE status_t pus_time_read(octet_reader_t* reader, uint64_t* out_time_ns);

/// Read a relative time, PUS_RELATIVE_TIME_SIZE octets, in ticks of 1 / PUS_TIME_TICKS_PER_S s, about +-68
/// years. If octets are missing, the reader fails, and the result has no meaning.
int64_t pus_relative_time_read(octet_reader_t* reader);

#endif // PUS_CORE_PACKET_H
