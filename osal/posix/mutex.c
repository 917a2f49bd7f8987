// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/mutex.h"

#include "fsw/framework/base/assertion.h"

#include <errno.h>
#include <pthread.h>
#include <stddef.h>

// Zeros are a lock that works in this C library, and in others none: the last word tells whether one was
// made.
#define MARK_WORD (OSAL_MUTEX_WORDS - 1U)
#define MARK 0x6D757465782E2E2EULL // "mutex..."

typedef char mutex_fits_before_the_mark[(sizeof(pthread_mutex_t) <= (MARK_WORD * sizeof(uint64_t))) ? 1 : -1];

static pthread_mutex_t* native(osal_mutex_t* mutex)
{
    return (pthread_mutex_t*)(void*)mutex->storage;
}

status_t osal_mutex_create(osal_mutex_t* mutex, bool is_shared)
{
    FSW_ASSERT(mutex != NULL);
    pthread_mutexattr_t attributes;
    if (pthread_mutexattr_init(&attributes) != 0) {
        return STATUS_UNSUPPORTED;
    }
    const int sharing = is_shared ? PTHREAD_PROCESS_SHARED : PTHREAD_PROCESS_PRIVATE;
    bool is_good      = (pthread_mutexattr_setpshared(&attributes, sharing) == 0);
    is_good           = is_good && (pthread_mutexattr_setprotocol(&attributes, PTHREAD_PRIO_INHERIT) == 0);
    is_good           = is_good && (pthread_mutexattr_setrobust(&attributes, PTHREAD_MUTEX_ROBUST) == 0);
    is_good           = is_good && (pthread_mutexattr_settype(&attributes, PTHREAD_MUTEX_ERRORCHECK) == 0);
    is_good           = is_good && (pthread_mutex_init(native(mutex), &attributes) == 0);
    (void)pthread_mutexattr_destroy(&attributes);
    mutex->storage[MARK_WORD] = is_good ? MARK : 0U;
    return is_good ? STATUS_OK : STATUS_UNSUPPORTED;
}

status_t osal_mutex_lock(osal_mutex_t* mutex)
{
    FSW_ASSERT((mutex != NULL) && (mutex->storage[MARK_WORD] == MARK));
    const int result = pthread_mutex_lock(native(mutex));
    if (result == EOWNERDEAD) {
        const int repaired = pthread_mutex_consistent(native(mutex));
        FSW_ASSERT(repaired == 0);
        return STATUS_CLOSED;
    }
    FSW_ASSERT(result == 0); // EDEADLK: locked twice by one task.
    return STATUS_OK;
}

void osal_mutex_unlock(osal_mutex_t* mutex)
{
    FSW_ASSERT((mutex != NULL) && (mutex->storage[MARK_WORD] == MARK));
    const int result = pthread_mutex_unlock(native(mutex));
    FSW_ASSERT(result == 0); // EPERM: not the holder.
}

void osal_mutex_destroy(osal_mutex_t* mutex)
{
    FSW_ASSERT(mutex != NULL);
    mutex->storage[MARK_WORD] = 0U;
    (void)pthread_mutex_destroy(native(mutex));
}
