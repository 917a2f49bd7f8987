// SPDX-License-Identifier: Apache-2.0
/// A report of many entries in as many packets as they need, over as many steps as the port needs to take
/// them: none is lost because the port is full. Each packet is {octets in front, count (u16), entries};
/// there is at least one, with count 0 if there is no entry.
///
/// Ownership  A value of the service; one report at a time. Built in the buffer of the process.
/// Context    One loop.
/// Time       PUS_LONG_REPORT_PACKETS packets a call at most.
#ifndef PUS_CORE_LONG_REPORT_H
#define PUS_CORE_LONG_REPORT_H

#include "pus/core/service.h"

#define PUS_LONG_REPORT_PACKETS 4U ///< In a call, so that a step stays short.
#define PUS_LONG_REPORT_FRONT 8U   ///< Octets before the count, at most.

/// Position of the next entry; the service defines the numbers.
typedef struct {
    uint64_t first;
    uint64_t second;
} pus_report_cursor_t;

/// Source of the entries.
typedef struct {
    void* self;
    /// Write the entry at or after the cursor, and move the cursor past it. False: there is none. If the
    /// entry does not fit, the writer fails, and the change of the cursor is undone.
    bool (*write)(void* self, pus_report_cursor_t* cursor, octet_writer_t* writer);
} pus_report_entries_t;

typedef struct {    // Private, except is_active and subtype: read-only.
    bool is_active; ///< It continues in the next step.
    uint8_t subtype;
    uint8_t front_size;
    uint16_t refused; // Instructions of the request.
    uint8_t front[PUS_LONG_REPORT_FRONT];
    pus_token_t token;
    pus_report_cursor_t cursor;
} pus_long_report_t;

/// Begin a report in answer to a request, some of whose instructions may have been refused before: PUS_DONE
/// if all of it was sent, PUS_STARTED if it continues. Sends TM[1,3] first. `front` may be null if front_size
/// is 0.
pus_reply_t pus_long_report_begin(pus_long_report_t* report, pus_request_t* request, uint8_t subtype,
                                  const pus_report_entries_t* entries, const pus_report_cursor_t* cursor,
                                  const uint8_t* front, size_t front_size);
/// Continue an active report; completes its request after the last packet.
void pus_long_report_go_on(pus_long_report_t* report, pus_app_process_t* process,
                           const pus_report_entries_t* entries, uint64_t now_ns);

#endif // PUS_CORE_LONG_REPORT_H
