// SPDX-License-Identifier: Apache-2.0
// System calls of the TIPC port, and its reaction to each answer. The calls are mocked, so that the test also
// runs without TIPC in the kernel; test/contract/osal/posix/test_tipc.c tests with a real kernel.
#include "osal/include/osal/tipc.h"

#include <errno.h>
#include <linux/tipc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmocka.h>

#define DESCRIPTOR 0 // The lowest descriptor: free if standard input is closed.
#define TYPE 0x48000001U
#define NODE 0x01001002U
#define REF 77U
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

typedef struct {
    int error;
    status_t status;
} error_case_t;

static osal_socket_t sock;
static uint8_t octets[100];
static uint64_t from;
static size_t size;
static const osal_tipc_name_t name = {TYPE, 16U};
static struct sockaddr_tipc bound;
static struct sockaddr_tipc destination;
static struct tipc_subscr subscription;
static struct tipc_event event_to_come;
static int flags_to_come;
static int kind_of_control; // 0: no control data.

/// Give a mocked call its outcome: it succeeds with `result`, or fails with the error number -`result`.
static int answer(const int result)
{
    // After a success errno may have any value: a caller that then looks at it repeats the call.
    errno = (result < 0) ? -result : EINTR;
    return (result < 0) ? -1 : result;
}

int __wrap_socket(int domain, int type, int protocol)
{
    assert_int_equal(AF_TIPC, domain);
    assert_int_equal(0, protocol);
    check_expected(type);
    return answer(mock_type(int));
}

int __wrap_setsockopt(int descriptor, int level, int option, const void* value, socklen_t octets_of_value)
{
    uint32_t number = 0U;
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(SOL_TIPC, level);
    assert_int_equal(sizeof number, octets_of_value);
    (void)memcpy(&number, value, sizeof number);
    check_expected(option);
    check_expected(number);
    return answer(mock_type(int));
}

int __wrap_bind(int descriptor, const struct sockaddr* address, socklen_t octets_of_address)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(sizeof bound, octets_of_address);
    (void)memcpy(&bound, address, sizeof bound);
    return answer(mock_type(int));
}

int __real_close(int descriptor);
int __wrap_close(int descriptor)
{
    if (descriptor != DESCRIPTOR) {
        return __real_close(descriptor); // A coverage build makes such calls itself.
    }
    function_called();
    return 0;
}

ssize_t __wrap_sendto(int descriptor, const void* from_octets, size_t count, int flags,
                      const struct sockaddr* to, socklen_t octets_of_address)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(MSG_NOSIGNAL | MSG_DONTWAIT, flags);
    assert_int_equal(sizeof destination, octets_of_address);
    check_expected(count);
    (void)memcpy(&destination, to, sizeof destination);
    if (count == sizeof subscription) {
        (void)memcpy(&subscription, from_octets, count);
    }
    return answer(mock_type(int));
}

ssize_t __wrap_recvmsg(int descriptor, struct msghdr* message, int flags)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(MSG_DONTWAIT, flags);
    assert_int_equal(sizeof octets, message->msg_iov[0].iov_len);
    struct sockaddr_tipc* const sender = message->msg_name;
    sender->addr.id.ref                = REF;
    sender->addr.id.node               = NODE;
    message->msg_flags                 = flags_to_come;
    if (kind_of_control == 0) {
        message->msg_controllen = 0U;
    } else {
        struct cmsghdr* const part = CMSG_FIRSTHDR(message);
        part->cmsg_level           = SOL_TIPC;
        part->cmsg_type            = kind_of_control;
        part->cmsg_len             = CMSG_LEN(8U);
        message->msg_controllen    = CMSG_SPACE(8U);
    }
    return answer(mock_type(int));
}

ssize_t __wrap_recv(int descriptor, void* to, size_t capacity, int flags)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(MSG_DONTWAIT, flags);
    assert_int_equal(sizeof event_to_come, capacity);
    (void)memcpy(to, &event_to_come, sizeof event_to_come);
    return answer(mock_type(int));
}

int __wrap_getsockname(int descriptor, struct sockaddr* address, socklen_t* octets_of_address)
{
    struct sockaddr_tipc own = {.family = AF_TIPC};
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(sizeof own, *octets_of_address);
    own.addr.id.ref  = REF;
    own.addr.id.node = NODE;
    (void)memcpy(address, &own, sizeof own);
    return answer(mock_type(int));
}

static int set_up(void** state)
{
    (void)state;
    sock            = (osal_socket_t){.descriptor = DESCRIPTOR};
    flags_to_come   = 0;
    kind_of_control = 0;
    return 0;
}

// ---- Opening ----

static void will_open(const int type, const int result)
{
    expect_value(__wrap_socket, type, type | SOCK_NONBLOCK | SOCK_CLOEXEC);
    will_return(__wrap_socket, result);
}

static void will_set(const int option, const uint32_t number, const int result)
{
    expect_value(__wrap_setsockopt, option, option);
    expect_value(__wrap_setsockopt, number, number);
    will_return(__wrap_setsockopt, result);
}

static void a_message_socket_has_its_kind_importance_and_name(void** state)
{
    (void)state;
    will_open(SOCK_RDM, DESCRIPTOR);
    will_set(TIPC_DEST_DROPPABLE, 0U, 0);
    will_set(TIPC_IMPORTANCE, TIPC_HIGH_IMPORTANCE, 0);
    will_return(__wrap_bind, 0);
    assert_int_equal(STATUS_OK, osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, &name, OSAL_TIPC_CLUSTER));
    assert_int_equal(DESCRIPTOR, sock.descriptor);
    assert_int_equal(AF_TIPC, bound.family);
    assert_int_equal(TIPC_SERVICE_RANGE, bound.addrtype);
    assert_int_equal(TIPC_CLUSTER_SCOPE, bound.scope);
    assert_int_equal(TYPE, bound.addr.nameseq.type);
    assert_int_equal(16U, bound.addr.nameseq.lower);
    assert_int_equal(16U, bound.addr.nameseq.upper);
}

static void a_sample_socket_has_its_kind_and_name(void** state)
{
    (void)state;
    will_open(SOCK_DGRAM, DESCRIPTOR);
    will_return(__wrap_bind, 0);
    assert_int_equal(STATUS_OK, osal_tipc_open(&sock, OSAL_TIPC_SAMPLE, &name, OSAL_TIPC_NODE));
    assert_int_equal(TIPC_NODE_SCOPE, bound.scope);
    will_open(SOCK_DGRAM, DESCRIPTOR);
    // A socket that only sends needs no name.
    assert_int_equal(STATUS_OK, osal_tipc_open(&sock, OSAL_TIPC_SAMPLE, NULL, OSAL_TIPC_NODE));
}

static void a_socket_that_does_not_open_is_reported_and_closed(void** state)
{
    static const error_case_t openings[] = {{EAFNOSUPPORT, STATUS_UNSUPPORTED},
                                            {EPROTONOSUPPORT, STATUS_UNSUPPORTED},
                                            {ESOCKTNOSUPPORT, STATUS_UNSUPPORTED},
                                            {EACCES, STATUS_DENIED},
                                            {EPERM, STATUS_DENIED},
                                            {EMFILE, STATUS_EXHAUSTED},
                                            {ENFILE, STATUS_EXHAUSTED},
                                            {ENOBUFS, STATUS_EXHAUSTED},
                                            {ENOMEM, STATUS_EXHAUSTED},
                                            {EINVAL, STATUS_IO}};
    (void)state;
    for (size_t i = 0U; i < COUNT(openings); i++) {
        const int result = -openings[i].error;
        will_open(SOCK_RDM, result);
        assert_int_equal(openings[i].status, osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, &name, OSAL_TIPC_NODE));
        assert_int_equal(-1, sock.descriptor);
        will_open(SOCK_SEQPACKET, result);
        assert_int_equal(openings[i].status, osal_tipc_watch_open(&sock, TYPE));
        assert_int_equal(-1, sock.descriptor);
        for (unsigned failing = 1U; failing <= 3U; failing++) {
            will_open(SOCK_RDM, DESCRIPTOR);
            will_set(TIPC_DEST_DROPPABLE, 0U, (failing == 1U) ? result : 0);
            if (failing > 1U) {
                will_set(TIPC_IMPORTANCE, TIPC_HIGH_IMPORTANCE, (failing == 2U) ? result : 0);
            }
            if (failing > 2U) {
                will_return(__wrap_bind, result);
            }
            expect_function_call(__wrap_close);
            assert_int_equal(openings[i].status,
                             osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, &name, OSAL_TIPC_NODE));
            assert_int_equal(-1, sock.descriptor);
        }
    }
}

// ---- Messages ----

static void a_message_goes_to_a_name(void** state)
{
    static const error_case_t sendings[] = {{EAGAIN, STATUS_FULL},         {ENOBUFS, STATUS_FULL},
                                            {ENOMEM, STATUS_FULL},         {EMSGSIZE, STATUS_TOO_LARGE},
                                            {EHOSTUNREACH, STATUS_CLOSED}, {ENETUNREACH, STATUS_CLOSED},
                                            {ECONNREFUSED, STATUS_CLOSED}, {ECONNRESET, STATUS_CLOSED},
                                            {EPIPE, STATUS_CLOSED},        {EINVAL, STATUS_IO}};
    (void)state;
    expect_value_count(__wrap_sendto, count, 5, 3);
    will_return_count(__wrap_sendto, -EINTR, 2);
    will_return(__wrap_sendto, 0); // Not negative: no error.
    assert_int_equal(STATUS_OK, osal_tipc_send(&sock, name, octets, 5U));
    assert_int_equal(TIPC_SERVICE_ADDR, destination.addrtype);
    assert_int_equal(TYPE, destination.addr.name.name.type);
    assert_int_equal(16U, destination.addr.name.name.instance);
    assert_int_equal(0U, destination.addr.name.domain);
    for (size_t i = 0U; i < COUNT(sendings); i++) {
        expect_value(__wrap_sendto, count, 5);
        will_return(__wrap_sendto, -sendings[i].error);
        assert_int_equal(sendings[i].status, osal_tipc_send(&sock, name, octets, 5U));
    }
}

static void expect_received(const status_t status, const size_t received)
{
    size = 999U;
    assert_int_equal(status, osal_tipc_receive(&sock, &from, octets, sizeof octets, &size));
    assert_int_equal(received, size);
}

static void received_messages_and_returned_messages_are_distinguished(void** state)
{
    (void)state;
    will_return(__wrap_recvmsg, -EINTR);
    will_return_count(__wrap_recvmsg, 7, 4); // The next four receptions have 7 octets.
    expect_received(STATUS_OK, 7U);
    assert_int_equal(((uint64_t)NODE << 32U) | REF, from);
    // The control data contains the name to which the message was sent: an ordinary message.
    kind_of_control = TIPC_DESTNAME;
    expect_received(STATUS_OK, 7U);
    flags_to_come = MSG_TRUNC;
    expect_received(STATUS_TOO_LARGE, 0U);
    kind_of_control = TIPC_ERRINFO; // A message of ours is returned.
    expect_received(STATUS_FORBIDDEN, 0U);
    kind_of_control = 0;
    flags_to_come   = 0;
    will_return(__wrap_recvmsg, 0); // A message without octets; errno is of an earlier call.
    expect_received(STATUS_OK, 0U);
    will_return(__wrap_recvmsg, -EAGAIN);
    expect_received(STATUS_EMPTY, 0U);
    will_return(__wrap_recvmsg, -ECONNRESET);
    expect_received(STATUS_IO, 0U);
}

static void a_socket_has_an_identity(void** state)
{
    (void)state;
    will_return(__wrap_getsockname, 0);
    assert_int_equal(STATUS_OK, osal_tipc_identity(&sock, &from));
    assert_int_equal(((uint64_t)NODE << 32U) | REF, from);
    will_return(__wrap_getsockname, -EBADF);
    assert_int_equal(STATUS_IO, osal_tipc_identity(&sock, &from));
}

// ---- Watching names ----

static void a_watch_subscribes_to_all_names_of_a_type(void** state)
{
    (void)state;
    will_open(SOCK_SEQPACKET, DESCRIPTOR);
    expect_value(__wrap_sendto, count, sizeof subscription);
    will_return(__wrap_sendto, sizeof subscription);
    assert_int_equal(STATUS_OK, osal_tipc_watch_open(&sock, TYPE));
    assert_int_equal(DESCRIPTOR, sock.descriptor);
    assert_int_equal(TIPC_TOP_SRV, destination.addr.name.name.type);
    assert_int_equal(TYPE, subscription.seq.type);
    assert_int_equal(0U, subscription.seq.lower);
    assert_int_equal(UINT32_MAX, subscription.seq.upper);
    assert_int_equal(TIPC_SUB_PORTS, subscription.filter);
    assert_int_equal(TIPC_WAIT_FOREVER, (int)subscription.timeout);
    will_open(SOCK_SEQPACKET, DESCRIPTOR);
    expect_value(__wrap_sendto, count, sizeof subscription);
    will_return(__wrap_sendto, -EHOSTUNREACH);
    expect_function_call(__wrap_close);
    assert_int_equal(STATUS_IO, osal_tipc_watch_open(&sock, TYPE));
    assert_int_equal(-1, sock.descriptor);
}

static void names_that_appear_and_disappear_are_reported(void** state)
{
    osal_tipc_event_t event = {false, 0U};
    (void)state;
    event_to_come = (struct tipc_event){.event = TIPC_PUBLISHED, .found_lower = 17U};
    will_return(__wrap_recv, -EINTR);
    will_return_count(__wrap_recv, sizeof event_to_come, 2);
    assert_int_equal(STATUS_OK, osal_tipc_watch_next(&sock, &event));
    assert_true(event.is_published);
    assert_int_equal(17U, event.instance);
    event_to_come.event = TIPC_WITHDRAWN;
    assert_int_equal(STATUS_OK, osal_tipc_watch_next(&sock, &event));
    assert_false(event.is_published);
    static const struct {
        int result;
        status_t status;
    } ends[] = {{0, STATUS_CLOSED},
                {(int)sizeof event_to_come - 1, STATUS_CLOSED},
                {-EAGAIN, STATUS_EMPTY},
                {-ECONNRESET, STATUS_IO}};
    for (size_t i = 0U; i < COUNT(ends); i++) {
        will_return(__wrap_recv, ends[i].result);
        assert_int_equal(ends[i].status, osal_tipc_watch_next(&sock, &event));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_message_socket_has_its_kind_importance_and_name, set_up),
        cmocka_unit_test_setup(a_sample_socket_has_its_kind_and_name, set_up),
        cmocka_unit_test_setup(a_socket_that_does_not_open_is_reported_and_closed, set_up),
        cmocka_unit_test_setup(a_message_goes_to_a_name, set_up),
        cmocka_unit_test_setup(received_messages_and_returned_messages_are_distinguished, set_up),
        cmocka_unit_test_setup(a_socket_has_an_identity, set_up),
        cmocka_unit_test_setup(a_watch_subscribes_to_all_names_of_a_type, set_up),
        cmocka_unit_test_setup(names_that_appear_and_disappear_are_reported, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
