// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/mqueue.h"

#include "base/assertion.h"
#include "osal/posix/object_name.h"

#include <errno.h>
#include <fcntl.h>
#include <mqueue.h>
#include <string.h>
#include <sys/stat.h>

typedef char queue_is_a_descriptor[(sizeof(mqd_t) == sizeof(int)) ? 1 : -1];

static status_t status_of(const int error)
{
    switch (error) {
    case EEXIST:
        return STATUS_EXISTS;
    case ENOENT:
        return STATUS_NOT_FOUND;
    case EACCES:
    case EPERM:
        return STATUS_DENIED;
    // The callers refuse a wrong name and a size of 0, so EINVAL means a size beyond the limit of the system.
    case EINVAL:
    case EMFILE:
    case ENFILE:
    case ENOMEM:
    case ENOSPC:
    case EOVERFLOW:
        return STATUS_EXHAUSTED;
    case ENOSYS:
        return STATUS_UNSUPPORTED;
    default:
        return STATUS_IO;
    }
}

status_t osal_mqueue_create(osal_mqueue_t* const queue, const char* const name, const uint32_t depth,
                            const uint32_t message_octets)
{
    FSW_ASSERT((queue != NULL) && (name != NULL));
    *queue = (osal_mqueue_t){.descriptor = -1};
    if (!object_name_is_valid(name) || (depth == 0U) || (message_octets == 0U)) {
        return STATUS_INVALID;
    }
    struct mq_attr limits = {.mq_maxmsg = (long)depth, .mq_msgsize = (long)message_octets};
    const mqd_t opened =
        mq_open(name, O_RDWR | O_CREAT | O_EXCL | O_NONBLOCK | O_CLOEXEC, S_IRUSR | S_IWUSR, &limits);
    if (opened == (mqd_t)-1) {
        return status_of(errno);
    }
    *queue = (osal_mqueue_t){.descriptor = opened, .message_octets = message_octets, .is_open = true};
    return STATUS_OK;
}

status_t osal_mqueue_open(osal_mqueue_t* const queue, const char* const name)
{
    FSW_ASSERT((queue != NULL) && (name != NULL));
    *queue = (osal_mqueue_t){.descriptor = -1};
    if (!object_name_is_valid(name)) {
        return STATUS_INVALID;
    }
    struct mq_attr limits = {0};
    const mqd_t opened    = mq_open(name, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (opened == (mqd_t)-1) {
        return status_of(errno);
    }
    if (mq_getattr(opened, &limits) != 0) {
        (void)mq_close(opened);
        return STATUS_IO;
    }
    *queue =
        (osal_mqueue_t){.descriptor = opened, .message_octets = (uint32_t)limits.mq_msgsize, .is_open = true};
    return STATUS_OK;
}

status_t osal_mqueue_send(osal_mqueue_t* const queue, const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((queue != NULL) && ((octets != NULL) || (size == 0U)));
    struct stat about = {0};
    // A queue without a name still takes messages, but the receiver, which has restarted, does not read them.
    if ((fstat(queue->descriptor, &about) == 0) && (about.st_nlink == 0U)) {
        return STATUS_CLOSED;
    }
    int result = 0;
    do {
        result = mq_send(queue->descriptor, (size > 0U) ? (const char*)octets : "", size, 0U);
    } while ((result != 0) && (errno == EINTR));
    if (result == 0) {
        return STATUS_OK;
    }
    if (errno == EAGAIN) {
        return STATUS_FULL;
    }
    return (errno == EMSGSIZE) ? STATUS_TOO_LARGE : STATUS_IO;
}

status_t osal_mqueue_receive(osal_mqueue_t* const queue, uint8_t* const octets, const size_t capacity,
                             size_t* const out_size)
{
    FSW_ASSERT((queue != NULL) && (octets != NULL) && (out_size != NULL));
    ssize_t size = 0;
    do {
        size = mq_receive(queue->descriptor, (char*)octets, capacity, NULL);
    } while ((size < 0) && (errno == EINTR));
    *out_size = (size > 0) ? (size_t)size : 0U;
    if (size >= 0) {
        return STATUS_OK;
    }
    if (errno == EAGAIN) {
        return STATUS_EMPTY;
    }
    return (errno == EMSGSIZE) ? STATUS_TOO_LARGE : STATUS_IO;
}

uint32_t osal_mqueue_message_octets(const osal_mqueue_t* const queue)
{
    FSW_ASSERT(queue != NULL);
    return queue->message_octets;
}

void osal_mqueue_close(osal_mqueue_t* const queue)
{
    FSW_ASSERT(queue != NULL);
    if (queue->is_open) {
        (void)mq_close(queue->descriptor);
    }
    *queue = (osal_mqueue_t){.descriptor = -1};
}

status_t osal_mqueue_remove(const char* const name)
{
    FSW_ASSERT(name != NULL);
    if (!object_name_is_valid(name)) {
        return STATUS_INVALID;
    }
    if (mq_unlink(name) != 0) {
        return (errno == ENOENT) ? STATUS_NOT_FOUND : STATUS_DENIED;
    }
    return STATUS_OK;
}
