// SPDX-License-Identifier: Apache-2.0
/// Serialisation: converts a struct of scalars to octets and back, field after field without gaps, in the
/// flow's byte order. Flows have functions that send and receive records by their layout.
///
///     typedef struct { uint16_t counter; double angle_rad[2]; } sample_t;
///     static const flow_record_field_t fields[] = {RECORD_FIELD(sample_t, counter, VALUE_UINT16, 1U),
///                                                   RECORD_FIELD(sample_t, angle_rad, VALUE_DOUBLE, 2U)};
///     static const flow_record_layout_t layout = {fields, 2U};
///
/// Ownership  The layout is constant.
/// Context    Any.
/// Time       O(octets).
/// Errors     Each function lists its statuses; a null argument is a coding error.
#ifndef FSW_FRAMEWORK_DATAFLOW_RECORD_H
#define FSW_FRAMEWORK_DATAFLOW_RECORD_H

#include "base/flow_format.h"
#include "base/status.h"
#include "base/value.h"

#include <stddef.h>
#include <stdint.h>

/// Size of the longest record on the wire [octets].
#define RECORD_OCTETS_MAX 1024U

typedef struct {
    value_type_t type;
    uint16_t count; ///< Scalars of that type, one after the other.
    size_t offset;  ///< Offset of the first scalar in the struct [octets].
} flow_record_field_t;

#define RECORD_FIELD(record, member, type, count)                                                            \
    {                                                                                                        \
        (type), (count), offsetof(record, member)                                                            \
    }

typedef struct {
    const flow_record_field_t* fields;
    size_t field_count;
} flow_record_layout_t;

/// Returns the size of one record on the wire [octets].
size_t flow_record_octets(const flow_record_layout_t* layout);
/// Convert a struct to octets. STATUS_OK, STATUS_FULL (capacity below flow_record_octets; no octet is
/// written).
MUST_USE status_t flow_record_encode(const flow_record_layout_t* layout, flow_order_t order,
                                     const void* record, uint8_t* octets, size_t capacity, size_t* out_size);
/// Convert octets to a struct, which changes only with STATUS_OK. STATUS_OK; STATUS_TRUNCATED,
/// STATUS_TOO_LARGE (octets are left over), STATUS_INVALID (a BOOL that is neither 0 nor 1).
MUST_USE status_t flow_record_decode(const flow_record_layout_t* layout, flow_order_t order,
                                     const uint8_t* octets, size_t size, void* record);

#endif // FSW_FRAMEWORK_DATAFLOW_RECORD_H
