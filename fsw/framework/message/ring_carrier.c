// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/ring_carrier.h"

#include "base/assertion.h"

void message_ring_carrier_init(message_ring_carrier_t* const carrier, const message_delivery_notice_t notice)
{
    FSW_ASSERT((carrier != NULL) && (notice.delivered != NULL));
    *carrier = (message_ring_carrier_t){.notice = notice};
}

status_t message_ring_carrier_attach(message_ring_carrier_t* const carrier,
                                     message_endpoint_t* const endpoint)
{
    FSW_ASSERT((carrier != NULL) && (endpoint != NULL));
    for (size_t i = 0U; i < carrier->endpoint_count; i++) {
        if (carrier->endpoints[i] == endpoint) {
            return STATUS_OK; // The endpoint was already attached in an earlier life.
        }
    }
    if (carrier->endpoint_count == MESSAGE_PEERS_MAX) {
        return STATUS_EXHAUSTED;
    }
    carrier->endpoints[carrier->endpoint_count] = endpoint;
    carrier->endpoint_count++;
    return STATUS_OK;
}

static status_t put_into_inbox(void* const context, const uint16_t to, const uint8_t* const frame,
                               const size_t size)
{
    message_ring_carrier_t* const carrier = (message_ring_carrier_t*)context;
    for (size_t i = 0U; i < carrier->endpoint_count; i++) {
        if (carrier->endpoints[i]->self == to) {
            const status_t status = message_deliver(carrier->endpoints[i], frame, size);
            if (status == STATUS_OK) {
                carrier->notice.delivered(carrier->notice.context, to);
            }
            return status;
        }
    }
    return STATUS_NOT_FOUND;
}

message_carrier_t message_ring_carrier_port(message_ring_carrier_t* const carrier)
{
    FSW_ASSERT(carrier != NULL);
    return (message_carrier_t){.context = carrier, .send = put_into_inbox};
}
