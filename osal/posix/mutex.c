// SPDX-License-Identifier: Apache-2.0
#include "osal/include/osal/mutex.h"

#include "base/assertion.h"

#include <errno.h>
#include <linux/futex.h>
#include <pthread.h>
#include <stddef.h>
#include <time.h>

#define NS_PER_S 1000000000ULL

// A mutex of zeros is a working lock in this C library, but not in others. Therefore the last word records
// whether the lock was initialized.
#define MARK_WORD (OSAL_MUTEX_WORDS - 1U)
#define MARK 0x6D757465782E2E2EULL // "mutex..."

typedef char mutex_fits_before_the_mark[(sizeof(pthread_mutex_t) <= (MARK_WORD * sizeof(uint64_t))) ? 1 : -1];

static pthread_mutex_t* native(osal_mutex_t* const mutex)
{
    return (pthread_mutex_t*)(void*)mutex->storage;
}

status_t osal_mutex_create(osal_mutex_t* const mutex, const bool is_shared)
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

/// Status for the result of a lock call. After the death of the last holder the mutex is made usable again.
static status_t locked(osal_mutex_t* const mutex, const int result)
{
    if (result == EOWNERDEAD) {
        const int repaired = pthread_mutex_consistent(native(mutex));
        FSW_ASSERT(repaired == 0);
        return STATUS_CLOSED;
    }
    FSW_ASSERT(result == 0); // EDEADLK: this task has locked the mutex already.
    return STATUS_OK;
}

status_t osal_mutex_lock(osal_mutex_t* const mutex)
{
    FSW_ASSERT((mutex != NULL) && (mutex->storage[MARK_WORD] == MARK));
    return locked(mutex, pthread_mutex_lock(native(mutex)));
}

status_t osal_mutex_lock_within(osal_mutex_t* const mutex, const uint64_t wait_ns)
{
    FSW_ASSERT((mutex != NULL) && (mutex->storage[MARK_WORD] == MARK));
    int result = pthread_mutex_trylock(native(mutex));
    if (result == EBUSY) {
        struct timespec until = {0, 0}; // pthread_mutex_timedlock takes only times of this clock.
        (void)clock_gettime(CLOCK_REALTIME, &until);
        const uint64_t end_ns = (uint64_t)until.tv_nsec + (wait_ns % NS_PER_S);
        until.tv_sec += (time_t)((wait_ns / NS_PER_S) + (end_ns / NS_PER_S));
        until.tv_nsec = (long)(end_ns % NS_PER_S);
        result        = pthread_mutex_timedlock(native(mutex), &until);
    }
    return (result == ETIMEDOUT) ? STATUS_TIMEOUT : locked(mutex, result);
}

int32_t osal_mutex_holder(const osal_mutex_t* const mutex)
{
    FSW_ASSERT((mutex != NULL) && (mutex->storage[MARK_WORD] == MARK));
    // The first word of a mutex with priority inheritance is shared with the kernel, which defines its
    // layout.
    const uint32_t* const word = (const uint32_t*)(const void*)mutex->storage;
    return (int32_t)(__atomic_load_n(word, __ATOMIC_ACQUIRE) & FUTEX_TID_MASK);
}

void osal_mutex_unlock(osal_mutex_t* const mutex)
{
    FSW_ASSERT((mutex != NULL) && (mutex->storage[MARK_WORD] == MARK));
    const int result = pthread_mutex_unlock(native(mutex));
    FSW_ASSERT(result == 0); // EPERM: this task does not hold the mutex.
}
