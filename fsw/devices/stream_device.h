// SPDX-License-Identifier: Apache-2.0
/// A device that exchanges records with flight over a data flow of any end node but CAN. Its descriptor
/// defines the records, the silence after which it is lost, and the delays of reconnection.
///
/// A subsystem calls, by state: _open and _boot (HARDWARE_INIT), _start (PRE_OPERATIONAL), _secure
/// (ERROR_OPERATIONAL), _stop and _close on the way back. Each cycle begins with _sense and ends with
/// _command; _take_fault returns faults. Functions that take several cycles return STATUS_BUSY until done.
/// stream_devices.h does that for all devices of a subsystem.
///
/// A lost device is in use again as soon as it sends a record: _sense reopens its end node, and closes a
/// connection on which no record has arrived for the time of silence.
///
/// Ownership  The caller provides stream_device_t and never moves it; descriptor and resolver outlive it.
/// Context    One task. Blocks only in stepped time, until announced octets have arrived (osal/hand_over.h).
/// Time       The caller passes the time. O(fields + octets), bounded in each call.
/// Errors     Each function lists its statuses.
#ifndef FSW_DEVICES_STREAM_DEVICE_H
#define FSW_DEVICES_STREAM_DEVICE_H

#include "base/status.h"
#include "fsw/devices/stream_record.h"
#include "fsw/framework/dataflow/flow.h"

#include <stdbool.h>
#include <stdint.h>

#define STREAM_DEVICE_NO_FIELD 0xFFU

typedef enum {
    /// The device is not in use yet, and is silent, or its end node is closed. Reported once, until it is
    /// present.
    STREAM_DEVICE_REFUSED,
    /// The device is in use, but is silent, or its end node is closed. Reported once, until it returns.
    STREAM_DEVICE_LOST,
    STREAM_DEVICE_RETURNED ///< A lost device sends records again.
} stream_device_fault_kind_t;

/// Cause of a fault; the events STREAM_REFUSED and STREAM_LOST (stream_devices.h) carry these values.
typedef enum {
    STREAM_CAUSE_NONE      = 0,
    STREAM_CAUSE_CLOSED    = 1, ///< The end node cannot be opened, or was closed by the device.
    STREAM_CAUSE_SILENT    = 2, ///< Nothing was received.
    STREAM_CAUSE_MALFORMED = 3  ///< Octets were received, but no valid record.
} stream_device_cause_t;

typedef struct {
    stream_device_fault_kind_t kind;
    stream_device_cause_t cause;
} stream_device_fault_t;

typedef struct {       // [records, wraps]
    uint32_t received; ///< Received and accepted.
    uint32_t unfit;    ///< Received and dropped: wrong length or checksum.
    uint32_t sent;
    uint32_t refused; ///< Not sent: end node full, or closed by this attempt. While closed, none is due.
} stream_device_counters_t;

typedef struct { // Private, except counters and name: read-only.
    const char* name;
    char address[ENDNODE_ADDRESS_MAX]; // "HOST:PORT"
    uint64_t silence_ns;
    flow_t flow;
    stream_record_t in;
    stream_record_t out;
    uint64_t opened_ns;        // Time at which the end node was opened last.
    uint64_t heard_ns;         // Time at which the last record was received, or the wait for it began.
    uint32_t arrivals_counted; // Result of count_arrivals() at the last valid record.
    bool is_begun;             // Commissioning has begun.
    bool is_open;              // The end node is open.
    bool has_heard;            // A record has arrived since the device was opened.
    bool is_started;
    bool is_lost;
    bool is_refused; // STREAM_DEVICE_REFUSED was reported.
    bool has_fault;
    stream_device_fault_t fault;
    stream_device_counters_t counters;
} stream_device_t;

/// Initialise as closed, with counters zero. The device must have the type DESCRIPTOR_STREAM_TYPE and one end
/// node that is not on CAN.
void stream_device_init(stream_device_t* device, const subsystem_descriptor_t* descriptor,
                        const descriptor_device_t* source, const flow_resolver_t* resolver);
/// Returns the index of a field in the record of a direction; STREAM_DEVICE_NO_FIELD if there is none.
uint8_t stream_device_field(const stream_device_t* device, bool is_out, const char* name);

/// Open the device. STATUS_BUSY until the end node is open.
status_t stream_device_open(stream_device_t* device, uint64_t now_ns);
/// Wait for the first record. STATUS_OK after it has arrived; for a device that sends no records, as soon as
/// its end node is open. STATUS_BUSY until then.
status_t stream_device_boot(const stream_device_t* device);
/// Put the device in use: from now on silence is a fault, and _command sends records; the first one has the
/// safe values. STATUS_OK, STATUS_BUSY (not open, or silent).
status_t stream_device_start(stream_device_t* device, uint64_t now_ns);
/// Call at the start of a cycle: open or reopen the end node, and receive records.
void stream_device_sense(stream_device_t* device, uint64_t now_ns);
/// Call at the end of a cycle: send the record of commands.
void stream_device_command(stream_device_t* device);
/// Set the record of commands to the safe values, and send it. STATUS_OK also if the device cannot be
/// reached; STATUS_BUSY (the end node is full).
status_t stream_device_secure(stream_device_t* device);
/// Secure the device as stream_device_secure does. After STATUS_OK it is no longer in use, and its silence
/// is no fault.
status_t stream_device_stop(stream_device_t* device);
/// Close the end node. The counters keep their values; a fault that was not taken is dropped.
void stream_device_close(stream_device_t* device);

/// Returns the engineering value of a field of the last record received; before the first record, `offset`
/// of the field.
double stream_device_value(const stream_device_t* device, uint8_t field);
bool stream_device_is_lost(const stream_device_t* device);
/// Set a field of the record of commands to an engineering value; see stream_record_set.
status_t stream_device_set(stream_device_t* device, uint8_t field, double value);
/// Take the latest fault; a fault not taken is replaced by the next one. STATUS_OK, STATUS_EMPTY.
MUST_USE status_t stream_device_take_fault(stream_device_t* device, stream_device_fault_t* out_fault);

#endif // FSW_DEVICES_STREAM_DEVICE_H
