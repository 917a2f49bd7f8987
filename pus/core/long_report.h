// SPDX-License-Identifier: Apache-2.0
/// A report of many entries, in as many packets as the entries need. If the port is full, the report
/// continues in later steps, so that no packet is lost. Each packet is {octets in front, count (u16),
/// entries}; a report without entries is one packet with count 0.
///
/// Ownership  The service provides pus_long_report_t, one report at a time. Packets are built in the buffer
///            of the process.
/// Context    One loop.
/// Time       At most PUS_LONG_REPORT_PACKETS packets in a call.
#ifndef PUS_CORE_LONG_REPORT_H
#define PUS_CORE_LONG_REPORT_H

#include "pus/core/service.h"

/// Largest number of packets sent in one call, so that a step stays short.
#define PUS_LONG_REPORT_PACKETS 4U
#define PUS_LONG_REPORT_FRONT 8U ///< Largest number of octets before the count.

/// Position of the next entry; the service defines the numbers.
typedef struct {
    uint64_t first;
    uint64_t second;
} pus_report_cursor_t;

/// Source of the entries.
typedef struct {
    void* self;
    /// Write the entry at or after the cursor, and move the cursor past this entry. False: there is no
    /// further entry. If an entry does not fit, the writer fails, and the caller restores the cursor. Each
    /// entry fits a packet that has no other.
    bool (*write)(void* self, pus_report_cursor_t* cursor, octet_writer_t* writer);
} pus_report_entries_t;

typedef struct {    // Private, except is_active and subtype: read-only.
    bool is_active; ///< The report continues in the next step.
    uint8_t subtype;
    uint8_t front_size;
    uint16_t refused; // Number of refused instructions of the request.
    uint8_t front[PUS_LONG_REPORT_FRONT];
    pus_token_t token;
    pus_report_cursor_t cursor;
} pus_long_report_t;

/// Begin a report that answers a request, some of whose instructions may have been refused. TM[1,3] is sent
/// first. Returns PUS_DONE if the whole report was sent, PUS_STARTED if it continues. `front` may be null if
/// front_size is 0.
pus_reply_t pus_long_report_begin(pus_long_report_t* report, pus_request_t* request, uint8_t subtype,
                                  const pus_report_entries_t* entries, const pus_report_cursor_t* cursor,
                                  const uint8_t* front, size_t front_size);
/// Continue an active report; its request is completed after the last packet.
void pus_long_report_go_on(pus_long_report_t* report, pus_app_process_t* process,
                           const pus_report_entries_t* entries, uint64_t now_ns);

#endif // PUS_CORE_LONG_REPORT_H
