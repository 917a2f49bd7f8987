// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/ground_backlog.h"

#include "base/assertion.h"

#include <string.h>

#define OFFSET_SERVICE 7U
#define VERIFICATION 1U

/// For each block size: octets, number of blocks, and number of these reserved for FIRM reports.
static const resource_size_t sizes[GROUND_SIZES] = {
    {64U, 768U, 256U}, {256U, 128U, 48U}, {1024U, 16U, 6U}, {PUS_PACKET_MAX, 7U, 3U}};
/// Number of further blocks of each size that BULK reports may not use, so that requests and answers have
/// room while BULK reports wait.
static const uint16_t plain_reserve[GROUND_SIZES] = {320U, 32U, 0U, 0U};

void supervisor_ground_backlog_init(ground_backlog_t* const backlog)
{
    static const uint16_t counts[PUS_CLASSES] = {GROUND_FIRM_REPORTS, GROUND_PLAIN_REPORTS,
                                                 GROUND_BULK_REPORTS};
    static const uint32_t limits[PUS_CLASSES] = {GROUND_FIRM_OCTETS, GROUND_PLAIN_OCTETS, GROUND_BULK_OCTETS};
    FSW_ASSERT(backlog != NULL);
    const status_t status =
        resource_init(&backlog->blocks, backlog->arena, GROUND_ARENA_WORDS, sizes, GROUND_SIZES);
    FSW_ASSERT(status == STATUS_OK);
    uint16_t position = 0U;
    for (size_t i = 0U; i < PUS_CLASSES; i++) {
        backlog->queues[i] = (backlog_queue_t){
            .entries = &backlog->entries[position], .capacity = counts[i], .limit = limits[i]};
        position = (uint16_t)(position + counts[i]);
    }
    (void)memset(backlog->waiting, 0, sizeof backlog->waiting);
    backlog->next_stamp = 0U;
}

uint8_t* supervisor_ground_backlog_take(ground_backlog_t* const backlog, const size_t size)
{
    FSW_ASSERT((backlog != NULL) && (size > 0U));
    void* block = NULL;
    return (resource_take_reserved(&backlog->blocks, size, &block) == STATUS_OK) ? (uint8_t*)block : NULL;
}

void supervisor_ground_backlog_give(ground_backlog_t* const backlog, uint8_t* const block)
{
    FSW_ASSERT(backlog != NULL);
    const status_t status = resource_release(&backlog->blocks, block);
    FSW_ASSERT(status == STATUS_OK);
}

static size_t size_index(const size_t size)
{
    size_t i = 0U;
    while ((i < (GROUND_SIZES - 1U)) && (size > sizes[i].block_octets)) {
        i++;
    }
    return i;
}

/// Returns the number of free blocks that a report of this class and size may use, without those reserved
/// for other classes. `has` blocks already belong to the report.
static unsigned blocks_left(const ground_backlog_t* const backlog, const pus_class_t class, const size_t size,
                            const unsigned has)
{
    const size_t i         = size_index(size);
    const unsigned taken   = backlog->blocks.pools[i].stats.taken - has;
    const unsigned firm    = (class == PUS_CLASS_FIRM) ? 0U : sizes[i].reserve;
    const unsigned plain   = (class == PUS_CLASS_BULK) ? plain_reserve[i] : 0U;
    const unsigned allowed = sizes[i].block_count - firm - plain;
    return (taken < allowed) ? (allowed - taken) : 0U;
}

static bool has_slot(const backlog_queue_t* const queue, const size_t size)
{
    return ((queue->octets + size) <= queue->limit) && (queue->span < queue->capacity);
}

bool supervisor_ground_backlog_accepts(const ground_backlog_t* const backlog, const pus_class_t class,
                                       const size_t size)
{
    FSW_ASSERT((backlog != NULL) && (class < PUS_CLASSES));
    return has_slot(&backlog->queues[class], size) && (blocks_left(backlog, class, size, 0U) > 0U);
}

/// Returns the block that contains the report, with one more reference; allocates one if `block` is null.
static uint8_t* block_of(ground_backlog_t* const backlog, const uint8_t* const packet, const size_t size,
                         uint8_t* const block)
{
    if (block != NULL) {
        const status_t status = resource_retain(&backlog->blocks, block);
        FSW_ASSERT(status == STATUS_OK);
        return block;
    }
    uint8_t* const copy = supervisor_ground_backlog_take(backlog, size);
    FSW_ASSERT(copy != NULL); // The caller has checked that a block is free.
    (void)memcpy(copy, packet, size);
    return copy;
}

status_t supervisor_ground_backlog_put(ground_backlog_t* const backlog, const uint8_t source,
                                       const uint8_t* const packet, const size_t size, uint8_t* const block)
{
    FSW_ASSERT((backlog != NULL) && (packet != NULL) && (source < CAPACITY_SUBSYSTEMS) &&
               (size > OFFSET_SERVICE) && (size <= PUS_PACKET_MAX));
    const pus_class_t class      = pus_class_of(packet, size);
    backlog_queue_t* const queue = &backlog->queues[class];
    // If a block contains the report already, no other one is needed: it does not count as taken.
    const bool has_block = blocks_left(backlog, class, size, (block != NULL) ? 1U : 0U) > 0U;
    if (!has_slot(queue, size) || !has_block) {
        return STATUS_FULL;
    }
    uint8_t* const held = block_of(backlog, packet, size, block);
    queue->entries[(queue->head + queue->span) % queue->capacity] =
        (ground_entry_t){.block           = held,
                         .stamp           = backlog->next_stamp,
                         .size            = (uint16_t)size,
                         .source          = source,
                         .is_verification = (packet[OFFSET_SERVICE] == VERIFICATION)};
    queue->span++;
    queue->octets += (uint32_t)size;
    backlog->next_stamp++;
    backlog->waiting[source] = (uint16_t)(backlog->waiting[source] + ((class != PUS_CLASS_FIRM) ? 1U : 0U));
    return STATUS_OK;
}

static void offer(const backlog_queue_t* const queue, const uint16_t position, const pus_class_t class,
                  ground_report_t* const out_report)
{
    const ground_entry_t* const entry = &queue->entries[position];
    *out_report =
        (ground_report_t){.packet = entry->block, .size = entry->size, .class = class, .position = position};
}

/// Get the next report while only FIRM reports can be sent. A verification waits for the PLAIN and BULK
/// reports of its source: they may be the answer to the request whose end it reports.
static bool next_firm(const ground_backlog_t* const backlog, ground_report_t* const out_report)
{
    const backlog_queue_t* const queue = &backlog->queues[PUS_CLASS_FIRM];
    for (uint16_t i = 0U; i < queue->span; i++) {
        const uint16_t position           = (uint16_t)((queue->head + i) % queue->capacity);
        const ground_entry_t* const entry = &queue->entries[position];
        if ((entry->block != NULL) && (!entry->is_verification || (backlog->waiting[entry->source] == 0U))) {
            offer(queue, position, PUS_CLASS_FIRM, out_report);
            return true;
        }
    }
    return false;
}

bool supervisor_ground_backlog_next(const ground_backlog_t* const backlog, const bool is_plain_open,
                                    ground_report_t* const out_report)
{
    FSW_ASSERT((backlog != NULL) && (out_report != NULL));
    if (!is_plain_open) {
        return next_firm(backlog, out_report);
    }
    bool is_found  = false;
    uint32_t first = 0U;
    for (size_t i = 0U; i < PUS_CLASSES; i++) {
        const backlog_queue_t* const queue = &backlog->queues[i];
        if (queue->span == 0U) {
            continue;
        }
        const uint32_t stamp = queue->entries[queue->head].stamp;
        // Stamps wrap: `stamp` is older than `first` if the difference is small.
        if (!is_found || ((first - stamp) < (UINT32_MAX / 2U))) {
            is_found = true;
            first    = stamp;
            offer(queue, queue->head, (pus_class_t)i, out_report);
        }
    }
    return is_found;
}

void supervisor_ground_backlog_sent(ground_backlog_t* const backlog, const ground_report_t* const report)
{
    FSW_ASSERT((backlog != NULL) && (report != NULL));
    backlog_queue_t* const queue = &backlog->queues[report->class];
    ground_entry_t* const entry  = &queue->entries[report->position];
    FSW_ASSERT((entry->block != NULL) && (entry->block == report->packet));
    if (report->class != PUS_CLASS_FIRM) {
        backlog->waiting[entry->source]--;
    }
    queue->octets -= entry->size;
    supervisor_ground_backlog_give(backlog, entry->block);
    entry->block = NULL;
    while ((queue->span > 0U) && (queue->entries[queue->head].block == NULL)) {
        // Entries of reports that were sent earlier are removed, too.
        queue->head = (uint16_t)((queue->head + 1U) % queue->capacity);
        queue->span--;
    }
}

void supervisor_ground_backlog_copy(const ground_backlog_t* const backlog, message_ring_t* const ring)
{
    FSW_ASSERT((backlog != NULL) && (ring != NULL));
    uint16_t next[PUS_CLASSES] = {0U};
    for (size_t i = 0U; i < GROUND_REPORTS; i++) {
        const ground_entry_t* first = NULL;
        size_t class                = 0U;
        for (size_t k = 0U; k < PUS_CLASSES; k++) {
            const backlog_queue_t* const queue = &backlog->queues[k];
            while ((next[k] < queue->span) &&
                   (queue->entries[(queue->head + next[k]) % queue->capacity].block == NULL)) {
                next[k]++;
            }
            const ground_entry_t* const entry = &queue->entries[(queue->head + next[k]) % queue->capacity];
            if ((next[k] < queue->span) &&
                ((first == NULL) || ((first->stamp - entry->stamp) < (UINT32_MAX / 2U)))) {
                first = entry;
                class = k;
            }
        }
        if ((first == NULL) || (message_ring_put(ring, first->block, first->size) != STATUS_OK)) {
            return;
        }
        next[class]++;
    }
}

uint32_t supervisor_ground_backlog_room(const ground_backlog_t* const backlog, const pus_class_t class)
{
    FSW_ASSERT((backlog != NULL) && (class < PUS_CLASSES));
    const backlog_queue_t* const queue = &backlog->queues[class];
    return (queue->span == queue->capacity) ? 0U : (queue->limit - queue->octets);
}

/// True if PLAIN and FIRM reports both have room, because each request may lead to reports of both classes.
bool supervisor_ground_backlog_takes_requests(const ground_backlog_t* const backlog)
{
    FSW_ASSERT(backlog != NULL);
    const backlog_queue_t* const firm  = &backlog->queues[PUS_CLASS_FIRM];
    const backlog_queue_t* const plain = &backlog->queues[PUS_CLASS_PLAIN];
    return ((firm->limit - firm->octets) >= GROUND_INTAKE) &&
           ((firm->capacity - firm->span) >= (int)GROUND_INTAKE_REPORTS) &&
           ((plain->limit - plain->octets) >= GROUND_INTAKE) &&
           ((plain->capacity - plain->span) >= (int)GROUND_INTAKE_REPORTS) &&
           (blocks_left(backlog, PUS_CLASS_PLAIN, 1U, 0U) >= (2U * GROUND_INTAKE_REPORTS));
}

bool supervisor_ground_backlog_is_empty(const ground_backlog_t* const backlog)
{
    FSW_ASSERT(backlog != NULL);
    return (backlog->queues[PUS_CLASS_FIRM].span + backlog->queues[PUS_CLASS_PLAIN].span +
            backlog->queues[PUS_CLASS_BULK].span) == 0U;
}
