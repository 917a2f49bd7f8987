// SPDX-License-Identifier: Apache-2.0
/// The mission of the test bed, in files of a folder of its own.
#ifndef TEST_UNIT_FSW_SUPERVISOR_BED_MISSION_H
#define TEST_UNIT_FSW_SUPERVISOR_BED_MISSION_H

#include "fsw/framework/descriptor/descriptor.h"

/// Write the descriptors into the folder, load mission and the supervisor's own, remove the files.
void bed_mission_load(const char* folder, mission_descriptor_t* out_mission,
                      subsystem_descriptor_t* out_supervisor);

#endif // TEST_UNIT_FSW_SUPERVISOR_BED_MISSION_H
