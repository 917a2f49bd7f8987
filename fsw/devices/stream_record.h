// SPDX-License-Identifier: Apache-2.0
/// The record of a stream device as its descriptor defines it: fields in engineering units on one side,
/// octets on the other. Raw value = (engineering value - offset) / scale, rounded to the nearest and limited
/// to its type. The fields follow each other without gaps in the byte order of the end node; a checksum
/// (CRC-16/CCITT-FALSE) may follow them.
///
/// Ownership  The caller provides stream_record_t; the descriptor outlives it.
/// Context    One task.
/// Time       O(fields).
/// Errors     Each function lists its statuses.
#ifndef FSW_DEVICES_STREAM_RECORD_H
#define FSW_DEVICES_STREAM_RECORD_H

#include "base/status.h"
#include "fsw/framework/dataflow/record.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STREAM_RECORD_FIELDS_MAX 16U
#define STREAM_RECORD_OCTETS_MAX 130U ///< 16 fields of 8 octets, and the checksum.

typedef struct { // Private, except field_count.
    const descriptor_record_field_t* sources[STREAM_RECORD_FIELDS_MAX];
    flow_record_field_t fields[STREAM_RECORD_FIELDS_MAX];
    uint64_t memory[STREAM_RECORD_FIELDS_MAX]; // One raw value each.
    uint8_t field_count;
    flow_order_t order;
    bool has_checksum;
} stream_record_t;

/// Initialise with the fields of one direction from the descriptor, at most STREAM_RECORD_FIELDS_MAX. All
/// raw values are 0.
void stream_record_init(stream_record_t* record, const subsystem_descriptor_t* descriptor,
                        const descriptor_device_t* device, bool is_out);
/// Returns the size of the record on the wire [octets]; 0 if it has no fields.
uint32_t stream_record_octets(const stream_record_t* record);
/// Decode a received record. STATUS_OK; STATUS_TRUNCATED, STATUS_TOO_LARGE and STATUS_CHECKSUM leave the
/// values unchanged.
MUST_USE status_t stream_record_take(stream_record_t* record, const uint8_t* octets, size_t size);
/// Encode the record. Returns the octets written: stream_record_octets.
size_t stream_record_put(const stream_record_t* record, uint8_t octets[STREAM_RECORD_OCTETS_MAX]);
/// Returns the engineering value of a field below field_count.
double stream_record_value(const stream_record_t* record, uint8_t field);
/// Set a field to an engineering value, limited to what its type can hold. STATUS_OK, STATUS_OUT_OF_RANGE
/// (NaN; the field keeps its value).
status_t stream_record_set(stream_record_t* record, uint8_t field, double value);
/// Set all fields to the safe values of the descriptor.
void stream_record_set_safe(stream_record_t* record);

#endif // FSW_DEVICES_STREAM_RECORD_H
