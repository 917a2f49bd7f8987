// SPDX-License-Identifier: Apache-2.0
/// SDO client of one node (CiA 301): one transfer at a time, expedited and segmented, both directions.
///
/// Step-function style: the owner passes each answer in and fetches the next request frame; a transfer ends
/// with a result. Block transfer is not supported. An unexpected answer is counted and dropped.
///
/// Ownership  The caller provides canopen_sdo_client_t; the data of a transfer lies inside it.
/// Context    One task.
/// Time       The caller passes the time. O(1).
/// Errors     See canopen_sdo_client_result.
#ifndef FSW_CANOPEN_SDO_CLIENT_H
#define FSW_CANOPEN_SDO_CLIENT_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SDO_OCTETS_MAX 64U ///< Longest value of one transfer [octets].
#define SDO_FRAME_OCTETS 8U

// Abort codes that this client sends; servers send others too.
#define SDO_ABORT_TOGGLE 0x05030000U
#define SDO_ABORT_TIMEOUT 0x05040000U
#define SDO_ABORT_COMMAND 0x05040001U
#define SDO_ABORT_MEMORY 0x05040005U
#define SDO_ABORT_LENGTH 0x06070010U

typedef enum { // Private.
    SDO_IDLE,
    SDO_INITIATE_DOWNLOAD,
    SDO_SEGMENT_DOWNLOAD,
    SDO_INITIATE_UPLOAD,
    SDO_SEGMENT_UPLOAD
} canopen_sdo_phase_t;

typedef struct {        // All counters wrap.
    uint32_t transfers; ///< Transfers that succeeded.
    uint32_t aborted;   ///< Transfers that the server aborted.
    uint32_t timeouts;
    /// Transfers that the client aborted, because an answer violated the protocol or was too long.
    uint32_t violations;
    uint32_t unasked;   ///< Answers without a request, or for another object.
    uint32_t malformed; ///< Answers that were not 8 octets long.
} canopen_sdo_counters_t;

typedef struct { // Private, except counters: read-only.
    uint64_t timeout_ns;
    uint64_t deadline_ns;
    canopen_sdo_phase_t phase;
    status_t result;
    uint32_t abort_code;
    uint16_t index;
    uint8_t subindex;
    bool toggle;
    bool has_request;
    bool is_clock_due; ///< The deadline starts with the next request frame.
    uint8_t request[SDO_FRAME_OCTETS];
    uint8_t data[SDO_OCTETS_MAX];
    size_t size;  ///< Octets of the value. During an upload: the announced size, 0 if none was announced.
    size_t moved; ///< Octets transferred so far.
    canopen_sdo_counters_t counters;
} canopen_sdo_client_t;

/// Initialise without a transfer. The server must answer each request within timeout_ns.
void canopen_sdo_client_init(canopen_sdo_client_t* client, uint64_t timeout_ns);
/// Abort the transfer without informing the server.
void canopen_sdo_client_reset(canopen_sdo_client_t* client);

/// Begin to write an object. STATUS_OK, STATUS_BUSY (a transfer is running), STATUS_TOO_LARGE, STATUS_INVALID
/// (size 0).
MUST_USE status_t canopen_sdo_client_download(canopen_sdo_client_t* client, uint16_t index, uint8_t subindex,
                                              const uint8_t* octets, size_t size);
/// Begin to read an object. STATUS_OK, STATUS_BUSY.
MUST_USE status_t canopen_sdo_client_upload(canopen_sdo_client_t* client, uint16_t index, uint8_t subindex);

/// Returns the result of the last transfer: STATUS_BUSY while it runs; STATUS_OK; STATUS_TIMEOUT;
/// STATUS_FORBIDDEN (the server aborted); STATUS_INVALID (the server violated the protocol);
/// STATUS_TOO_LARGE (upload longer than SDO_OCTETS_MAX); STATUS_EMPTY (none has begun, or it was reset).
/// *out_abort_code is the code of an abort by the server or by this client; out_abort_code may be null.
status_t canopen_sdo_client_result(const canopen_sdo_client_t* client, uint32_t* out_abort_code);
/// Returns the value that the last upload has read. Valid after STATUS_OK, until the next transfer begins.
const uint8_t* canopen_sdo_client_value(const canopen_sdo_client_t* client, size_t* out_size);

/// True while the client waits for the answer to a request that it has sent.
bool canopen_sdo_client_is_waiting(const canopen_sdo_client_t* client);

/// Process one frame of the server.
void canopen_sdo_client_answer(canopen_sdo_client_t* client, const uint8_t* octets, uint8_t length);
/// Get the next frame to the server, and check the deadline. True if `out_frame` was filled.
bool canopen_sdo_client_request(canopen_sdo_client_t* client, uint64_t now_ns,
                                uint8_t out_frame[SDO_FRAME_OCTETS]);

#endif // FSW_CANOPEN_SDO_CLIENT_H
