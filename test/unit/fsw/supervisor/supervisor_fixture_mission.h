// SPDX-License-Identifier: Apache-2.0
/// The mission of the test fixture, in files in a directory of its own.
#ifndef TEST_UNIT_FSW_SUPERVISOR_SUPERVISOR_FIXTURE_MISSION_H
#define TEST_UNIT_FSW_SUPERVISOR_SUPERVISOR_FIXTURE_MISSION_H

#include "fsw/framework/descriptor/descriptor.h"

/// Write the descriptors into the directory, load the mission and the supervisor's descriptor, and remove the
/// files.
void fixture_mission_load(const char* directory, mission_descriptor_t* out_mission,
                          subsystem_descriptor_t* out_supervisor);

#endif // TEST_UNIT_FSW_SUPERVISOR_SUPERVISOR_FIXTURE_MISSION_H
