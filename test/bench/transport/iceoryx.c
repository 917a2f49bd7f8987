// SPDX-License-Identifier: Apache-2.0
// iceoryx through its C binding; its daemon must run. The reader polls, or sleeps at a wait set.
#define _GNU_SOURCE
#include "test/bench/transport/round_trip.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <iceoryx_binding_c/enums.h>
#include <iceoryx_binding_c/notification_info.h>
#include <iceoryx_binding_c/publisher.h>
#include <iceoryx_binding_c/runtime.h>
#include <iceoryx_binding_c/subscriber.h>
#include <iceoryx_binding_c/types.h>
#include <iceoryx_binding_c/wait_set.h>

#define EVENTS 4U

static iox_pub_storage_t publisher_storage;
static iox_sub_storage_t subscriber_storage;
static iox_ws_storage_t waiting_storage;
static iox_pub_t publisher;
static iox_sub_t subscriber;
static iox_ws_t waiting;
static char service[32];
static size_t octets;
static bool polls;

static bool prepare(size_t size)
{
    octets = size;
    (void)snprintf(service, sizeof service, "bench%ld", (long)getpid());
    return true;
}

static bool open_side(unsigned side, size_t size, bool is_polled)
{
    static const char* const ways[2] = {"there", "back"};
    char name[64];
    (void)size;
    polls = is_polled;
    (void)snprintf(name, sizeof name, "%s-%u", service, side);
    iox_runtime_init(name);
    iox_pub_options_t pub_options;
    iox_sub_options_t sub_options;
    iox_pub_options_init(&pub_options);
    iox_sub_options_init(&sub_options);
    publisher  = iox_pub_init(&publisher_storage, service, ways[side], "payload", &pub_options);
    subscriber = iox_sub_init(&subscriber_storage, service, ways[1U - side], "payload", &sub_options);
    while ((iox_sub_get_subscription_state(subscriber) != SubscribeState_SUBSCRIBED) ||
           !iox_pub_has_subscribers(publisher)) {
        (void)usleep(1000U);
    }
    if (!is_polled) {
        waiting = iox_ws_init(&waiting_storage);
        (void)iox_ws_attach_subscriber_event(waiting, subscriber, SubscriberEvent_DATA_RECEIVED, 1U, NULL);
    }
    return true;
}

static void send_payload(const uint8_t* payload)
{
    void* chunk = NULL;
    if (iox_pub_loan_chunk(publisher, &chunk, (uint32_t)octets) != AllocationResult_SUCCESS) {
        abort();
    }
    (void)memcpy(chunk, payload, octets);
    iox_pub_publish_chunk(publisher, chunk);
}

static void receive(uint8_t* payload)
{
    const void* chunk = NULL;
    while (iox_sub_take_chunk(subscriber, &chunk) != ChunkReceiveResult_SUCCESS) {
        if (!polls) {
            iox_notification_info_t events[EVENTS];
            uint64_t missed = 0U;
            (void)iox_ws_wait(waiting, events, EVENTS, &missed);
        }
    }
    (void)memcpy(payload, chunk, octets);
    iox_sub_release_chunk(subscriber, chunk);
}

static void close_side(void)
{
    if (!polls) {
        iox_ws_detach_subscriber_event(waiting, subscriber, SubscriberEvent_DATA_RECEIVED);
        iox_ws_deinit(waiting);
    }
    iox_sub_deinit(subscriber);
    iox_pub_deinit(publisher);
    iox_runtime_shutdown();
}

int main(int count, char** words)
{
    const transport_t transport = {.may_poll = true,
                                   .prepare  = prepare,
                                   .open     = open_side,
                                   .send     = send_payload,
                                   .receive  = receive,
                                   .close    = close_side};
    return round_trip_main(count, words, &transport);
}
