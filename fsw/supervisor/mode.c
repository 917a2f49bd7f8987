// SPDX-License-Identifier: Apache-2.0
// The operation mode of the mission. Its persistent record {mode, since} is in the journal from the first
// step to the end of the shutdown. If a supervisor finds this record and has not taken over a checkpoint,
// the previous flight ended without a shutdown, and the state of the spacecraft is unknown: the mission
// begins in its fallback mode.
#include "fsw/supervisor/supervisor_internal.h"

#include <string.h>

/// Store the record of the mode. A mode is entered even if the record cannot be written.
static void keep(supervisor_t* const supervisor)
{
    journal_t* const journal = supervisor->config.journal;
    uint8_t octets[SUPERVISOR_MODE_RECORD];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, supervisor->mode);
    octet_write_u64(&writer, supervisor->now_ns);
    if (journal == NULL) {
        return;
    }
    status_t status = journal_put(journal, PUS_SERVICE_MISSION, 0U, octets, writer.position);
    if (status == STATUS_OK) {
        status = journal_commit(journal);
    }
    if (status != STATUS_OK) {
        spacecraft_report_refused(supervisor, PUS_SERVICE_MISSION, 0U, status);
    }
}

void supervisor_mode_set(supervisor_t* const supervisor, const uint8_t mode, const uint8_t cause)
{
    if (supervisor->mode == mode) {
        return;
    }
    const pus_mode_transition_t transition = {.previous = supervisor->mode, .mode = mode, .cause = cause};
    const uint8_t octets[2]                = {supervisor->mode, mode};
    supervisor->mode                       = mode;
    (void)pus_mode_transition_report(subsystem_process(&supervisor->subsystem), &transition,
                                     supervisor->now_ns);
    (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_MODE_CHANGED, octets, sizeof octets);
    keep(supervisor);
}

void supervisor_mode_fall_back(supervisor_t* const supervisor)
{
    supervisor_mode_set(supervisor, supervisor->mission->fallback_mode, (uint8_t)PUS_CAUSE_OWN_ERROR);
}

status_t supervisor_mode_restore(supervisor_t* const supervisor, const uint8_t* const octets,
                                 const size_t size)
{
    if (size != sizeof supervisor->cut_off) {
        return STATUS_INVALID;
    }
    (void)memcpy(supervisor->cut_off, octets, sizeof supervisor->cut_off);
    supervisor->is_cut_off = !supervisor->is_adopted;
    return STATUS_OK;
}

void supervisor_mode_begin(supervisor_t* const supervisor)
{
    if (supervisor->is_cut_off) {
        (void)subsystem_raise(&supervisor->subsystem, SUPERVISOR_EVENT_FLIGHT_INTERRUPTED,
                              supervisor->cut_off, sizeof supervisor->cut_off);
        supervisor_mode_fall_back(supervisor);
    }
    if (!supervisor->is_adopted) {
        keep(supervisor);
    }
}

void supervisor_mode_end(supervisor_t* const supervisor)
{
    journal_t* const journal = supervisor->config.journal;
    if ((journal != NULL) && (journal_erase(journal, PUS_SERVICE_MISSION, 0U) == STATUS_OK)) {
        (void)journal_commit(journal); // If the commit fails, the next flight begins in the fallback mode.
    }
}
