// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/message/ring_carrier.h"

#include "base/assertion.h"

void message_ring_carrier_init(message_ring_carrier_t* const hub, const message_delivery_notice_t notice)
{
    FSW_ASSERT((hub != NULL) && (notice.delivered != NULL));
    *hub = (message_ring_carrier_t){.notice = notice};
}

status_t message_ring_carrier_attach(message_ring_carrier_t* const hub, message_endpoint_t* const endpoint)
{
    FSW_ASSERT((hub != NULL) && (endpoint != NULL));
    for (size_t i = 0U; i < hub->endpoint_count; i++) {
        if (hub->endpoints[i] == endpoint) {
            return STATUS_OK; // The endpoint was already attached in an earlier life.
        }
    }
    if (hub->endpoint_count == MESSAGE_PEERS_MAX) {
        return STATUS_EXHAUSTED;
    }
    hub->endpoints[hub->endpoint_count] = endpoint;
    hub->endpoint_count++;
    return STATUS_OK;
}

static status_t put_into_inbox(void* const context, const uint16_t to, const uint8_t* const frame,
                               const size_t size)
{
    message_ring_carrier_t* const hub = (message_ring_carrier_t*)context;
    for (size_t i = 0U; i < hub->endpoint_count; i++) {
        if (hub->endpoints[i]->self == to) {
            const status_t status = message_deliver(hub->endpoints[i], frame, size);
            if (status == STATUS_OK) {
                hub->notice.delivered(hub->notice.context, to);
            }
            return status;
        }
    }
    return STATUS_NOT_FOUND;
}

message_carrier_t message_ring_carrier_port(message_ring_carrier_t* const hub)
{
    FSW_ASSERT(hub != NULL);
    return (message_carrier_t){.context = hub, .send = put_into_inbox};
}
