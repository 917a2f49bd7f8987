// SPDX-License-Identifier: Apache-2.0
/// A report that is a list, over as many packets as its entries need: each packet begins with the same
/// octets, if any, and the count of its own entries. There is at least one packet, with count 0 if there is
/// no entry.
///
///     pus_list_report_t list;
///     pus_list_report_begin(&list, &target, NULL, 0U);
///     octet_write_u16(pus_list_report_entry(&list, 2U), id);
///     return pus_list_report_end(&list);
///
/// Ownership  Built in the buffer of the process: one report at a time.
/// Context    The loop of the process.
#ifndef PUS_CORE_LIST_REPORT_H
#define PUS_CORE_LIST_REPORT_H

#include "pus/core/service.h"

#define PUS_LIST_PREFIX_MAX 16U ///< Octets before the count.
#define PUS_LIST_ENTRY_MAX (PUS_TM_DATA_MAX - PUS_LIST_PREFIX_MAX - 2U)

/// Which report, and to whom.
typedef struct {
    pus_request_t*
        request; ///< The request it answers; null: none, and packets that the port refuses are lost.
    pus_app_process_t* process;
    uint8_t service;
    uint8_t subtype;
    uint16_t destination;
    uint64_t now_ns;
} pus_list_target_t;

typedef struct { // Private.
    pus_list_target_t target;
    octet_writer_t writer;
    uint8_t* head;  // Place of the count in the packet.
    uint16_t count; // Entries in the present packet.
    uint16_t lost;  // Packets the process could not keep.
    uint8_t prefix_size;
    uint8_t prefix[PUS_LIST_PREFIX_MAX];
} pus_list_report_t;

/// The report in answer to a request, which continues in later steps: see pus_answer_send.
pus_list_target_t pus_list_answer(pus_request_t* request, uint8_t subtype);
/// Begin; `prefix` (0..PUS_LIST_PREFIX_MAX octets, may be null if none) is copied.
void pus_list_report_begin(pus_list_report_t* list, const pus_list_target_t* target, const uint8_t* prefix,
                           size_t prefix_size);
/// Begin an entry of at most `size` octets (<= PUS_LIST_ENTRY_MAX), in a new packet if the present one has
/// no room for it. The writer is valid until the next call.
octet_writer_t* pus_list_report_entry(pus_list_report_t* list, size_t size);
/// Send the last packet. PUS_DONE; PUS_STARTED: it continues in a later step; PUS_FAILED with
/// PUS_FAILURE_SOME_FAILED and the number of packets that were lost, since neither port nor process took
/// them.
pus_reply_t pus_list_report_end(pus_list_report_t* list);

#endif // PUS_CORE_LIST_REPORT_H
