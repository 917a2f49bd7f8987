// SPDX-License-Identifier: Apache-2.0
// Reaction of the ports of shared memory, message queues, locks and tasks to errors of the system: the calls
// are mocked. test/contract/osal has the tests with a real system.
#define _GNU_SOURCE
#include "osal/include/osal/mqueue.h"
#include "osal/include/osal/mutex.h"
#include "osal/include/osal/shm.h"
#include "osal/include/osal/task.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <mqueue.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cmocka.h>

#define DESCRIPTOR 0 // The lowest descriptor: free if standard input is closed.
#define NAME "/mocked"
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

typedef struct {
    int error;
    status_t status;
} error_case_t;

static uint64_t memory[8];
static off_t fallocated = sizeof memory; // Size that the port must request.
static off_t length;                     // Length that fstat reports.
static nlink_t links;
static int policy_priority; // Priority that belongs to the policy.

/// Give a mocked call its outcome: it succeeds with `result`, or fails with the error number -`result`.
static int answer(const int result)
{
    // After a success errno may have any value: a caller that then looks at it repeats the call.
    errno = (result < 0) ? -result : EINTR;
    return (result < 0) ? -1 : result;
}

int __wrap_shm_open(const char* name, int flags, mode_t mode)
{
    (void)mode;
    assert_string_equal(NAME, name);
    check_expected(flags);
    return answer(mock_type(int));
}

int __wrap_shm_unlink(const char* name)
{
    assert_string_equal(NAME, name);
    return answer(mock_type(int));
}

int __wrap_posix_fallocate(int descriptor, off_t offset, off_t octets)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(0, offset);
    assert_int_equal(fallocated, octets);
    return mock_type(int); // The function returns the error number itself.
}

void* __real_mmap(void* address, size_t size, int protection, int flags, int descriptor, off_t offset);
void* __wrap_mmap(void* address, size_t size, int protection, int flags, int descriptor, off_t offset)
{
    if (descriptor != DESCRIPTOR) {
        return __real_mmap(address, size, protection, flags, descriptor,
                           offset); // A coverage build makes such calls itself.
    }
    assert_int_equal(sizeof memory, size);
    assert_int_equal(MAP_SHARED, flags);
    return (answer(mock_type(int)) == 0) ? (void*)memory : MAP_FAILED;
}

int __real_fstat(int descriptor, struct stat* about);
int __wrap_fstat(int descriptor, struct stat* about)
{
    if (descriptor != DESCRIPTOR) {
        return __real_fstat(descriptor, about);
    }
    *about = (struct stat){.st_size = length, .st_nlink = links};
    return answer(mock_type(int));
}

int __real_close(int descriptor);
int __wrap_close(int descriptor)
{
    if (descriptor != DESCRIPTOR) {
        return __real_close(descriptor);
    }
    function_called();
    return 0;
}

DIR* __wrap_opendir(const char* path)
{
    assert_string_equal("/dev/shm", path);
    return NULL;
}

mqd_t __wrap_mq_open(const char* name, int flags, ...)
{
    (void)flags;
    assert_string_equal(NAME, name);
    return answer(mock_type(int));
}

int __wrap_mq_getattr(mqd_t queue, struct mq_attr* limits)
{
    assert_int_equal(DESCRIPTOR, queue);
    *limits = (struct mq_attr){.mq_msgsize = 64};
    return answer(mock_type(int));
}

int __wrap_mq_close(mqd_t queue)
{
    assert_int_equal(DESCRIPTOR, queue);
    function_called();
    return 0;
}

int __wrap_mq_unlink(const char* name)
{
    assert_string_equal(NAME, name);
    return answer(mock_type(int));
}

int __wrap_mq_send(mqd_t queue, const char* octets, size_t size, unsigned priority)
{
    assert_int_equal(DESCRIPTOR, queue);
    assert_non_null(octets);
    assert_int_equal(0U, priority);
    check_expected(size);
    return answer(mock_type(int));
}

ssize_t __wrap_mq_receive(mqd_t queue, char* octets, size_t capacity, unsigned* out_priority)
{
    assert_int_equal(DESCRIPTOR, queue);
    assert_non_null(octets);
    assert_null(out_priority);
    check_expected(capacity);
    return answer(mock_type(int));
}

// Calls that make a lock: each returns an error number or 0.
int __wrap_pthread_mutexattr_init(pthread_mutexattr_t* attributes)
{
    (void)attributes;
    return mock_type(int);
}

int __wrap_pthread_mutexattr_setpshared(pthread_mutexattr_t* attributes, int sharing)
{
    (void)attributes;
    check_expected(sharing);
    return mock_type(int);
}

int __wrap_pthread_mutexattr_setprotocol(pthread_mutexattr_t* attributes, int protocol)
{
    (void)attributes;
    assert_int_equal(PTHREAD_PRIO_INHERIT, protocol);
    return mock_type(int);
}

int __wrap_pthread_mutexattr_setrobust(pthread_mutexattr_t* attributes, int robustness)
{
    (void)attributes;
    assert_int_equal(PTHREAD_MUTEX_ROBUST, robustness);
    return mock_type(int);
}

int __wrap_pthread_mutexattr_settype(pthread_mutexattr_t* attributes, int type)
{
    (void)attributes;
    assert_int_equal(PTHREAD_MUTEX_ERRORCHECK, type);
    return mock_type(int);
}

int __wrap_pthread_mutex_init(pthread_mutex_t* mutex, const pthread_mutexattr_t* attributes)
{
    (void)mutex;
    (void)attributes;
    return mock_type(int);
}

int __wrap_pthread_mutexattr_destroy(pthread_mutexattr_t* attributes)
{
    (void)attributes;
    function_called();
    return 0;
}

int __real_pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                          void* context);
int __wrap_pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                          void* context)
{
    struct sched_param parameters;
    int inherits = 0;
    (void)pthread_attr_getinheritsched(attributes, &inherits);
    (void)pthread_attr_getschedparam(attributes, &parameters);
    const int priority = (inherits == PTHREAD_EXPLICIT_SCHED) ? parameters.sched_priority : 0;
    int policy         = -1;
    (void)pthread_attr_getschedpolicy(attributes, &policy);
    assert_int_equal((priority > 0) ? SCHED_FIFO : SCHED_OTHER, policy);
    check_expected(priority);
    const int error = mock_type(int);
    return (error == 0) ? __real_pthread_create(thread, attributes, run, context) : error;
}

int __real_pthread_attr_init(pthread_attr_t* attributes);
int __wrap_pthread_attr_init(pthread_attr_t* attributes)
{
    const int error = mock_type(int);
    return (error == 0) ? __real_pthread_attr_init(attributes) : error;
}

int __wrap_pthread_setschedparam(pthread_t thread, int policy, const struct sched_param* parameters)
{
    (void)thread;
    check_expected(policy);
    assert_int_equal(policy_priority, parameters->sched_priority);
    return mock_type(int);
}

// ---- Shared memory ----

#define CREATE (O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC)
#define OPEN (O_RDWR | O_CLOEXEC)

static const error_case_t shm_errors[] = {{EEXIST, STATUS_EXISTS},    {ENOENT, STATUS_NOT_FOUND},
                                          {EACCES, STATUS_DENIED},    {EPERM, STATUS_DENIED},
                                          {ENOMEM, STATUS_EXHAUSTED}, {ENOSPC, STATUS_EXHAUSTED},
                                          {EFBIG, STATUS_EXHAUSTED},  {EMFILE, STATUS_EXHAUSTED},
                                          {ENFILE, STATUS_EXHAUSTED}, {EIO, STATUS_IO}};

static void memory_that_cannot_be_made_leaves_nothing(void** state)
{
    osal_shm_t shm;
    (void)state;
    for (size_t i = 0U; i < COUNT(shm_errors); i++) {
        expect_value(__wrap_shm_open, flags, CREATE);
        will_return(__wrap_shm_open, -shm_errors[i].error);
        assert_int_equal(shm_errors[i].status, osal_shm_create(&shm, NAME, sizeof memory));
        expect_value_count(__wrap_shm_open, flags, CREATE, 2);
        will_return_count(__wrap_shm_open, DESCRIPTOR, 2);
        will_return(__wrap_posix_fallocate, EINTR);
        will_return(__wrap_posix_fallocate, shm_errors[i].error); // There is no room for the memory.
        will_return_count(__wrap_shm_unlink, 0, 2);
        expect_function_calls(__wrap_close, 2);
        assert_int_equal(shm_errors[i].status, osal_shm_create(&shm, NAME, sizeof memory));
        will_return(__wrap_posix_fallocate, 0);
        will_return(__wrap_mmap, -shm_errors[i].error); // There is no room in the address space.
        assert_int_equal(shm_errors[i].status, osal_shm_create(&shm, NAME, sizeof memory));
        assert_null(osal_shm_address(&shm));
        assert_int_equal(0U, osal_shm_size(&shm));
    }
    // The largest possible size is passed to the system; a larger size is refused without a call.
    fallocated = INT64_MAX;
    expect_value(__wrap_shm_open, flags, CREATE);
    will_return(__wrap_shm_open, DESCRIPTOR);
    will_return(__wrap_posix_fallocate, EFBIG);
    will_return(__wrap_shm_unlink, 0);
    expect_function_call(__wrap_close);
    assert_int_equal(STATUS_EXHAUSTED, osal_shm_create(&shm, NAME, (size_t)INT64_MAX));
    assert_int_equal(STATUS_EXHAUSTED, osal_shm_create(&shm, NAME, (size_t)INT64_MAX + 1U));
    fallocated = sizeof memory;
}

static void memory_that_cannot_be_opened_is_reported(void** state)
{
    osal_shm_t shm;
    (void)state;
    for (size_t i = 0U; i < COUNT(shm_errors); i++) {
        const status_t wanted = (shm_errors[i].status == STATUS_EXHAUSTED) ? STATUS_IO : shm_errors[i].status;
        expect_value(__wrap_shm_open, flags, OPEN);
        will_return(__wrap_shm_open, -shm_errors[i].error);
        assert_int_equal(wanted, osal_shm_open(&shm, NAME));
        length = sizeof memory;
        expect_value(__wrap_shm_open, flags, OPEN);
        will_return(__wrap_shm_open, DESCRIPTOR);
        will_return(__wrap_fstat, 0);
        will_return(__wrap_mmap, -shm_errors[i].error);
        expect_function_call(__wrap_close);
        assert_int_equal(wanted, osal_shm_open(&shm, NAME));
        assert_null(osal_shm_address(&shm));
    }
    static const error_case_t unfinished[] = {{0, STATUS_NOT_FOUND}, {EIO, STATUS_IO}};
    for (size_t i = 0U; i < COUNT(unfinished); i++) {
        // The creator has not set a size yet, or the size is unknown.
        length = 0;
        expect_value(__wrap_shm_open, flags, OPEN);
        will_return(__wrap_shm_open, DESCRIPTOR);
        will_return(__wrap_fstat, -unfinished[i].error);
        expect_function_call(__wrap_close);
        assert_int_equal(unfinished[i].status, osal_shm_open(&shm, NAME));
    }
}

static void no_visit(void* context, const char* name)
{
    (void)context;
    fail_msg("%s", name);
}

static void names_that_cannot_be_removed_or_listed_are_reported(void** state)
{
    (void)state;
    will_return(__wrap_shm_unlink, -ENOENT);
    assert_int_equal(STATUS_NOT_FOUND, osal_shm_remove(NAME));
    will_return(__wrap_shm_unlink, -EACCES);
    assert_int_equal(STATUS_DENIED, osal_shm_remove(NAME));
    assert_int_equal(STATUS_UNSUPPORTED, osal_shm_each("/", no_visit, NULL));
    will_return(__wrap_mq_unlink, -ENOENT);
    assert_int_equal(STATUS_NOT_FOUND, osal_mqueue_remove(NAME));
    will_return(__wrap_mq_unlink, -EACCES);
    assert_int_equal(STATUS_DENIED, osal_mqueue_remove(NAME));
}

// ---- Message queues ----

static void queues_that_cannot_be_opened_are_reported(void** state)
{
    static const error_case_t errors[] = {
        {EEXIST, STATUS_EXISTS},       {ENOENT, STATUS_NOT_FOUND},   {EACCES, STATUS_DENIED},
        {EPERM, STATUS_DENIED},        {EINVAL, STATUS_EXHAUSTED},   {EMFILE, STATUS_EXHAUSTED},
        {ENFILE, STATUS_EXHAUSTED},    {ENOMEM, STATUS_EXHAUSTED},   {ENOSPC, STATUS_EXHAUSTED},
        {EOVERFLOW, STATUS_EXHAUSTED}, {ENOSYS, STATUS_UNSUPPORTED}, {EIO, STATUS_IO}};
    osal_mqueue_t queue;
    (void)state;
    for (size_t i = 0U; i < COUNT(errors); i++) {
        will_return_count(__wrap_mq_open, -errors[i].error, 2);
        assert_int_equal(errors[i].status, osal_mqueue_create(&queue, NAME, 4U, 64U));
        assert_false(queue.is_open);
        assert_int_equal(errors[i].status, osal_mqueue_open(&queue, NAME));
        assert_false(queue.is_open);
    }
    will_return(__wrap_mq_open, DESCRIPTOR);
    will_return(__wrap_mq_getattr, -EBADF);
    expect_function_call(__wrap_mq_close);
    assert_int_equal(STATUS_IO, osal_mqueue_open(&queue, NAME));
    assert_false(queue.is_open);
}

static void each_error_of_a_queue_has_its_status(void** state)
{
    static const error_case_t sendings[] = {
        {0, STATUS_OK}, {EAGAIN, STATUS_FULL}, {EMSGSIZE, STATUS_TOO_LARGE}, {EBADF, STATUS_IO}};
    static const error_case_t takings[] = {
        {EAGAIN, STATUS_EMPTY}, {EMSGSIZE, STATUS_TOO_LARGE}, {EBADF, STATUS_IO}};
    osal_mqueue_t queue = {.descriptor = DESCRIPTOR, .is_open = true};
    uint8_t octets[64]  = {0U};
    size_t size         = 9U;
    (void)state;
    links = 1U;
    for (size_t i = 0U; i < COUNT(sendings); i++) {
        will_return(__wrap_fstat, (i == 0U) ? -EIO : 0);
        expect_value_count(__wrap_mq_send, size, 0, 2);
        will_return(__wrap_mq_send, -EINTR);
        will_return(__wrap_mq_send, -sendings[i].error);
        assert_int_equal(sendings[i].status, osal_mqueue_send(&queue, NULL, 0U));
    }
    links = 0U; // The name of the queue was removed, so it has no receiver.
    will_return(__wrap_fstat, 0);
    assert_int_equal(STATUS_CLOSED, osal_mqueue_send(&queue, octets, 1U));
    for (size_t i = 0U; i < COUNT(takings); i++) {
        expect_value_count(__wrap_mq_receive, capacity, sizeof octets, 2);
        will_return(__wrap_mq_receive, -EINTR);
        will_return(__wrap_mq_receive, -takings[i].error);
        assert_int_equal(takings[i].status, osal_mqueue_receive(&queue, octets, sizeof octets, &size));
        assert_int_equal(0U, size);
    }
    expect_value(__wrap_mq_receive, capacity, sizeof octets);
    will_return(__wrap_mq_receive, 5);
    assert_int_equal(STATUS_OK, osal_mqueue_receive(&queue, octets, sizeof octets, &size));
    assert_int_equal(5U, size);
}

// ---- Locks and tasks ----

static void a_lock_without_all_its_attributes_is_refused(void** state)
{
    osal_mutex_t mutex;
    (void)state;
    will_return(__wrap_pthread_mutexattr_init, ENOMEM);
    assert_int_equal(STATUS_UNSUPPORTED, osal_mutex_create(&mutex, true));
    for (unsigned failing = 1U; failing <= 6U; failing++) { // In the sixth round no call fails.
        will_return(__wrap_pthread_mutexattr_init, 0);
        expect_value(__wrap_pthread_mutexattr_setpshared, sharing,
                     ((failing % 2U) == 0U) ? PTHREAD_PROCESS_SHARED : PTHREAD_PROCESS_PRIVATE);
        will_return(__wrap_pthread_mutexattr_setpshared, (failing == 1U) ? ENOTSUP : 0);
        if (failing > 1U) {
            will_return(__wrap_pthread_mutexattr_setprotocol, (failing == 2U) ? ENOTSUP : 0);
        }
        if (failing > 2U) {
            will_return(__wrap_pthread_mutexattr_setrobust, (failing == 3U) ? ENOTSUP : 0);
        }
        if (failing > 3U) {
            will_return(__wrap_pthread_mutexattr_settype, (failing == 4U) ? ENOTSUP : 0);
        }
        if (failing > 4U) {
            will_return(__wrap_pthread_mutex_init, (failing == 5U) ? EAGAIN : 0);
        }
        expect_function_call(__wrap_pthread_mutexattr_destroy);
        assert_int_equal((failing == 6U) ? STATUS_OK : STATUS_UNSUPPORTED,
                         osal_mutex_create(&mutex, (failing % 2U) == 0U));
    }
}

static void run(void* context)
{
    __atomic_store_n((int*)context, 1, __ATOMIC_RELEASE);
}

static void a_task_starts_without_a_priority_that_is_not_permitted(void** state)
{
    osal_task_t task;
    int has_run = 0;
    (void)state;
    static const int priorities[] = {1, 7};
    for (size_t i = 0U; i < COUNT(priorities); i++) {
        has_run = 0;
        will_return_count(__wrap_pthread_attr_init, 0, 2);
        expect_value(__wrap_pthread_create, priority, priorities[i]);
        will_return(__wrap_pthread_create, EPERM);
        expect_value(__wrap_pthread_create, priority, 0);
        will_return(__wrap_pthread_create, 0);
        assert_int_equal(STATUS_OK, osal_task_start(&task, run, &has_run, priorities[i]));
        osal_task_join(&task);
        assert_int_equal(1, has_run);
    }
}

static void a_task_that_does_not_start_is_reported(void** state)
{
    static const error_case_t errors[] = {{EAGAIN, STATUS_EXHAUSTED}, {EINVAL, STATUS_IO}};
    osal_task_t task;
    (void)state;
    for (size_t i = 0U; i < COUNT(errors); i++) {
        will_return(__wrap_pthread_attr_init, 0);
        expect_value(__wrap_pthread_create, priority, 0);
        will_return(__wrap_pthread_create, errors[i].error);
        assert_int_equal(errors[i].status, osal_task_start(&task, run, NULL, 0));
        assert_false(task.is_running);
        osal_task_join(&task); // There is nothing to wait for.
    }
    will_return(__wrap_pthread_attr_init, ENOMEM);
    assert_int_equal(STATUS_IO, osal_task_start(&task, run, NULL, 0));
}

static void a_priority_that_is_not_permitted_is_reported(void** state)
{
    (void)state;
    expect_value(__wrap_pthread_setschedparam, policy, SCHED_FIFO);
    will_return(__wrap_pthread_setschedparam, EPERM);
    policy_priority = 7;
    assert_int_equal(STATUS_DENIED, osal_task_set_priority(7));
    expect_value(__wrap_pthread_setschedparam, policy, SCHED_FIFO);
    will_return(__wrap_pthread_setschedparam, 0);
    policy_priority = 1;
    assert_int_equal(STATUS_OK, osal_task_set_priority(1));
    expect_value(__wrap_pthread_setschedparam, policy, SCHED_OTHER);
    will_return(__wrap_pthread_setschedparam, 0);
    policy_priority = 0;
    assert_int_equal(STATUS_OK, osal_task_set_priority(0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_that_cannot_be_made_leaves_nothing),
        cmocka_unit_test(memory_that_cannot_be_opened_is_reported),
        cmocka_unit_test(names_that_cannot_be_removed_or_listed_are_reported),
        cmocka_unit_test(queues_that_cannot_be_opened_are_reported),
        cmocka_unit_test(each_error_of_a_queue_has_its_status),
        cmocka_unit_test(a_lock_without_all_its_attributes_is_refused),
        cmocka_unit_test(a_task_starts_without_a_priority_that_is_not_permitted),
        cmocka_unit_test(a_task_that_does_not_start_is_reported),
        cmocka_unit_test(a_priority_that_is_not_permitted_is_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
