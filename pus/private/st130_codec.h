// SPDX-License-Identifier: Apache-2.0
/// Private to service 130: the layouts of messages that both st130_codec.c (for subsystems) and st130_peer.c
/// (for the link manager) use.
#ifndef PUS_PRIVATE_ST130_CODEC_H
#define PUS_PRIVATE_ST130_CODEC_H

#include "pus/core/record_codec.h"
#include "pus/private/st130_rtlink.h"

#define LINK_PROPERTIES 8U // Fields of pus_link_properties_t.
#define LINK_ENDS 4U       // Fields of pus_link_ends_t.
// Fields of each message in the order of the packet, and the entry that ends the table.
extern const pus_codec_field_t link_request_fields[LINK_ENDS + LINK_PROPERTIES + 3U];
extern const pus_codec_field_t link_accept_fields[LINK_PROPERTIES + 3U]; ///< An endpoint follows them.
extern const pus_codec_field_t link_refuse_fields[LINK_PROPERTIES + 4U];
extern const pus_codec_field_t link_open_fields[3U];
extern const pus_codec_field_t link_close_fields[3U];
extern const pus_codec_field_t link_transition_fields[5U]; ///< A time follows them.
extern const pus_codec_field_t link_offer_fields[LINK_PROPERTIES + 3U];
extern const pus_codec_field_t link_status_fields[LINK_ENDS + LINK_PROPERTIES + 8U];

#endif // PUS_PRIVATE_ST130_CODEC_H
