// SPDX-License-Identifier: Apache-2.0
/// Reports that wait until they can be sent to the ground, in one queue for each class
/// (pus/core/traffic_class.h), and the blocks that contain them.
///
/// A packet is in one block with a reference count: the router has a reference while the packet is logged
/// and observed, and a queue has one until the packet has been sent; so a waiting report is not copied. There
/// are four sizes of blocks; some blocks of each size are for FIRM reports only. If no block is free, a
/// report cannot wait; the rule of its class then decides what happens.
///
/// Order      Reports are sent in order of arrival. While only FIRM reports can be sent, they overtake the
///            others; but a verification (ST[01]) does not overtake earlier reports of its own subsystem.
/// Ownership  The caller provides ground_backlog_t.
/// Context    One loop.
/// Time       O(reports of the class).
#ifndef FSW_SUPERVISOR_GROUND_BACKLOG_H
#define FSW_SUPERVISOR_GROUND_BACKLOG_H

#include "base/capacities.h"
#include "fsw/framework/message/message_ring.h"
#include "base/resource.h"
#include "pus/core/traffic_class.h"

#define GROUND_FIRM_OCTETS 32768U
#define GROUND_PLAIN_OCTETS 16384U
#define GROUND_BULK_OCTETS 16384U
/// No request is accepted if FIRM or PLAIN reports have less room than GROUND_INTAKE octets, if one of their
/// queues has less room than GROUND_INTAKE_REPORTS, or if fewer than twice as many of the smallest blocks are
/// free for PLAIN reports.
#define GROUND_INTAKE 8192U
#define GROUND_INTAKE_REPORTS 128U
#define GROUND_FIRM_REPORTS 512U
#define GROUND_PLAIN_REPORTS 256U
#define GROUND_BULK_REPORTS 256U
#define GROUND_REPORTS (GROUND_FIRM_REPORTS + GROUND_PLAIN_REPORTS + GROUND_BULK_REPORTS)
#define GROUND_OCTETS (GROUND_FIRM_OCTETS + GROUND_PLAIN_OCTETS + GROUND_BULK_OCTETS)
#define GROUND_SIZES 4U
/// Size of `count` blocks with their management data.
#define GROUND_BLOCKS(octets, count) RESOURCE_ARENA_WORDS((size_t)(octets), (size_t)(count))
#define GROUND_ARENA_WORDS                                                                                   \
    (GROUND_BLOCKS(64U, 768U) + GROUND_BLOCKS(256U, 128U) + GROUND_BLOCKS(1024U, 16U) +                      \
     GROUND_BLOCKS(PUS_PACKET_MAX, 7U))

typedef struct { // Private. A report in a queue.
    uint8_t* block;
    uint32_t stamp;
    uint16_t size;
    uint8_t source;
    bool is_verification;
} ground_entry_t;

typedef struct { // Private.
    ground_entry_t* entries;
    uint16_t capacity;
    uint16_t head;
    // Number of entries from the first to the last waiting report; some between them may have been sent.
    uint16_t span;
    uint32_t limit;
    uint32_t octets;
} backlog_queue_t;

typedef struct { // A report that may be sent now.
    const uint8_t* packet;
    size_t size;
    pus_class_t class;
    uint16_t position; // Private.
} ground_report_t;

typedef struct { // Private, except `blocks` (read-only).
    resource_t blocks;
    backlog_queue_t queues[PUS_CLASSES];
    uint16_t waiting[CAPACITY_SUBSYSTEMS]; // PLAIN and BULK reports of each source.
    uint32_t next_stamp;
    ground_entry_t entries[GROUND_REPORTS];
    uint64_t arena[GROUND_ARENA_WORDS];
} ground_backlog_t;

void supervisor_ground_backlog_init(ground_backlog_t* backlog);
/// Take a block for a packet of `size` octets (> 0), with one reference; null if none is free, or if `size`
/// exceeds PUS_PACKET_MAX. The caller must return it by supervisor_ground_backlog_give.
MUST_USE uint8_t* supervisor_ground_backlog_take(ground_backlog_t* backlog, size_t size);
/// Return one reference to a block; the last one makes it free.
void supervisor_ground_backlog_give(ground_backlog_t* backlog, uint8_t* block);
/// Append a report (at most PUS_PACKET_MAX octets, with its service type) to its queue. If `block` contains
/// the report, the block gets one more reference; if `block` is null, the report is copied into a new block.
/// `source` is the number of the subsystem, below CAPACITY_SUBSYSTEMS. STATUS_OK; STATUS_FULL: its class has
/// no room, or no block.
MUST_USE status_t supervisor_ground_backlog_put(ground_backlog_t* backlog, uint8_t source,
                                                const uint8_t* packet, size_t size, uint8_t* block);
/// True if a report of this class and size, which is not in a block yet, could be appended.
bool supervisor_ground_backlog_accepts(const ground_backlog_t* backlog, pus_class_t class, size_t size);
/// Get the report to be sent next. `is_plain_open`: all classes can be sent now, not only FIRM. False if no
/// report may be sent.
bool supervisor_ground_backlog_next(const ground_backlog_t* backlog, bool is_plain_open,
                                    ground_report_t* out_report);
/// Remove a report that has been sent.
void supervisor_ground_backlog_sent(ground_backlog_t* backlog, const ground_report_t* report);
/// Copy the waiting reports into an empty ring, in order of arrival.
void supervisor_ground_backlog_copy(const ground_backlog_t* backlog, message_ring_t* ring);
/// Returns the free room for a class [octets]; 0 if its queue has no free entry.
uint32_t supervisor_ground_backlog_room(const ground_backlog_t* backlog, pus_class_t class);
/// True if there is room for the answers to the requests that are accepted now.
bool supervisor_ground_backlog_takes_requests(const ground_backlog_t* backlog);
bool supervisor_ground_backlog_is_empty(const ground_backlog_t* backlog);

#endif // FSW_SUPERVISOR_GROUND_BACKLOG_H
