// SPDX-License-Identifier: Apache-2.0
/// Documents that the tests of the descriptor library read, and damage line by line.
#ifndef TEST_UNIT_FSW_FRAMEWORK_DESCRIPTOR_DOCUMENTS_H
#define TEST_UNIT_FSW_FRAMEWORK_DESCRIPTOR_DOCUMENTS_H

#include <stddef.h>

extern const char arm_document[];    ///< A subsystem descriptor with one of everything.
extern const char hand_document[];   ///< A second one, the other end of its link.
extern const char flight_document[]; ///< A mission of both.

/// `document` with the first `find` in it replaced; fails the test if it does not contain it. The result is
/// valid until the next call.
const char* damaged(const char* document, const char* find, const char* replacement);

#endif // TEST_UNIT_FSW_FRAMEWORK_DESCRIPTOR_DOCUMENTS_H
