// SPDX-License-Identifier: Apache-2.0
// Reaction of the socket port to answers of the kernel that the loopback interface does not give: interrupted
// calls, full buffers, lost routes, no free descriptors. The system calls are mocked;
// test/contract/osal/posix/test_socket.c has the tests with a real kernel.
#define _GNU_SOURCE
#include "osal/include/osal/socket.h"

#include <errno.h>
#include <limits.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>

#include <cmocka.h>

#define DESCRIPTOR 0 // The lowest descriptor: free if standard input is closed.
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

typedef struct {
    int error;
    status_t status;
} error_case_t;

typedef struct {
    int level;
    int option;
    int value;
} option_t;

static option_t options[2]; // Options that were set.
static unsigned option_count;
static struct sockaddr_in caller = {.sin_family = AF_UNIX};
static osal_socket_t sock;
static uint8_t octets[16];
static size_t size;
static const osal_address_t somewhere = {OSAL_IPV4_LOOPBACK, 7U};
static int flags_to_come;
static int pending; // Error that getsockopt returns.
static short events_to_come;
static long passing_ns; // Time that passes with each reading of the clock.
static long now_ns;

/// Give a mocked call its outcome: it succeeds with `result`, or fails with the error number -`result`.
static int answer(const int result)
{
    // After a success errno may have any value: a caller that then looks at it repeats the call.
    errno = (result < 0) ? -result : EINTR;
    return (result < 0) ? -1 : result;
}

int __wrap_socket(int domain, int type, int protocol)
{
    assert_true((domain == AF_INET) || (domain == AF_UNIX));
    assert_int_equal(SOCK_CLOEXEC | SOCK_NONBLOCK, type & (SOCK_CLOEXEC | SOCK_NONBLOCK));
    assert_int_equal(0, protocol);
    return answer(mock_type(int));
}

int __wrap_socketpair(int domain, int type, int protocol, int* out_pair)
{
    assert_int_equal(AF_UNIX, domain);
    assert_int_equal(SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, type);
    assert_int_equal(0, protocol);
    out_pair[0] = 0; // The lowest descriptors. They must not be used if no pair is made.
    out_pair[1] = 1;
    return answer(mock_type(int));
}

int __wrap_setsockopt(int descriptor, int level, int option, const void* value, socklen_t octets_of_value)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(sizeof(int), octets_of_value);
    if (option_count < COUNT(options)) {
        options[option_count] = (option_t){level, option, *(const int*)value};
    }
    option_count++;
    return 0;
}

int __wrap_getsockopt(int descriptor, int level, int option, void* value, socklen_t* octets_of_value)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(SOL_SOCKET, level);
    assert_int_equal(SO_ERROR, option);
    assert_int_equal(sizeof pending, *octets_of_value);
    (void)memcpy(value, &pending, sizeof pending);
    return answer(mock_type(int));
}

int __wrap_bind(int descriptor, const struct sockaddr* address, socklen_t octets_of_address)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_true((address->sa_family == AF_INET) || (address->sa_family == AF_UNIX));
    assert_int_equal((address->sa_family == AF_INET) ? sizeof(struct sockaddr_in)
                                                     : sizeof(struct sockaddr_un),
                     octets_of_address);
    return answer(mock_type(int));
}

int __wrap_listen(int descriptor, int backlog)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_in_range(backlog, 1, 4096);
    return answer(mock_type(int));
}

int __wrap_connect(int descriptor, const struct sockaddr* address, socklen_t octets_of_address)
{
    (void)address;
    (void)octets_of_address;
    assert_int_equal(DESCRIPTOR, descriptor);
    return answer(mock_type(int));
}

int __wrap_accept4(int descriptor, struct sockaddr* address, socklen_t* octets_of_address, int flags)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(SOCK_CLOEXEC | SOCK_NONBLOCK, flags);
    assert_true(*octets_of_address >= sizeof caller);
    (void)memcpy(address, &caller, sizeof caller);
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

ssize_t __wrap_sendto(int descriptor, const void* from, size_t count, int flags, const struct sockaddr* to,
                      socklen_t octets_of_address)
{
    (void)from;
    (void)to;
    (void)octets_of_address;
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(MSG_NOSIGNAL, flags);
    assert_int_equal(sizeof octets, count);
    return answer(mock_type(int));
}

ssize_t __wrap_send(int descriptor, const void* from, size_t count, int flags)
{
    (void)from;
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(MSG_NOSIGNAL | MSG_DONTWAIT, flags);
    assert_int_equal(sizeof octets, count);
    return answer(mock_type(int));
}

ssize_t __wrap_recv(int descriptor, void* to, size_t capacity, int flags)
{
    (void)to;
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(MSG_DONTWAIT, flags);
    check_expected(capacity);
    return answer(mock_type(int));
}

ssize_t __wrap_recvmsg(int descriptor, struct msghdr* message, int flags)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    check_expected(flags);
    message->msg_flags = flags_to_come;
    return answer(mock_type(int));
}

int __wrap_poll(struct pollfd* sockets, nfds_t count, int timeout_ms)
{
    assert_int_equal(1, count);
    assert_int_equal(DESCRIPTOR, sockets[0].fd);
    check_expected(timeout_ms);
    sockets[0].revents = events_to_come;
    return answer(mock_type(int));
}

int __wrap_clock_gettime(clockid_t clock, struct timespec* out_time)
{
    (void)clock;
    now_ns += passing_ns;
    *out_time = (struct timespec){5000, now_ns};
    return 0;
}

static int set_up(void** state)
{
    (void)state;
    sock           = (osal_socket_t){.descriptor = DESCRIPTOR};
    caller         = (struct sockaddr_in){.sin_family = AF_UNIX};
    option_count   = 0U;
    flags_to_come  = 0;
    pending        = 0;
    events_to_come = 0;
    passing_ns     = 0;
    now_ns         = 0;
    return 0;
}

// ---- Opening ----

static void a_socket_that_does_not_open_is_reported_and_closed(void** state)
{
    static const error_case_t binds[] = {{EADDRINUSE, STATUS_EXISTS},
                                         {EEXIST, STATUS_EXISTS},
                                         {EACCES, STATUS_DENIED},
                                         {EPERM, STATUS_DENIED},
                                         {EINVAL, STATUS_IO}};
    (void)state;
    will_return_count(__wrap_socket, -EMFILE, 3);
    assert_int_equal(STATUS_IO, osal_udp_open(&sock, somewhere, 0U));
    assert_int_equal(STATUS_IO, osal_tcp_listen(&sock, somewhere));
    assert_int_equal(STATUS_IO, osal_local_listen(&sock, "mocked"));
    for (size_t i = 0U; i < COUNT(binds); i++) {
        will_return_count(__wrap_socket, DESCRIPTOR, 3);
        will_return_count(__wrap_bind, -binds[i].error, 2);
        expect_function_calls(__wrap_close, 3);
        assert_int_equal(binds[i].status, osal_udp_open(&sock, somewhere, SIZE_MAX));
        assert_int_equal(binds[i].status, osal_tcp_listen(&sock, somewhere));
        will_return(__wrap_bind, 0);
        will_return(__wrap_listen, -binds[i].error);
        assert_int_equal(binds[i].status, osal_tcp_listen(&sock, somewhere));
        assert_int_equal(-1, sock.descriptor);
    }
    will_return(__wrap_socket, DESCRIPTOR);
    will_return(__wrap_bind, 0);
    will_return(__wrap_listen, 0);
    assert_int_equal(STATUS_OK, osal_local_listen(&sock, "mocked"));
    assert_int_equal(DESCRIPTOR, sock.descriptor);
}

static void the_reason_for_an_unaccepted_connection_is_reported(void** state)
{
    static const error_case_t errors[] = {{EAGAIN, STATUS_EMPTY},     {EMFILE, STATUS_EXHAUSTED},
                                          {ENFILE, STATUS_EXHAUSTED}, {ENOBUFS, STATUS_EXHAUSTED},
                                          {ENOMEM, STATUS_EXHAUSTED}, {EBADF, STATUS_IO}};
    osal_socket_t client;
    osal_address_t peer;
    (void)state;
    expect_value_count(__wrap_poll, timeout_ms, 0, (int)COUNT(errors) + 2);
    will_return(__wrap_poll, 0); // No client waits, so the port does not call accept4.
    assert_int_equal(STATUS_EMPTY, osal_tcp_accept(&sock, &client, &peer));
    assert_int_equal(-1, client.descriptor);
    will_return(__wrap_poll, -ENOMEM); // poll fails, so accept4 decides.
    will_return(__wrap_accept4, -EAGAIN);
    assert_int_equal(STATUS_EMPTY, osal_tcp_accept(&sock, &client, &peer));
    for (size_t i = 0U; i < COUNT(errors); i++) {
        will_return(__wrap_poll, 1);
        will_return(__wrap_accept4, -EINTR);
        // This client has closed its connection; the port accepts the next one.
        will_return(__wrap_accept4, -ECONNABORTED);
        will_return(__wrap_accept4, -errors[i].error);
        assert_int_equal(errors[i].status, osal_tcp_accept(&sock, &client, &peer));
        assert_int_equal(-1, client.descriptor);
    }
}

// ---- Connecting ----

static const error_case_t refusals[] = {{ECONNREFUSED, STATUS_CLOSED},
                                        {EHOSTUNREACH, STATUS_CLOSED},
                                        {ENETUNREACH, STATUS_CLOSED},
                                        {ETIMEDOUT, STATUS_CLOSED},
                                        {EINVAL, STATUS_IO}};

static void a_connection_in_progress_is_asked_for_its_result(void** state)
{
    static const error_case_t begins[] = {{0, STATUS_OK}, {EINPROGRESS, STATUS_BUSY}, {EINTR, STATUS_BUSY}};
    (void)state;
    will_return(__wrap_socket, -EMFILE);
    assert_int_equal(STATUS_EXHAUSTED, osal_tcp_connect_begin(&sock, somewhere));
    will_return(__wrap_socket, -EACCES);
    assert_int_equal(STATUS_IO, osal_tcp_connect_begin(&sock, somewhere));
    for (size_t i = 0U; i < COUNT(begins); i++) {
        will_return(__wrap_socket, DESCRIPTOR);
        will_return(__wrap_connect, -begins[i].error);
        assert_int_equal(begins[i].status, osal_tcp_connect_begin(&sock, somewhere));
        assert_int_equal(DESCRIPTOR, sock.descriptor);
    }
    expect_value_count(__wrap_poll, timeout_ms, 0, 2);
    will_return(__wrap_poll, -EINTR);
    will_return(__wrap_poll, 0);
    assert_int_equal(STATUS_BUSY, osal_tcp_connect_result(&sock));
    expect_value(__wrap_poll, timeout_ms, 0);
    will_return(__wrap_poll, 1);
    will_return(__wrap_getsockopt, 0);
    assert_int_equal(STATUS_OK, osal_tcp_connect_result(&sock));
    for (size_t i = 0U; i < COUNT(refusals); i++) {
        will_return(__wrap_socket, DESCRIPTOR);
        will_return(__wrap_connect, -refusals[i].error);
        expect_function_call(__wrap_close);
        assert_int_equal(refusals[i].status, osal_tcp_connect_begin(&sock, somewhere));
        assert_int_equal(-1, sock.descriptor);
        pending         = refusals[i].error;
        sock.descriptor = DESCRIPTOR;
        expect_value(__wrap_poll, timeout_ms, 0);
        will_return(__wrap_poll, 1);
        will_return(__wrap_getsockopt, 0);
        expect_function_call(__wrap_close);
        assert_int_equal(refusals[i].status, osal_tcp_connect_result(&sock));
        assert_int_equal(-1, sock.descriptor);
    }
    sock.descriptor = DESCRIPTOR;
    expect_value(__wrap_poll, timeout_ms, 0);
    will_return(__wrap_poll, -ENOMEM);
    expect_function_call(__wrap_close);
    assert_int_equal(STATUS_IO, osal_tcp_connect_result(&sock));
}

// ---- Octets ----

static const error_case_t sendings[] = {{EAGAIN, STATUS_FULL},
                                        {ENOBUFS, STATUS_FULL},
                                        {ENOMEM, STATUS_FULL},
                                        {EMSGSIZE, STATUS_TOO_LARGE},
                                        {EPIPE, STATUS_CLOSED},
                                        {ECONNRESET, STATUS_CLOSED},
                                        {ECONNREFUSED, STATUS_CLOSED},
                                        {ECONNABORTED, STATUS_CLOSED},
                                        {EHOSTUNREACH, STATUS_CLOSED},
                                        {ENETUNREACH, STATUS_CLOSED},
                                        {ENOTCONN, STATUS_CLOSED},
                                        {ETIMEDOUT, STATUS_CLOSED},
                                        {EINVAL, STATUS_IO}};

static void the_reason_why_octets_are_not_sent_is_reported(void** state)
{
    (void)state;
    for (size_t i = 0U; i < COUNT(sendings); i++) {
        const status_t reported = sendings[i].status;
        will_return(__wrap_sendto, -EINTR);
        will_return(__wrap_sendto, -sendings[i].error);
        assert_int_equal(reported, osal_udp_send(&sock, somewhere, octets, sizeof octets));
        size = 9U;
        will_return(__wrap_send, -EINTR);
        will_return(__wrap_send, -sendings[i].error);
        assert_int_equal((reported == STATUS_TOO_LARGE) ? STATUS_IO : reported, // A stream has no messages.
                         osal_stream_send(&sock, octets, sizeof octets, &size));
        assert_int_equal(0U, size);
    }
    will_return(__wrap_send, 0);
    assert_int_equal(STATUS_FULL, osal_stream_send(&sock, octets, sizeof octets, &size));
    assert_int_equal(0U, size);
    will_return(__wrap_send, 1);
    assert_int_equal(STATUS_OK, osal_stream_send(&sock, octets, sizeof octets, &size));
    assert_int_equal(1U, size);
}

static void each_end_of_a_stream_has_its_status(void** state)
{
    static const struct {
        int result;
        status_t status;
    } ends[] = {
        {0, STATUS_CLOSED}, {-EAGAIN, STATUS_EMPTY}, {-ECONNRESET, STATUS_CLOSED}, {-EBADF, STATUS_IO}};
    (void)state;
    for (size_t i = 0U; i < COUNT(ends); i++) {
        size = 9U;
        expect_value_count(__wrap_recv, capacity, sizeof octets, 2);
        will_return(__wrap_recv, -EINTR);
        will_return(__wrap_recv, ends[i].result);
        assert_int_equal(ends[i].status, osal_stream_receive(&sock, octets, sizeof octets, &size));
        assert_int_equal(0U, size);
    }
}

static void receive(const status_t status, const size_t wanted)
{
    osal_address_t from;
    size = 9U;
    assert_int_equal(status, osal_udp_receive(&sock, &from, octets, sizeof octets, &size));
    assert_int_equal(wanted, size);
}

static void a_datagram_is_distinguished_from_errors_of_earlier_ones(void** state)
{
    (void)state;
    expect_value_count(__wrap_recvmsg, flags, MSG_DONTWAIT, 3);
    will_return(__wrap_recvmsg, -EINTR);
    will_return(__wrap_recvmsg, -ECONNREFUSED);
    will_return(__wrap_recvmsg, 5);
    receive(STATUS_OK, 5U);
    expect_value(__wrap_recvmsg, flags, MSG_DONTWAIT);
    will_return(__wrap_recvmsg, 0); // An empty datagram.
    receive(STATUS_OK, 0U);
    flags_to_come = MSG_TRUNC;
    expect_value_count(__wrap_recvmsg, flags, MSG_DONTWAIT, 3);
    will_return(__wrap_recvmsg, 5);
    receive(STATUS_TOO_LARGE, 0U);
    will_return(__wrap_recvmsg, -EAGAIN);
    receive(STATUS_EMPTY, 0U);
    will_return(__wrap_recvmsg, -EBADF);
    receive(STATUS_IO, 0U);
}

/// A deferred datagram stays in the socket until the request for the next one removes it.
static void a_deferred_datagram_is_removed_by_the_next_call(void** state)
{
    (void)state;
    osal_socket_defer(&sock);
    expect_value_count(__wrap_recvmsg, flags, MSG_DONTWAIT | MSG_PEEK, 4);
    will_return(__wrap_recvmsg, 5);
    receive(STATUS_OK, 5U);
    expect_value_count(__wrap_recv, capacity, 1, 3);
    will_return(__wrap_recv, -EINTR);
    will_return(__wrap_recv, -ECONNREFUSED);
    will_return(__wrap_recv, 1);
    will_return(__wrap_recvmsg, -EAGAIN);
    receive(STATUS_EMPTY, 0U);
    will_return(__wrap_recvmsg, 5); // No datagram was held back.
    receive(STATUS_OK, 5U);
    expect_value(__wrap_recv, capacity, 1);
    will_return(__wrap_recv, -EBADF); // The next call reports this error.
    will_return(__wrap_recvmsg, -EBADF);
    receive(STATUS_IO, 0U);
}

// ---- Waiting ----

/// One unsuccessful wait: `polls` calls of poll without a time-out, then the call that sleeps.
static void wait_unsuccessfully(const int polls)
{
    if (polls > 0) {
        expect_value_count(__wrap_poll, timeout_ms, 0, polls);
        will_return_count(__wrap_poll, 0, polls);
    }
    expect_in_range(__wrap_poll, timeout_ms, 1, 10);
    will_return(__wrap_poll, 0);
    assert_int_equal(STATUS_TIMEOUT, osal_socket_wait_readable(&sock, 10U));
}

/// Polling costs time: after unsuccessful polls the port skips polling once, then three times, then seven
/// times, and so on.
static void a_wait_polls_less_often_after_unsuccessful_polls(void** state)
{
    (void)state;
    passing_ns = OSAL_SOCKET_POLL_NS; // One poll takes all the time for polling.
    for (unsigned skipped = 1U; skipped <= 7U; skipped = (2U * skipped) + 1U) {
        wait_unsuccessfully(1);
        for (unsigned i = 0U; i < skipped; i++) {
            wait_unsuccessfully(0);
        }
    }
    expect_value(__wrap_poll, timeout_ms, 0);
    will_return(__wrap_poll, 1); // The shortest wait polls as well.
    sock.waits_to_skip = 0U;
    assert_int_equal(STATUS_OK, osal_socket_wait_readable(&sock, 1U));
    expect_value(__wrap_poll, timeout_ms, 0);
    will_return(__wrap_poll, 1); // The poll finds a datagram: from then on every wait begins with a poll.
    assert_int_equal(STATUS_OK, osal_socket_wait_readable(&sock, 10U));
    wait_unsuccessfully(1);
}

static void a_wait_continues_after_a_signal_and_ends_with_an_error(void** state)
{
    (void)state;
    sock.waits_to_skip = 2U;
    expect_value_count(__wrap_poll, timeout_ms, 10, 2);
    will_return(__wrap_poll, -EINTR);
    will_return(__wrap_poll, 1);
    assert_int_equal(STATUS_OK, osal_socket_wait_readable(&sock, 10U));
    events_to_come = POLLNVAL;
    expect_value(__wrap_poll, timeout_ms, 10);
    will_return(__wrap_poll, 1);
    assert_int_equal(STATUS_IO, osal_socket_wait_readable(&sock, 10U));
    sock.waits_to_skip = 1U;
    expect_value(__wrap_poll, timeout_ms, 10);
    will_return(__wrap_poll, -ENOMEM);
    assert_int_equal(STATUS_IO, osal_socket_wait_readable(&sock, 10U));
    expect_value(__wrap_poll, timeout_ms, 0); // With a time-out of 0 there is no polling.
    will_return(__wrap_poll, 0);
    assert_int_equal(STATUS_TIMEOUT, osal_socket_wait_readable(&sock, 0U));
}

static void a_wait_for_room_ends_like_one_for_octets(void** state)
{
    (void)state;
    expect_value_count(__wrap_poll, timeout_ms, 10, 5);
    will_return(__wrap_poll, -EINTR);
    will_return(__wrap_poll, 1);
    assert_int_equal(STATUS_OK, osal_socket_wait_writable(&sock, 10U));
    will_return(__wrap_poll, 0);
    assert_int_equal(STATUS_TIMEOUT, osal_socket_wait_writable(&sock, 10U));
    will_return(__wrap_poll, -ENOMEM);
    assert_int_equal(STATUS_IO, osal_socket_wait_writable(&sock, 10U));
    events_to_come = POLLNVAL;
    will_return(__wrap_poll, 1);
    assert_int_equal(STATUS_IO, osal_socket_wait_writable(&sock, 10U));
}

static void expect_options(const unsigned count, const option_t* const expected)
{
    assert_int_equal(count, option_count);
    for (unsigned i = 0U; i < count; i++) {
        assert_int_equal(expected[i].level, options[i].level);
        assert_int_equal(expected[i].option, options[i].option);
        assert_int_equal(expected[i].value, options[i].value);
    }
    option_count = 0U;
}

static void each_kind_of_socket_has_its_options(void** state)
{
    static const option_t at_once[] = {{IPPROTO_TCP, TCP_NODELAY, 1}};
    static const option_t again[]   = {{SOL_SOCKET, SO_REUSEADDR, 1}};
    static const struct {
        size_t wanted;
        int set;
    } buffers[] = {{1U, 1}, {65536U, 65536}, {INT_MAX, INT_MAX}, {(size_t)INT_MAX + 1U, INT_MAX}};
    osal_address_t peer;
    osal_socket_t client;
    (void)state;
    for (unsigned i = 0U; i < COUNT(buffers); i++) {
        const option_t size_of_buffer[] = {{SOL_SOCKET, SO_RCVBUF, buffers[i].set},
                                           {SOL_SOCKET, SO_RCVBUFFORCE, buffers[i].set}};
        will_return(__wrap_socket, DESCRIPTOR);
        will_return(__wrap_bind, 0);
        assert_int_equal(STATUS_OK, osal_udp_open(&sock, somewhere, buffers[i].wanted));
        expect_options(2U, size_of_buffer);
    }
    will_return(__wrap_socket, DESCRIPTOR);
    will_return(__wrap_bind, 0);
    // A size of 0 keeps the buffer size of the system.
    assert_int_equal(STATUS_OK, osal_udp_open(&sock, somewhere, 0U));
    expect_options(0U, NULL);
    will_return(__wrap_socket, DESCRIPTOR);
    will_return(__wrap_bind, 0);
    will_return(__wrap_listen, 0);
    assert_int_equal(STATUS_OK, osal_tcp_listen(&sock, somewhere));
    expect_options(1U, again);
    expect_value(__wrap_poll, timeout_ms, 0);
    will_return(__wrap_poll, 1);
    will_return(__wrap_accept4, DESCRIPTOR);
    assert_int_equal(STATUS_OK, osal_tcp_accept(&sock, &client, &peer));
    expect_options(0U, NULL); // The accepted socket is local, so TCP_NODELAY is not set.
    assert_int_equal(0U, peer.port);
    caller =
        (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons(9U), .sin_addr = {htonl(0x0A000001U)}};
    expect_value(__wrap_poll, timeout_ms, 0);
    will_return(__wrap_poll, 1);
    will_return(__wrap_accept4, DESCRIPTOR);
    assert_int_equal(STATUS_OK, osal_tcp_accept(&sock, &client, &peer));
    expect_options(1U, at_once);
    assert_int_equal(9U, peer.port);
    will_return(__wrap_socket, DESCRIPTOR);
    will_return(__wrap_connect, 0);
    assert_int_equal(STATUS_OK, osal_tcp_connect_begin(&sock, somewhere));
    expect_options(1U, at_once);
    will_return(__wrap_socket, DESCRIPTOR);
    will_return(__wrap_connect, -EINPROGRESS);
    assert_int_equal(STATUS_BUSY, osal_tcp_connect_begin(&sock, somewhere));
    expect_options(1U, at_once);
}

static void a_pair_has_two_ends_or_is_not_opened(void** state)
{
    osal_socket_t ends[2];
    (void)state;
    (void)memset(ends, 1, sizeof ends);
    will_return(__wrap_socketpair, 0);
    assert_int_equal(STATUS_OK, osal_local_pair(&ends[0], &ends[1]));
    assert_int_equal(0, ends[0].descriptor);
    assert_int_equal(1, ends[1].descriptor);
    assert_int_equal(0U, ends[0].waits_to_skip);
    assert_int_equal(0U, ends[1].waits_to_skip);
    will_return(__wrap_socketpair, -EMFILE);
    assert_int_equal(STATUS_IO, osal_local_pair(&ends[0], &ends[1]));
    assert_int_equal(-1, ends[0].descriptor);
    assert_int_equal(-1, ends[1].descriptor);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(a_socket_that_does_not_open_is_reported_and_closed, set_up),
        cmocka_unit_test_setup(the_reason_for_an_unaccepted_connection_is_reported, set_up),
        cmocka_unit_test_setup(a_connection_in_progress_is_asked_for_its_result, set_up),
        cmocka_unit_test_setup(the_reason_why_octets_are_not_sent_is_reported, set_up),
        cmocka_unit_test_setup(each_end_of_a_stream_has_its_status, set_up),
        cmocka_unit_test_setup(a_datagram_is_distinguished_from_errors_of_earlier_ones, set_up),
        cmocka_unit_test_setup(a_deferred_datagram_is_removed_by_the_next_call, set_up),
        cmocka_unit_test_setup(a_wait_polls_less_often_after_unsuccessful_polls, set_up),
        cmocka_unit_test_setup(a_wait_continues_after_a_signal_and_ends_with_an_error, set_up),
        cmocka_unit_test_setup(a_wait_for_room_ends_like_one_for_octets, set_up),
        cmocka_unit_test_setup(each_kind_of_socket_has_its_options, set_up),
        cmocka_unit_test_setup(a_pair_has_two_ends_or_is_not_opened, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
