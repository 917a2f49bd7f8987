// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/mission_descriptor.h"

#include "base/assertion.h"

typedef char
    subsystems_fit[(offsetof(mission_subsystem_t, apid) == offsetof(descriptor_event_t, id)) ? 1 : -1];

const mission_subsystem_t* descriptor_mission_find_subsystem(const mission_descriptor_t* const mission,
                                                             const uint16_t apid)
{
    FSW_ASSERT(mission != NULL);
    return descriptor_numbered(mission->subsystems, mission->subsystem_count, sizeof mission->subsystems[0],
                               apid);
}
