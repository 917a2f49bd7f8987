// SPDX-License-Identifier: Apache-2.0
/// Reads the key of the ground link from FILE and the mark of its sessions from FILE.received; `gse key make
/// FILE` generates both. Only the receiver keeps a copy of the key.
///
/// Ownership  The program provides ground_key_t in static storage.
/// Context    One task.
#ifndef FSW_PROGRAMS_GROUND_KEY_H
#define FSW_PROGRAMS_GROUND_KEY_H

#include "fsw/framework/sdls/sdls.h"
#include "osal/include/osal/file.h"

#define GROUND_KEY_ERROR_MAX 384U

typedef struct { // Private, except the receiver.
    osal_file_t mark;
    sdls_receiver_t receiver;
} ground_key_t;

/// Open the receiver, and lock the mark against other programs until ground_key_close. False: the receiver
/// is closed and refuses every frame; `error` names the file, the cause and the next step.
bool ground_key_open(ground_key_t* key, const char* path, char error[GROUND_KEY_ERROR_MAX]);
void ground_key_close(ground_key_t* key);

#endif // FSW_PROGRAMS_GROUND_KEY_H
