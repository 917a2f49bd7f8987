// SPDX-License-Identifier: Apache-2.0
/// Private part of service 130: entries of its lists. The readers are in the public header.
#ifndef PUS_ST130_CODEC_H
#define PUS_ST130_CODEC_H

#include "pus/st130_rtlink.h"

void link_offer_write(octet_writer_t* writer, const pus_link_offer_t* offer);
void link_status_write(octet_writer_t* writer, const pus_link_status_t* status);

#endif // PUS_ST130_CODEC_H
