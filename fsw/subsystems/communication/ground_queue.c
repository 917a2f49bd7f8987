// SPDX-License-Identifier: Apache-2.0
#include "fsw/subsystems/communication/ground_queue.h"

#include "base/assertion.h"
#include "base/octets.h"

#include <stddef.h>
#include <string.h>

#define SERVICE_OFFSET 7U
#define SUBTYPE_OFFSET 8U
#define SUBTYPE_HK_REPORT 25U

void communication_ground_queue_init(communication_ground_queue_t* const queue)
{
    FSW_ASSERT(queue != NULL);
    (void)memset(queue, 0, offsetof(communication_ground_queue_t, sending));
    message_ring_init(&queue->housekeeping, queue->housekeeping_storage, sizeof queue->housekeeping_storage);
    message_ring_init(&queue->firm, queue->firm_storage, sizeof queue->firm_storage);
}

static bool is_housekeeping(const uint8_t* const packet, const size_t size)
{
    return (size > SUBTYPE_OFFSET) && (packet[SERVICE_OFFSET] == PUS_SERVICE_HOUSEKEEPING) &&
           (packet[SUBTYPE_OFFSET] == SUBTYPE_HK_REPORT);
}

static void drop_oldest_housekeeping(communication_ground_queue_t* const queue)
{
    uint8_t block[GROUND_STAMP_OCTETS + PUS_PACKET_MAX];
    size_t size           = 0U;
    const status_t status = message_ring_take(&queue->housekeeping, block, sizeof block, &size);
    FSW_ASSERT(status == STATUS_OK);
    queue->dropped++;
}

status_t communication_ground_queue_put(communication_ground_queue_t* const queue,
                                        const uint8_t* const packet, const size_t size)
{
    FSW_ASSERT((queue != NULL) && (packet != NULL) && (size >= 1U) && (size <= PUS_PACKET_MAX));
    uint8_t block[GROUND_STAMP_OCTETS + PUS_PACKET_MAX];
    octet_writer_t writer = octet_writer(block, sizeof block);
    octet_write_u32(&writer, queue->next_stamp);
    octet_write_octets(&writer, packet, size);
    FSW_ASSERT(!writer.failed);
    queue->next_stamp++;
    if (!is_housekeeping(packet, size)) {
        return message_ring_put(&queue->firm, block, writer.position);
    }
    while (message_ring_room(&queue->housekeeping) < writer.position) {
        drop_oldest_housekeeping(queue);
    }
    return message_ring_put(&queue->housekeeping, block, writer.position);
}

/// Get the stamp of the oldest block of a ring. False if there is none.
static bool oldest_stamp(const message_ring_t* const ring, uint32_t* const out_stamp)
{
    uint8_t octets[GROUND_STAMP_OCTETS];
    size_t size           = 0U;
    const bool has_block  = (message_ring_peek(ring, octets, sizeof octets, &size) == STATUS_OK);
    octet_reader_t reader = octet_reader(octets, sizeof octets);
    *out_stamp            = has_block ? octet_read_u32(&reader) : 0U;
    return has_block;
}

/// Returns the ring whose oldest report arrived first; null if both are empty.
static message_ring_t* next_ring(communication_ground_queue_t* const queue)
{
    uint32_t firm               = 0U;
    uint32_t housekeeping       = 0U;
    const bool has_firm         = oldest_stamp(&queue->firm, &firm);
    const bool has_housekeeping = oldest_stamp(&queue->housekeeping, &housekeeping);
    if (has_firm && (!has_housekeeping || ((firm - housekeeping) > (UINT32_MAX / 2U)))) {
        return &queue->firm;
    }
    return has_housekeeping ? &queue->housekeeping : NULL;
}

const uint8_t* communication_ground_queue_next(communication_ground_queue_t* const queue,
                                               size_t* const out_size)
{
    FSW_ASSERT((queue != NULL) && (out_size != NULL));
    *out_size = 0U;
    if (queue->sending_size == 0U) {
        message_ring_t* const ring = next_ring(queue);
        if (ring == NULL) {
            return NULL;
        }
        const status_t status =
            message_ring_take(ring, queue->sending, sizeof queue->sending, &queue->sending_size);
        FSW_ASSERT(status == STATUS_OK);
        queue->sent = GROUND_STAMP_OCTETS;
    }
    *out_size = queue->sending_size - queue->sent;
    return &queue->sending[queue->sent];
}

void communication_ground_queue_sent(communication_ground_queue_t* const queue, const size_t size)
{
    FSW_ASSERT((queue != NULL) && (size <= (queue->sending_size - queue->sent)));
    queue->sent += size;
    if (queue->sent == queue->sending_size) {
        queue->sending_size = 0U;
        queue->sent         = 0U;
    }
}

uint32_t communication_ground_queue_count(const communication_ground_queue_t* const queue)
{
    FSW_ASSERT(queue != NULL);
    return queue->housekeeping.blocks + queue->firm.blocks + ((queue->sending_size > 0U) ? 1U : 0U);
}

size_t communication_ground_queue_room(const communication_ground_queue_t* const queue)
{
    FSW_ASSERT(queue != NULL);
    return message_ring_room(&queue->firm);
}
