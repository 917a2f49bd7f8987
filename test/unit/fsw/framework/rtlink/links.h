// SPDX-License-Identifier: Apache-2.0
/// Names and routes of links under test: shared memories of this process, and one UDP socket that sends to
/// itself.
#ifndef TEST_UNIT_FSW_FRAMEWORK_RTLINK_LINKS_H
#define TEST_UNIT_FSW_FRAMEWORK_RTLINK_LINKS_H

#include "fsw/framework/rtlink/link_channel.h"

#define LINK_UNKNOWN 99U ///< A link that has neither name nor route.

extern const rtlink_resolver_t links;
/// Terms of a link of `octets` over one method.
rtlink_terms_t links_terms(rtlink_method_t method, uint32_t octets);
/// Name of the shared memory of a link.
void links_name(uint16_t link, char out_name[64]);
/// Returns the number of frames sent by UDP that are not read yet.
unsigned links_under_way(void);
/// Wait for the next datagram. Returns its size.
size_t links_receive(uint8_t frame[LINK_FRAME_MAX]);
/// Status that the kernel returns for a frame sent over TIPC; not STATUS_OK: the frame is not sent.
/// links_open clears it.
extern status_t links_tipc_status;
/// Send these octets to the socket unchanged.
void links_send(const uint8_t* octets, size_t size);
void links_open(void);
void links_close(void);

#endif // TEST_UNIT_FSW_FRAMEWORK_RTLINK_LINKS_H
