// SPDX-License-Identifier: Apache-2.0
/// Reports that wait for the way to ground, by class (pus/traffic_class.h), and the blocks they lie in.
///
/// One packet is one block with a count of its holders: whoever routes it holds it while it is logged and
/// observed, and a line holds it until it has left. So a report that waits is not copied again. The blocks of
/// four sizes come from one arena; of each size some are for FIRM reports alone. Without a block a report
/// cannot wait, and the rule of its class decides.
///
/// Order      Reports leave in the order they came. While the way is open for FIRM reports only, these
/// overtake
///            the others; but a verification (ST[01]) does not overtake what its own subsystem said before.
/// Ownership  The caller places it. Context: one loop. Time: O(reports of the class).
#ifndef FSW_SUPERVISOR_GROUND_BACKLOG_H
#define FSW_SUPERVISOR_GROUND_BACKLOG_H

#include "fsw/framework/base/capacities.h"
#include "fsw/framework/message/octet_ring.h"
#include "fsw/framework/resource/resource.h"
#include "pus/traffic_class.h"

#define GROUND_FIRM_OCTETS 32768U
#define GROUND_PLAIN_OCTETS 16384U
#define GROUND_BULK_OCTETS 16384U
/// With less room for FIRM reports no request is taken in: octets, and reports that fit the smallest blocks.
#define GROUND_FIRM_INTAKE 8192U
#define GROUND_FIRM_INTAKE_REPORTS 128U
#define GROUND_FIRM_REPORTS 512U
#define GROUND_PLAIN_REPORTS 256U
#define GROUND_BULK_REPORTS 256U
#define GROUND_REPORTS (GROUND_FIRM_REPORTS + GROUND_PLAIN_REPORTS + GROUND_BULK_REPORTS)
#define GROUND_OCTETS (GROUND_FIRM_OCTETS + GROUND_PLAIN_OCTETS + GROUND_BULK_OCTETS)
#define GROUND_SIZES 4U
/// Blocks of a size and their bookkeeping.
#define GROUND_BLOCKS(octets, count) RESOURCE_ARENA_WORDS((size_t)(octets), (size_t)(count))
#define GROUND_ARENA_WORDS                                                                                   \
    (GROUND_BLOCKS(64U, 512U) + GROUND_BLOCKS(256U, 96U) + GROUND_BLOCKS(1024U, 16U) +                       \
     GROUND_BLOCKS(PUS_PACKET_MAX, 7U))

typedef struct { // Private. A report in a line.
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
    uint16_t span; // From the head to the last one; in between some may have left.
    uint32_t limit;
    uint32_t octets;
} ground_line_t;

typedef struct { // A report that may leave now.
    const uint8_t* packet;
    size_t size;
    pus_class_t class;
    uint16_t place; // Private.
} ground_report_t;

typedef struct { // Private, except `blocks`, to be read.
    resource_t blocks;
    ground_line_t lines[PUS_CLASSES];
    uint16_t waiting[CAPACITY_SUBSYSTEMS]; // PLAIN and BULK reports of each source.
    uint32_t next_stamp;
    ground_entry_t entries[GROUND_REPORTS];
    uint64_t arena[GROUND_ARENA_WORDS];
} ground_backlog_t;

void ground_backlog_init(ground_backlog_t* backlog);
/// A block for a packet, with one holder; null: none is left. The caller gives it back.
MUST_USE uint8_t* ground_backlog_take(ground_backlog_t* backlog, size_t size);
void ground_backlog_give(ground_backlog_t* backlog, uint8_t* block);
/// Let a report wait that lies in `block`, which gets one more holder, or, if that is null, is copied into
/// one. `source` numbers the subsystems, below CAPACITY_SUBSYSTEMS. STATUS_OK; STATUS_FULL: its class has no
/// room.
MUST_USE status_t ground_backlog_put(ground_backlog_t* backlog, uint8_t source, const uint8_t* packet,
                                     size_t size, uint8_t* block);
/// True if a report of the class and size, in no block yet, could wait.
bool ground_backlog_accepts(const ground_backlog_t* backlog, pus_class_t class, size_t size);
/// The report that leaves next; `is_plain_open`: the way is open for all classes. False: none may leave.
bool ground_backlog_next(const ground_backlog_t* backlog, bool is_plain_open, ground_report_t* out_report);
/// It has left.
void ground_backlog_sent(ground_backlog_t* backlog, const ground_report_t* report);
/// Copy what waits into an empty ring, in the order it came.
void ground_backlog_copy(const ground_backlog_t* backlog, octet_ring_t* ring);
/// Octets that reports of a class may still have.
uint32_t ground_backlog_room(const ground_backlog_t* backlog, pus_class_t class);
/// True if there is room for what answers the requests that are taken in meanwhile.
bool ground_backlog_takes_requests(const ground_backlog_t* backlog);
bool ground_backlog_is_empty(const ground_backlog_t* backlog);

#endif // FSW_SUPERVISOR_GROUND_BACKLOG_H
