// SPDX-License-Identifier: Apache-2.0
/// A message of 64 octets from one component to another in the same program: submit, route, dispatch to a
/// handler. Baseline, the same by hand: find the queue, lock it, take a block from a free list, copy, put the
/// block, unlock; then find the queue, lock it, get the block, copy, return it to the list, unlock, call the
/// handler. In both, the size is known only at run time.
#define _GNU_SOURCE
#include "fsw/framework/message/message.h"
#include "fsw/framework/message/ring_carrier.h"
#include "test/bench/measure.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define OCTETS 64U
#define WORK 8U
#define PEERS 4U
#define NEAR 16U
#define FAR 17U
#define QUEUE 64U

static message_endpoint_t ends[2];
static message_ring_carrier_t hub;
static message_slot_t inboxes[2];
static uint8_t message[OCTETS];
static volatile uint32_t sink;              // Keeps the compiler from removing the work.
static volatile size_t octets_now = OCTETS; // Keeps the compiler from generating code for one size.

typedef struct {
    uint8_t* block;
    size_t size;
} item_t;

typedef struct {
    uint16_t address;
    item_t items[QUEUE];
    unsigned head;
    unsigned count;
    pthread_mutex_t mutex;
} queue_t;

static queue_t queues[PEERS];
static uint8_t blocks[QUEUE][OCTETS];
static uint8_t* free_blocks[QUEUE];
static unsigned free_count;

static void __attribute__((noinline)) handle(const uint8_t* octets, size_t size)
{
    sink = (uint32_t)(octets[0] + size);
}

static void ignore_notice(void* context, uint16_t to)
{
    (void)context;
    (void)to;
}

static void by_message(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        uint8_t taken[OCTETS];
        uint16_t from = 0U;
        size_t size   = 0U;
        if ((message_send(&ends[0], FAR, message, octets_now) != STATUS_OK) ||
            (message_receive(&ends[1], &from, taken, sizeof taken, &size) != STATUS_OK)) {
            abort();
        }
        handle(taken, size);
        // As in a loop of a component, also read the sender's inbox, where the credits arrive.
        if (i == (WORK - 1U)) {
            (void)!message_receive(&ends[0], &from, taken, sizeof taken, &size);
        }
    }
}

static queue_t* queue_of(uint16_t address)
{
    for (unsigned i = 0U; i < PEERS; i++) {
        if (queues[i].address == address) {
            return &queues[i];
        }
    }
    abort();
}

static void __attribute__((noinline)) queue_send(uint16_t to, const uint8_t* octets, size_t size)
{
    queue_t* const queue = queue_of(to);
    (void)pthread_mutex_lock(&queue->mutex);
    if ((free_count == 0U) || (queue->count == QUEUE)) {
        abort();
    }
    free_count--;
    uint8_t* const block = free_blocks[free_count];
    (void)memcpy(block, octets, size);
    queue->items[(queue->head + queue->count) % QUEUE] = (item_t){block, size};
    queue->count++;
    (void)pthread_mutex_unlock(&queue->mutex);
}

static size_t __attribute__((noinline)) queue_receive(uint16_t own, uint8_t* octets)
{
    queue_t* const queue = queue_of(own);
    (void)pthread_mutex_lock(&queue->mutex);
    if (queue->count == 0U) {
        abort();
    }
    const item_t item = queue->items[queue->head];
    queue->head       = (queue->head + 1U) % QUEUE;
    queue->count--;
    (void)memcpy(octets, item.block, item.size);
    free_blocks[free_count] = item.block;
    free_count++;
    (void)pthread_mutex_unlock(&queue->mutex);
    return item.size;
}

static void by_locked_queue(void)
{
    for (unsigned i = 0U; i < WORK; i++) {
        uint8_t taken[OCTETS];
        queue_send(FAR, message, octets_now);
        handle(taken, queue_receive(FAR, taken));
    }
}

static void* end_at_once(void* context)
{
    return context;
}

int main(void)
{
    pthread_t thread; // The C library locks only in a program that has started a second thread.
    if ((pthread_create(&thread, NULL, end_at_once, NULL) != 0) || (pthread_join(thread, NULL) != 0)) {
        return 1;
    }
    for (unsigned i = 0U; i < QUEUE; i++) {
        free_blocks[i] = blocks[i];
    }
    free_count = QUEUE;
    for (unsigned i = 0U; i < PEERS; i++) {
        queues[i].address = (uint16_t)(NEAR + i);
        (void)pthread_mutex_init(&queues[i].mutex, NULL);
    }
    message_ring_carrier_init(&hub, (message_delivery_notice_t){.delivered = ignore_notice});
    for (unsigned i = 0U; i < 2U; i++) {
        message_open(&ends[i], (uint16_t)(NEAR + i), 1U, message_ring_carrier_port(&hub), &inboxes[i], 1U);
        if ((message_add_peer(&ends[i], (uint16_t)(FAR - i)) != STATUS_OK) ||
            (message_ring_carrier_attach(&hub, &ends[i]) != STATUS_OK)) {
            return 1;
        }
    }
    measure_compare("message_64_octets", by_message, by_locked_queue, WORK, "ns", 1.0);
    return 0;
}
