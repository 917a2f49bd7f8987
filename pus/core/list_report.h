// SPDX-License-Identifier: Apache-2.0
/// A report with a list of entries, in as many packets as the entries need. Each packet begins with the same
/// prefix, if any, and the count of its own entries. A list without entries is one packet with the count 0.
///
///     pus_list_report_t list;
///     pus_list_report_begin(&list, &target, NULL, 0U);
///     octet_write_u16(pus_list_report_entry(&list, 2U), id);
///     return pus_list_report_end(&list);
///
/// Ownership  The report is built in the buffer of the process, which builds one report at a time.
/// Context    The loop of the process.
#ifndef PUS_CORE_LIST_REPORT_H
#define PUS_CORE_LIST_REPORT_H

#include "pus/core/service.h"

#define PUS_LIST_PREFIX_MAX 16U ///< Octets before the count.
/// Largest entry [octets].
#define PUS_LIST_ENTRY_MAX (PUS_TM_DATA_MAX - PUS_LIST_PREFIX_MAX - 2U)

/// Type, receiver and time of the report.
typedef struct {
    /// Request that the report answers; null: it answers none, and a packet that the process can neither send
    /// nor keep is lost.
    pus_request_t* request;
    pus_app_process_t* process;
    uint8_t service;
    uint8_t subtype;
    uint16_t destination;
    uint64_t now_ns;
} pus_list_target_t;

typedef struct { // Private.
    pus_list_target_t target;
    octet_writer_t writer;
    uint8_t* head;  // Position of the count in the packet.
    uint16_t count; // Entries in the present packet.
    uint16_t lost;  // Packets that the process could neither send nor keep.
    uint8_t prefix_size;
    uint8_t prefix[PUS_LIST_PREFIX_MAX];
} pus_list_report_t;

/// Target of a report that answers a request and may continue in later steps (pus_answer_send).
pus_list_target_t pus_list_answer(pus_request_t* request, uint8_t subtype);
/// Begin a report. `prefix` (0..PUS_LIST_PREFIX_MAX octets; may be null if 0) is copied.
void pus_list_report_begin(pus_list_report_t* list, const pus_list_target_t* target, const uint8_t* prefix,
                           size_t prefix_size);
/// Begin an entry of at most `size` octets (<= PUS_LIST_ENTRY_MAX), in a new packet if the present one has
/// no room for it. The writer is valid until the next call.
octet_writer_t* pus_list_report_entry(pus_list_report_t* list, size_t size);
/// Send the last packet. PUS_DONE; PUS_STARTED: the report continues in a later step; PUS_FAILED with
/// PUS_FAILURE_SOME_FAILED and the number of packets that the process could neither send nor keep.
pus_reply_t pus_list_report_end(pus_list_report_t* list);

#endif // PUS_CORE_LIST_REPORT_H
