// SPDX-License-Identifier: Apache-2.0
// Look-ups of the supervisor in a mission; subsystems do not use them.
#include "base/assertion.h"
#include "fsw/framework/descriptor/mission_descriptor.h"

const mission_mode_t* descriptor_mission_find_mode(const mission_descriptor_t* const mission,
                                                   const uint8_t id)
{
    FSW_ASSERT(mission != NULL);
    for (uint16_t i = 0U; i < mission->mode_count; i++) {
        if (mission->modes[i].id == id) {
            return &mission->modes[i];
        }
    }
    return NULL;
}

const mission_link_t* descriptor_mission_find_link(const mission_descriptor_t* const mission,
                                                   const uint16_t producer_apid, const uint16_t producer_port,
                                                   const uint16_t consumer_apid, const uint16_t consumer_port)
{
    FSW_ASSERT(mission != NULL);
    for (uint16_t i = 0U; i < mission->link_count; i++) {
        const mission_link_t* const link = &mission->links[i];
        if ((link->producer_apid == producer_apid) && (link->producer_port == producer_port) &&
            (link->consumer_apid == consumer_apid) && (link->consumer_port == consumer_port)) {
            return link;
        }
    }
    return NULL;
}

const mission_plan_t* descriptor_mission_find_plan(const mission_descriptor_t* const mission,
                                                   const descriptor_severity_t severity, const uint16_t apid,
                                                   const uint16_t event_id)
{
    FSW_ASSERT(mission != NULL);
    for (uint16_t i = 0U; i < mission->plan_count; i++) {
        const mission_plan_t* const plan = &mission->plans[i];
        if ((plan->severity == severity) && ((plan->apid == MISSION_ANY_TARGET) || (plan->apid == apid)) &&
            ((plan->event_id == 0U) || (plan->event_id == event_id))) {
            return plan;
        }
    }
    return NULL;
}
