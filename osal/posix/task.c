// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/task.h"

#include "base/assertion.h"

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

#define PRIORITY_MAX 99
/// Smaller than the default, because a program that locks its memory locks the whole stack.
#define STACK_OCTETS 1048576U
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAS_SMALL_STACKS false
#else
#define HAS_SMALL_STACKS true
#endif

typedef char handle_holds_a_thread[(sizeof(pthread_t) <= sizeof(uint64_t)) ? 1 : -1];

static void* run(void* const context)
{
    osal_task_t* const task = context;
    task->entry(task->context);
    return NULL;
}

static int create(pthread_t* const out_thread, osal_task_t* const task, const int priority)
{
    pthread_attr_t attributes;
    int error = pthread_attr_init(&attributes);
    if (error != 0) {
        return error;
    }
    if (HAS_SMALL_STACKS) {
        (void)pthread_attr_setstacksize(&attributes, STACK_OCTETS);
    }
    if (priority > 0) {
        const struct sched_param parameters = {.sched_priority = priority};
        (void)pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
        (void)pthread_attr_setschedpolicy(&attributes, SCHED_FIFO);
        (void)pthread_attr_setschedparam(&attributes, &parameters);
    }
    error = pthread_create(out_thread, &attributes, run, task);
    (void)pthread_attr_destroy(&attributes);
    return error;
}

status_t osal_task_start(osal_task_t* const task, void (*entry)(void* context), void* const context,
                         const int priority)
{
    FSW_ASSERT((task != NULL) && (entry != NULL) && (priority >= 0) && (priority <= PRIORITY_MAX));
    *task = (osal_task_t){.entry = entry, .context = context};
    sigset_t all;
    sigset_t kept;
    pthread_t thread;
    // Only the first task of the program handles signals: a new task starts with all signals blocked.
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_SETMASK, &all, &kept);
    int error = create(&thread, task, priority);
    if (error == EPERM) {
        error = create(&thread, task, 0);
    }
    (void)pthread_sigmask(SIG_SETMASK, &kept, NULL);
    if (error != 0) {
        return (error == EAGAIN) ? STATUS_EXHAUSTED : STATUS_IO;
    }
    (void)memcpy(&task->handle, &thread, sizeof thread);
    task->is_running = true;
    return STATUS_OK;
}

void osal_task_join(osal_task_t* const task)
{
    FSW_ASSERT(task != NULL);
    if (task->is_running) {
        pthread_t thread;
        (void)memcpy(&thread, &task->handle, sizeof thread);
        (void)pthread_join(thread, NULL);
        task->is_running = false;
    }
}

status_t osal_task_set_priority(const int priority)
{
    FSW_ASSERT((priority >= 0) && (priority <= PRIORITY_MAX));
    const struct sched_param parameters = {.sched_priority = priority};
    const int policy                    = (priority > 0) ? SCHED_FIFO : SCHED_OTHER;
    return (pthread_setschedparam(pthread_self(), policy, &parameters) == 0) ? STATUS_OK : STATUS_DENIED;
}

void osal_task_unpin(void)
{
    cpu_set_t set;
    if (sched_getaffinity(getppid(), sizeof set, &set) == 0) {
        (void)sched_setaffinity(0, sizeof set, &set); // Without permission the task stays pinned.
    }
}
