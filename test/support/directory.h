// SPDX-License-Identifier: Apache-2.0
/// Directory in which a portable test makes its files. The build for a board sets another one.
#ifndef TEST_SUPPORT_DIRECTORY_H
#define TEST_SUPPORT_DIRECTORY_H

#ifndef TEST_DIRECTORY
#define TEST_DIRECTORY "/tmp"
#endif

#endif // TEST_SUPPORT_DIRECTORY_H
