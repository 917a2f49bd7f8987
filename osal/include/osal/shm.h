// SPDX-License-Identifier: Apache-2.0
/// Named shared memory. The creator sets the size; the memory initially contains zeros.
///
/// Names      '/' and then 1..60 of [A-Za-z0-9._-], but neither "." nor ".." alone.
/// Ownership  Mappings stay valid after removal of the name until closed.
#ifndef OSAL_SHM_H
#define OSAL_SHM_H

#include "base/status.h"

#include <stddef.h>

typedef struct { // Private.
    void* address;
    size_t size;
} osal_shm_t;

/// Create and map a shared memory. STATUS_OK, STATUS_EXISTS, STATUS_INVALID (name or size 0),
/// STATUS_EXHAUSTED (no memory, or no descriptor left), STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_shm_create(osal_shm_t* shm, const char* name, size_t size);
/// Map the whole of an existing shared memory. STATUS_OK, STATUS_NOT_FOUND (also: its creator has not set the
/// size yet), STATUS_INVALID (name), STATUS_DENIED, STATUS_IO.
MUST_USE status_t osal_shm_open(osal_shm_t* shm, const char* name);
void* osal_shm_address(const osal_shm_t* shm);
size_t osal_shm_size(const osal_shm_t* shm);
void osal_shm_close(osal_shm_t* shm);
/// Remove the name; existing mappings stay valid. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID, STATUS_DENIED.
status_t osal_shm_remove(const char* name);

/// Call `visit` with the name of every shared memory that begins with `prefix` ('/' included); `visit` may
/// remove it. STATUS_OK; STATUS_UNSUPPORTED where names cannot be listed.
status_t osal_shm_each(const char* prefix, void (*visit)(void* context, const char* name), void* context);

#endif // OSAL_SHM_H
