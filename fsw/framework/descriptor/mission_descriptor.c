// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/mission_descriptor.h"

#include "base/assertion.h"

#include <string.h>

typedef char
    subsystems_fit[(offsetof(mission_subsystem_t, apid) == offsetof(descriptor_event_t, id)) ? 1 : -1];

void descriptor_mission_use_storage(mission_descriptor_t* const mission)
{
    FSW_ASSERT(mission != NULL);
    const mission_storage_t* const storage = &mission->storage;
    mission->subsystems                    = storage->subsystems;
    mission->modes                         = storage->modes;
    mission->rules                         = storage->rules;
    mission->links                         = storage->links;
    mission->plans                         = storage->plans;
    mission->actions                       = storage->actions;
    mission->buses                         = storage->buses;
    mission->users                         = storage->users;
}

void descriptor_mission_clear(mission_descriptor_t* const mission)
{
    FSW_ASSERT(mission != NULL);
    (void)memset(mission, 0, sizeof *mission);
    mission->name = "";
    descriptor_mission_use_storage(mission);
}

const mission_subsystem_t* descriptor_mission_find_subsystem(const mission_descriptor_t* const mission,
                                                             const uint16_t apid)
{
    FSW_ASSERT(mission != NULL);
    return descriptor_numbered(mission->subsystems, mission->subsystem_count, sizeof mission->subsystems[0],
                               apid);
}
