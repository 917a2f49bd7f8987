// SPDX-License-Identifier: Apache-2.0
/// A directory of the operating system as the store of the file service. The root is open and outlives the
/// store.
#ifndef FSW_PROGRAMS_FILE_STORE_H
#define FSW_PROGRAMS_FILE_STORE_H

#include "osal/include/osal/directory.h"
#include "pus/core/file_store.h"

pus_file_store_t file_store(osal_directory_t* root);

#endif // FSW_PROGRAMS_FILE_STORE_H
