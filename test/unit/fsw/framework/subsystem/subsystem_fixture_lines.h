// SPDX-License-Identifier: Apache-2.0
/// Reports as lines of text, for subsystem_fixture.c.
#ifndef TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_FIXTURE_LINES_H
#define TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_FIXTURE_LINES_H

#include <stddef.h>
#include <stdint.h>

/// Add the line of a report; the test fails if the packet is malformed.
void fixture_line_of_report(const uint8_t* packet, size_t size);

#endif // TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_FIXTURE_LINES_H
