// SPDX-License-Identifier: Apache-2.0
// Connects ST[14] to the supervisor: selects the reports that are forwarded to ground. All reports are logged
// and stored.
#include "fsw/supervisor/services/spacecraft_services.h"

#include "fsw/supervisor/supervisor_internal.h"

static pus_service_t open_forwarding(supervisor_t* const supervisor)
{
    spacecraft_forwarding_t* const forwarding = &supervisor->spacecraft.forwarding;
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        forwarding->apids[i] = supervisor->mission->subsystems[i].apid;
    }
    const pus_forwarding_config_t config = {.apids       = forwarding->apids,
                                            .apid_count  = supervisor->mission->subsystem_count,
                                            .entries     = forwarding->entries,
                                            .candidate   = forwarding->candidate,
                                            .capacity    = SPACECRAFT_FORWARDING_ENTRIES,
                                            .persistence = spacecraft_persistence(supervisor)};
    pus_forwarding_init(&forwarding->service, &config);
    return pus_forwarding_service(&forwarding->service);
}

static status_t restore_forwarding(supervisor_t* const supervisor, const uint32_t key,
                                   const uint8_t* const octets, const size_t size)
{
    return pus_forwarding_restore(&supervisor->spacecraft.forwarding.service, key, octets, size);
}

bool spacecraft_forwards(supervisor_t* const supervisor, const pus_tm_t* const tm)
{
    return pus_forwarding_allows(&supervisor->spacecraft.forwarding.service, tm);
}

const spacecraft_binding_t spacecraft_forwarding = {
    .type = PUS_SERVICE_FORWARDING, .open = open_forwarding, .restore = restore_forwarding};
