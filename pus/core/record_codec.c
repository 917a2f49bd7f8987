// SPDX-License-Identifier: Apache-2.0
#include "pus/core/record_codec.h"

#include "base/assertion.h"

void pus_codec_write(octet_writer_t* const writer, const pus_codec_field_t* const fields,
                     const void* const record)
{
    FSW_ASSERT(record != NULL);
    for (size_t i = 0U; fields[i].type != (uint8_t)VALUE_SCALARS; i++) {
        value_encode(writer, (value_type_t)fields[i].type, &((const uint8_t*)record)[fields[i].offset]);
    }
}

void pus_codec_read(octet_reader_t* const reader, const pus_codec_field_t* const fields, void* const record)
{
    FSW_ASSERT(record != NULL);
    status_t status = STATUS_OK; // Other than STATUS_OK if octets are missing: then the reader has failed.
    for (size_t i = 0U; (status == STATUS_OK) && (fields[i].type != (uint8_t)VALUE_SCALARS); i++) {
        status = value_decode(reader, (value_type_t)fields[i].type, &((uint8_t*)record)[fields[i].offset]);
    }
}

status_t pus_codec_read_all(octet_reader_t* const reader, const pus_codec_field_t* const fields,
                            void* const record)
{
    pus_codec_read(reader, fields, record);
    return octet_reader_is_done(reader) ? STATUS_OK : STATUS_INVALID;
}

status_t pus_codec_post(pus_app_process_t* const process, const pus_layout_t* const layout,
                        const uint16_t destination, const void* const record, const uint64_t now_ns)
{
    octet_writer_t writer = pus_tm_begin(process, layout->service, layout->subtype, destination, now_ns);
    pus_codec_write(&writer, layout->fields, record);
    return pus_tm_post(process, &writer);
}
