// SPDX-License-Identifier: Apache-2.0
/// Private part of service 130: the fields that its messages share. The readers are in the public header.
#ifndef PUS_ST130_CODEC_H
#define PUS_ST130_CODEC_H

#include "pus/st130_rtlink.h"

void link_properties_write(octet_writer_t* writer, const pus_link_properties_t* properties);
void link_ends_write(octet_writer_t* writer, const pus_link_ends_t* ends);
/// endpoint->size <= PUS_ENDPOINT_MAX.
void link_endpoint_write(octet_writer_t* writer, const pus_endpoint_t* endpoint);

#endif // PUS_ST130_CODEC_H
