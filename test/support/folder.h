// SPDX-License-Identifier: Apache-2.0
/// Folder in which a portable test makes its files. The build for a board sets another one.
#ifndef TEST_SUPPORT_FOLDER_H
#define TEST_SUPPORT_FOLDER_H

#ifndef TEST_FOLDER
#define TEST_FOLDER "/tmp"
#endif

#endif // TEST_SUPPORT_FOLDER_H
