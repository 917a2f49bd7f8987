// SPDX-License-Identifier: Apache-2.0
// Decides whether the known state of a subsystem is reliable. While the supervisor receives no report of a
// subsystem, the subsystem may have changed to a lower state; the first reports after the silence may be
// older than that change. Therefore the supervisor requests the status after a silence. When this request
// has completed, the state is reliable, because reports arrive in order.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"

/// Silence after which the state is in doubt: a running subsystem reports its status once per second.
#define DOUBT_AFTER_NS 1500000000ULL
#define ASK_AGAIN_NS 1000000000ULL ///< Time after which an unanswered request for the status is repeated.

bool supervisor_doubt_exists(const registry_entry_t* const entry)
{
    return entry->doubt != DOUBT_NONE;
}

static void ask(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    pus_token_t token     = {.request_id = 0U};
    octet_writer_t writer = pus_tc_begin(&supervisor->requester, entry->mission->apid, PUS_SERVICE_MANAGEMENT,
                                         PUS_MANAGEMENT_REPORT_STATUS, PUS_ACK_COMPLETION);
    if (pus_tc_send(&supervisor->requester, &writer, &token) == STATUS_OK) {
        entry->doubt            = DOUBT_ASKED;
        entry->asked.request_id = token.request_id;
        entry->asked.time_ns    = supervisor->now_ns;
        supervisor->reactions.asked++;
    }
}

static void watch_subsystem(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    const uint64_t now_ns = supervisor->now_ns;
    const bool is_silent  = (now_ns - entry->heard_ns) > DOUBT_AFTER_NS;
    if ((entry->process != PROCESS_RUNNING) || !entry->is_heard) {
        entry->doubt = DOUBT_NONE; // A new process starts in OFFLINE.
    } else if (is_silent) {
        entry->doubt = DOUBT_SILENT;
    } else if ((entry->doubt == DOUBT_SILENT) ||
               ((entry->doubt == DOUBT_ASKED) && ((now_ns - entry->asked.time_ns) > ASK_AGAIN_NS))) {
        ask(supervisor, entry);
    } else {
        // Its reports arrive regularly, or its status was requested recently.
    }
}

void supervisor_doubt_watch(supervisor_t* const supervisor)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        if (supervisor->registry[i].mission->apid != SUPERVISOR_APID) {
            watch_subsystem(supervisor, &supervisor->registry[i]);
        }
    }
}

void supervisor_doubt_verification(supervisor_t* const supervisor, const pus_tm_t* const tm,
                                   const pus_verification_t* const verification)
{
    registry_entry_t* const entry = supervisor_registry_find(supervisor, tm->apid);
    FSW_ASSERT(entry != NULL); // A report is routed only if its APID is that of the subsystem that sent it.
    const bool is_answer = (entry->doubt == DOUBT_ASKED) && (tm->destination == PUS_USER_SUPERVISOR) &&
                           (verification->request_id == entry->asked.request_id) &&
                           (verification->failure.code == PUS_FAILURE_NONE);
    if (!is_answer) {
        return;
    }
    entry->doubt = DOUBT_NONE;
    // A subsystem in OFFLINE has closed its links, but its reports of the closed links were lost.
    if (entry->state == STATE_OFFLINE) {
        supervisor_link_manager_member_lost(supervisor, tm->apid);
    }
}
