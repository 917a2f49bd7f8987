// SPDX-License-Identifier: Apache-2.0
// This is a separate file, because only programs that react to events of other processes need it.
#include "base/assertion.h"
#include "pus/st05/st05_events.h"
#include "pus/private/st129_management.h"

static bool is_severity(const uint8_t value)
{
    return (value >= (uint8_t)PUS_SEVERITY_INFORMATIVE) && (value <= (uint8_t)PUS_SEVERITY_HIGH);
}

status_t pus_event_occurrence_read(const pus_tm_t* const tm, pus_event_occurrence_t* const out_occurrence)
{
    FSW_ASSERT((tm != NULL) && (out_occurrence != NULL));
    octet_reader_t reader     = octet_reader(tm->data, tm->size);
    pus_event_notice_t notice = {0};
    status_t status           = STATUS_NOT_FOUND;
    if ((tm->service == PUS_SERVICE_EVENTS) && is_severity(tm->subtype)) {
        notice.severity = tm->subtype;
        notice.event    = octet_read_u16(&reader); // Auxiliary data may follow, which are not read.
        status          = reader.failed ? STATUS_INVALID : STATUS_OK;
    } else if ((tm->service == PUS_SERVICE_MANAGEMENT) && (tm->subtype == (uint8_t)PUS_MANAGEMENT_NOTICE)) {
        status = pus_event_notice_read(&reader, &notice);
        status = ((status == STATUS_OK) && !is_severity(notice.severity)) ? STATUS_INVALID : status;
    } else {
        // The report is not about an event.
    }
    *out_occurrence =
        (pus_event_occurrence_t){.apid = tm->apid, .event = notice.event, .severity = notice.severity};
    return status;
}
