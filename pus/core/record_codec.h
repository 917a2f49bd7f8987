// SPDX-License-Identifier: Apache-2.0
/// Messages of fixed layout: one table of the members of a struct, in the order of the wire, is used to write
/// and to read them.
///
///     static const pus_codec_field_t fields[] = {PUS_CODEC_FIELD(pus_transition_t, previous),
///                                          PUS_CODEC_FIELD(pus_transition_t, code), PUS_CODEC_END};
///     static const pus_layout_t layout  = {PUS_SERVICE_MANAGEMENT, PUS_MANAGEMENT_TRANSITION, fields};
///
/// Members are unsigned integers of 1, 2, 4 or 8 octets; they may belong to a nested struct.
///
/// Ownership  Tables are constant.
/// Context    Any.
/// Time       O(fields).
#ifndef PUS_CORE_RECORD_CODEC_H
#define PUS_CORE_RECORD_CODEC_H

#include "base/octets.h"
#include "base/value.h"
#include "pus/core/app_process.h"

#include <stddef.h>

typedef struct {
    uint8_t offset; ///< Offset of the member in the struct [octets].
    uint8_t type;   ///< value_type_t; VALUE_SCALARS ends a table.
} pus_codec_field_t;

/// Code of the unsigned integer type of 1, 2, 4 or 8 octets.
#define PUS_UNSIGNED_OF(octets)                                                                              \
    (((octets) == 8U) ? VALUE_UINT64                                                                         \
                      : (((octets) == 4U) ? VALUE_UINT32 : (((octets) == 2U) ? VALUE_UINT16 : VALUE_UINT8)))
/// A member of a nested struct, which begins at offset `base` of the struct that the table describes.
#define PUS_CODEC_FIELD_IN(base, record, member)                                                             \
    {                                                                                                        \
        (uint8_t)((base) + offsetof(record, member)),                                                        \
            (uint8_t)PUS_UNSIGNED_OF(sizeof(((const record*)NULL)->member))                                  \
    }
#define PUS_CODEC_FIELD(record, member) PUS_CODEC_FIELD_IN(0U, record, member)
#define PUS_CODEC_END                                                                                        \
    {                                                                                                        \
        0U, (uint8_t)VALUE_SCALARS                                                                           \
    }

/// A report whose source data is one record.
typedef struct {
    uint8_t service;
    uint8_t subtype;
    const pus_codec_field_t* fields;
} pus_layout_t;

/// Write the members in the order of the table. The writer fails if they do not fit.
void pus_codec_write(octet_writer_t* writer, const pus_codec_field_t* fields, const void* record);
/// Read the members. If octets are missing, the reader fails, and the remaining members do not change.
void pus_codec_read(octet_reader_t* reader, const pus_codec_field_t* fields, void* record);
/// Read the members, which must be all of the octets. STATUS_OK, STATUS_INVALID (octets missing or left over:
/// the members may have changed).
MUST_USE status_t pus_codec_read_all(octet_reader_t* reader, const pus_codec_field_t* fields, void* record);
/// Send a report whose source data is the record. Status of pus_tm_post.
status_t pus_codec_post(pus_app_process_t* process, const pus_layout_t* layout, uint16_t destination,
                        const void* record, uint64_t now_ns);

#endif // PUS_CORE_RECORD_CODEC_H
