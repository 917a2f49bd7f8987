// SPDX-License-Identifier: Apache-2.0
/// Documents for the tests of the descriptor library, which change single lines of them.
#ifndef TEST_UNIT_FSW_FRAMEWORK_DESCRIPTOR_DOCUMENTS_H
#define TEST_UNIT_FSW_FRAMEWORK_DESCRIPTOR_DOCUMENTS_H

#include <stddef.h>

extern const char arm_document[];    ///< A subsystem descriptor that has every element at least once.
extern const char hand_document[];   ///< A second one with the other end of the link of the first.
extern const char flight_document[]; ///< A mission of both subsystems.

/// `document` with its first `find` replaced. Fails the test if `document` does not contain it. The result is
/// valid until the next call.
const char* damaged(const char* document, const char* find, const char* replacement);

#endif // TEST_UNIT_FSW_FRAMEWORK_DESCRIPTOR_DOCUMENTS_H
