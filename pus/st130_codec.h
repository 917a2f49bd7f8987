// SPDX-License-Identifier: Apache-2.0
/// Private part of service 130: the layouts of its messages. The readers are in the public header.
#ifndef PUS_ST130_CODEC_H
#define PUS_ST130_CODEC_H

#include "pus/fields.h"
#include "pus/st130_rtlink.h"

extern const pus_field_t link_accept_fields[]; // But the endpoint, which follows.
extern const pus_field_t link_refuse_fields[];
extern const pus_field_t link_offer_fields[];
extern const pus_field_t link_status_fields[];

/// endpoint->size <= PUS_ENDPOINT_MAX.
void link_endpoint_write(octet_writer_t* writer, const pus_endpoint_t* endpoint);

#endif // PUS_ST130_CODEC_H
