// SPDX-License-Identifier: Apache-2.0
/// A scenario file that exists during one test.
#ifndef TEST_UNIT_SIM_OPERATOR_SCRIPT_FILE_H
#define TEST_UNIT_SIM_OPERATOR_SCRIPT_FILE_H

/// Write `text` to a new file; the path is valid until the next call. Fails the test if the
/// file cannot be written.
const char* script_file_write(const char* text);

/// Remove the file if there is one.
void script_file_remove(void);

#endif // TEST_UNIT_SIM_OPERATOR_SCRIPT_FILE_H
