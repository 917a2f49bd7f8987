// SPDX-License-Identifier: Apache-2.0
/// A file as the medium of a journal or a packet store. The file is open for update and outlives the medium.
#ifndef FSW_PROGRAMS_FILE_MEDIUM_H
#define FSW_PROGRAMS_FILE_MEDIUM_H

#include "base/medium.h"
#include "osal/include/osal/file.h"

medium_t file_medium(osal_file_t* file);

#endif // FSW_PROGRAMS_FILE_MEDIUM_H
