// SPDX-License-Identifier: Apache-2.0
#include "pus/st14/st14_forwarding.h"

#include "base/assertion.h"
#include "generated/pus/st14_request_formats.h"

#define RECORD_KEY 0U

// Each list has four consecutive subtypes: two that change it, the request for its content and the report.
#define SUBTYPES_PER_LIST 4U
#define ANSWER_OFFSET 1U // Subtype of an answer minus that of its request.

void pus_forwarding_init(pus_forwarding_t* const forwarding, const pus_forwarding_config_t* const config)
{
    FSW_ASSERT((forwarding != NULL) && (config != NULL) && (config->apids != NULL) &&
               (config->candidate != NULL));
    *forwarding        = (pus_forwarding_t){0};
    forwarding->editor = (pus_selection_editor_t){.apids       = config->apids,
                                                  .apid_count  = config->apid_count,
                                                  .candidate   = config->candidate,
                                                  .persistence = config->persistence,
                                                  .table       = PUS_SERVICE_FORWARDING};
    pus_selection_init(&forwarding->selection, config->entries, config->capacity);
    for (uint16_t i = 0U; i < config->apid_count; i++) {
        const status_t status = pus_selection_add_process(&forwarding->selection, config->apids[i]);
        FSW_ASSERT(status == STATUS_OK); // `capacity` is large enough for the entries of all processes.
    }
}

status_t pus_forwarding_restore(pus_forwarding_t* const forwarding, const uint32_t key,
                                const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT(forwarding != NULL);
    return (key == RECORD_KEY) ? pus_selection_restore(&forwarding->selection, octets, size)
                               : STATUS_NOT_FOUND;
}

bool pus_forwarding_allows(pus_forwarding_t* const forwarding, const pus_tm_t* const tm)
{
    FSW_ASSERT(forwarding != NULL);
    const bool is_allowed = pus_selection_takes(&forwarding->selection, tm);
    if (is_allowed) {
        forwarding->counters.forwarded++;
    } else {
        forwarding->counters.held++;
    }
    return is_allowed;
}

static pus_selection_list_t list_of(const pus_request_t* const request)
{
    return (pus_selection_list_t)((request->token.subtype - 1U) / SUBTYPES_PER_LIST);
}

static pus_reply_t add(void* const self, pus_request_t* const request)
{
    pus_forwarding_t* const forwarding = self;
    return pus_selection_add(&forwarding->editor, &forwarding->selection, list_of(request), RECORD_KEY,
                             request);
}

static pus_reply_t remove_entries(void* const self, pus_request_t* const request)
{
    pus_forwarding_t* const forwarding = self;
    return pus_selection_delete(&forwarding->editor, &forwarding->selection, list_of(request), RECORD_KEY,
                                request);
}

static pus_reply_t report(void* const self, pus_request_t* const request)
{
    const pus_forwarding_t* const forwarding = self;
    pus_request_perform(request);
    pus_selection_report(&forwarding->selection, list_of(request), request,
                         (uint8_t)(request->token.subtype + ANSWER_OFFSET), NULL);
    return pus_done();
}

pus_service_t pus_forwarding_service(pus_forwarding_t* const forwarding)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(14, 1, add),
        PUS_REQUEST(14, 2, remove_entries),
        PUS_REQUEST(14, 3, report),
        PUS_REQUEST(14, 5, add),
        PUS_REQUEST(14, 6, remove_entries),
        PUS_REQUEST(14, 7, report),
        PUS_REQUEST(14, 9, add),
        PUS_REQUEST(14, 10, remove_entries),
        PUS_REQUEST(14, 11, report),
        // PUS numbers the two changes of the last list in the other order.
        PUS_REQUEST(14, 13, remove_entries),
        PUS_REQUEST(14, 14, add),
        PUS_REQUEST(14, 15, report),
    };
    return pus_service_of(PUS_SERVICE_FORWARDING, subtypes, sizeof subtypes / sizeof subtypes[0], forwarding);
}
