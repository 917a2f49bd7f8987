// SPDX-License-Identifier: Apache-2.0
// What the TIPC port asks of the kernel, and what it makes of each answer: the system calls are played, so
// that kernels without TIPC test it, too. What a real kernel does is in test/contract/osal/test_tipc.c.
#include "osal/include/osal/tipc.h"
#include "unity.h"

#include <errno.h>
#include <linux/tipc.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define TYPE 0x48000001U
#define NODE 0x01001002U
#define REF 77U

static struct {
    int socket_error; // 0: it opens.
    int type;
    int option_error;
    int bind_error;
    struct sockaddr_tipc bound;
    unsigned interrupted; // Calls to fail with EINTR first.
    int call_error;       // Of sendto, recvmsg, recv, getsockname; 0: they succeed.
    struct sockaddr_tipc to;
    struct tipc_subscr subscription;
    struct tipc_event event;
    ssize_t received;
    int flags;
    int told; // Kind of control data; 0: none.
} kernel;

static int answer(int error)
{
    if (kernel.interrupted > 0U) {
        kernel.interrupted--;
        errno = EINTR;
        return -1;
    }
    errno = error;
    return (error == 0) ? 0 : -1;
}

int socket(int domain, int type, int protocol)
{
    TEST_ASSERT_EQUAL(AF_TIPC, domain);
    TEST_ASSERT_EQUAL(0, protocol);
    TEST_ASSERT_TRUE((type & SOCK_NONBLOCK) != 0);
    TEST_ASSERT_TRUE((type & SOCK_CLOEXEC) != 0);
    kernel.type = type & ~(SOCK_NONBLOCK | SOCK_CLOEXEC);
    errno       = kernel.socket_error;
    return (kernel.socket_error == 0) ? dup(STDERR_FILENO) : -1;
}

int setsockopt(int descriptor, int level, int option, const void* value, socklen_t size)
{
    (void)descriptor;
    (void)option;
    (void)value;
    TEST_ASSERT_EQUAL(SOL_TIPC, level);
    TEST_ASSERT_EQUAL(sizeof(uint32_t), size);
    return answer(kernel.option_error);
}

int bind(int descriptor, const struct sockaddr* address, socklen_t size)
{
    (void)descriptor;
    TEST_ASSERT_EQUAL(sizeof kernel.bound, size);
    (void)memcpy(&kernel.bound, address, sizeof kernel.bound);
    return answer(kernel.bind_error);
}

ssize_t sendto(int descriptor, const void* octets, size_t size, int flags, const struct sockaddr* to,
               socklen_t to_size)
{
    (void)descriptor;
    TEST_ASSERT_EQUAL(MSG_NOSIGNAL | MSG_DONTWAIT, flags);
    TEST_ASSERT_EQUAL(sizeof kernel.to, to_size);
    (void)memcpy(&kernel.to, to, sizeof kernel.to);
    if (size == sizeof kernel.subscription) {
        (void)memcpy(&kernel.subscription, octets, size);
    }
    return (answer(kernel.call_error) == 0) ? (ssize_t)size : -1;
}

ssize_t recvmsg(int descriptor, struct msghdr* message, int flags)
{
    (void)descriptor;
    TEST_ASSERT_EQUAL(MSG_DONTWAIT, flags);
    if (answer(kernel.call_error) != 0) {
        return -1;
    }
    struct sockaddr_tipc* const from = message->msg_name;
    from->addr.id.ref                = REF;
    from->addr.id.node               = NODE;
    message->msg_flags               = kernel.flags;
    if (kernel.told == 0) {
        message->msg_controllen = 0U;
    } else {
        struct cmsghdr* const part = CMSG_FIRSTHDR(message);
        part->cmsg_level           = SOL_TIPC;
        part->cmsg_type            = kernel.told;
        part->cmsg_len             = CMSG_LEN(8U);
        message->msg_controllen    = CMSG_SPACE(8U);
    }
    return kernel.received;
}

ssize_t recv(int descriptor, void* octets, size_t size, int flags)
{
    (void)descriptor;
    TEST_ASSERT_EQUAL(MSG_DONTWAIT, flags);
    TEST_ASSERT_EQUAL(sizeof kernel.event, size);
    if (answer(kernel.call_error) != 0) {
        return -1;
    }
    (void)memcpy(octets, &kernel.event, sizeof kernel.event);
    return kernel.received;
}

int getsockname(int descriptor, struct sockaddr* address, socklen_t* size)
{
    (void)descriptor;
    (void)size;
    struct sockaddr_tipc own = {.family = AF_TIPC};
    own.addr.id.ref          = REF;
    own.addr.id.node         = NODE;
    (void)memcpy(address, &own, sizeof own);
    return answer(kernel.call_error);
}

static osal_socket_t sock;
static uint8_t octets[100];
static uint64_t from;
static size_t size;
static const osal_tipc_name_t name = {TYPE, 16U};

void setUp(void)
{
    (void)memset(&kernel, 0, sizeof kernel);
    sock = (osal_socket_t)OSAL_SOCKET_CLOSED;
}

void tearDown(void)
{
    if (sock.descriptor >= 0) {
        (void)close(sock.descriptor);
    }
}

typedef struct {
    int error;
    status_t status;
} answer_t;

#define EACH(table, entry)                                                                                   \
    for (const answer_t* entry = table; entry < &table[sizeof(table) / sizeof((table)[0])]; entry++)

static const answer_t openings[] = {{EAFNOSUPPORT, STATUS_UNSUPPORTED},
                                    {EPROTONOSUPPORT, STATUS_UNSUPPORTED},
                                    {ESOCKTNOSUPPORT, STATUS_UNSUPPORTED},
                                    {EACCES, STATUS_DENIED},
                                    {EPERM, STATUS_DENIED},
                                    {EMFILE, STATUS_EXHAUSTED},
                                    {ENFILE, STATUS_EXHAUSTED},
                                    {ENOBUFS, STATUS_EXHAUSTED},
                                    {ENOMEM, STATUS_EXHAUSTED},
                                    {EINVAL, STATUS_IO}};

static void a_socket_has_its_kind_and_its_name(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, &name, OSAL_TIPC_CLUSTER));
    TEST_ASSERT_EQUAL(SOCK_RDM, kernel.type);
    TEST_ASSERT_EQUAL(TIPC_SERVICE_RANGE, kernel.bound.addrtype);
    TEST_ASSERT_EQUAL(TIPC_CLUSTER_SCOPE, kernel.bound.scope);
    TEST_ASSERT_EQUAL_HEX32(TYPE, kernel.bound.addr.nameseq.type);
    TEST_ASSERT_EQUAL(16U, kernel.bound.addr.nameseq.lower);
    TEST_ASSERT_EQUAL(16U, kernel.bound.addr.nameseq.upper);
    (void)close(sock.descriptor);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_open(&sock, OSAL_TIPC_SAMPLE, &name, OSAL_TIPC_NODE));
    TEST_ASSERT_EQUAL(SOCK_DGRAM, kernel.type);
    TEST_ASSERT_EQUAL(TIPC_NODE_SCOPE, kernel.bound.scope);
}

static void what_does_not_open_is_told(void)
{
    EACH(openings, entry)
    {
        kernel = (__typeof__(kernel)){.socket_error = entry->error};
        TEST_ASSERT_EQUAL(entry->status, osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, &name, OSAL_TIPC_NODE));
        TEST_ASSERT_EQUAL(-1, sock.descriptor);
        TEST_ASSERT_EQUAL(entry->status, osal_tipc_watch_open(&sock, TYPE));
        kernel = (__typeof__(kernel)){.bind_error = entry->error};
        TEST_ASSERT_EQUAL(entry->status, osal_tipc_open(&sock, OSAL_TIPC_SAMPLE, &name, OSAL_TIPC_NODE));
        TEST_ASSERT_EQUAL(-1, sock.descriptor);
        kernel = (__typeof__(kernel)){.option_error = entry->error};
        TEST_ASSERT_EQUAL(entry->status, osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, NULL, OSAL_TIPC_NODE));
    }
}

static void a_message_goes_to_a_name(void)
{
    static const answer_t sendings[] = {{EAGAIN, STATUS_FULL},         {ENOBUFS, STATUS_FULL},
                                        {ENOMEM, STATUS_FULL},         {EMSGSIZE, STATUS_TOO_LARGE},
                                        {EHOSTUNREACH, STATUS_CLOSED}, {ENETUNREACH, STATUS_CLOSED},
                                        {ECONNREFUSED, STATUS_CLOSED}, {ECONNRESET, STATUS_CLOSED},
                                        {EPIPE, STATUS_CLOSED},        {EINVAL, STATUS_IO}};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, NULL, OSAL_TIPC_NODE));
    kernel.interrupted = 2U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_send(&sock, name, octets, 5U));
    TEST_ASSERT_EQUAL(TIPC_SERVICE_ADDR, kernel.to.addrtype);
    TEST_ASSERT_EQUAL_HEX32(TYPE, kernel.to.addr.name.name.type);
    TEST_ASSERT_EQUAL(16U, kernel.to.addr.name.name.instance);
    TEST_ASSERT_EQUAL(0U, kernel.to.addr.name.domain);
    EACH(sendings, entry)
    {
        kernel.call_error = entry->error;
        TEST_ASSERT_EQUAL(entry->status, osal_tipc_send(&sock, name, octets, 5U));
    }
}

static void what_comes_is_told_apart(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, NULL, OSAL_TIPC_NODE));
    kernel.received    = 7;
    kernel.interrupted = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_receive(&sock, &from, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(7U, size);
    TEST_ASSERT_EQUAL_HEX64(((uint64_t)NODE << 32U) | REF, from);
    kernel.told = TIPC_DESTNAME; // Says to which of its names it was sent: a message like any other.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_receive(&sock, &from, octets, sizeof octets, &size));
    kernel.flags = MSG_TRUNC;
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, osal_tipc_receive(&sock, &from, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(0U, size);
    kernel.told = TIPC_ERRINFO;
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, osal_tipc_receive(&sock, &from, octets, sizeof octets, &size));
    kernel.call_error = EAGAIN;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tipc_receive(&sock, &from, octets, sizeof octets, &size));
    kernel.call_error = ECONNRESET;
    TEST_ASSERT_EQUAL(STATUS_IO, osal_tipc_receive(&sock, &from, octets, sizeof octets, &size));
}

static void a_socket_has_an_identity(void)
{
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_open(&sock, OSAL_TIPC_MESSAGE, NULL, OSAL_TIPC_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_identity(&sock, &from));
    TEST_ASSERT_EQUAL_HEX64(((uint64_t)NODE << 32U) | REF, from);
    kernel.call_error = EBADF;
    TEST_ASSERT_EQUAL(STATUS_IO, osal_tipc_identity(&sock, &from));
}

static void a_watch_asks_for_all_of_a_type(void)
{
    osal_tipc_event_t event = {false, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_watch_open(&sock, TYPE));
    TEST_ASSERT_EQUAL(SOCK_SEQPACKET, kernel.type);
    TEST_ASSERT_EQUAL(TIPC_TOP_SRV, kernel.to.addr.name.name.type);
    TEST_ASSERT_EQUAL_HEX32(TYPE, kernel.subscription.seq.type);
    TEST_ASSERT_EQUAL(0U, kernel.subscription.seq.lower);
    TEST_ASSERT_EQUAL(UINT32_MAX, kernel.subscription.seq.upper);
    TEST_ASSERT_EQUAL(TIPC_SUB_PORTS, kernel.subscription.filter);
    kernel.event.event       = TIPC_PUBLISHED;
    kernel.event.found_lower = 17U;
    kernel.received          = (ssize_t)sizeof kernel.event;
    kernel.interrupted       = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_watch_next(&sock, &event));
    TEST_ASSERT_TRUE(event.is_published);
    TEST_ASSERT_EQUAL(17U, event.instance);
    kernel.event.event = TIPC_WITHDRAWN;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_tipc_watch_next(&sock, &event));
    TEST_ASSERT_FALSE(event.is_published);
    kernel.received = 0;
    TEST_ASSERT_EQUAL(STATUS_CLOSED, osal_tipc_watch_next(&sock, &event));
    kernel.call_error = EAGAIN;
    TEST_ASSERT_EQUAL(STATUS_EMPTY, osal_tipc_watch_next(&sock, &event));
    kernel.call_error = ECONNRESET;
    TEST_ASSERT_EQUAL(STATUS_IO, osal_tipc_watch_next(&sock, &event));
}

static void a_watch_that_is_refused_is_told(void)
{
    kernel.call_error = EHOSTUNREACH;
    TEST_ASSERT_EQUAL(STATUS_IO, osal_tipc_watch_open(&sock, TYPE));
    TEST_ASSERT_EQUAL(-1, sock.descriptor);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_socket_has_its_kind_and_its_name);
    RUN_TEST(what_does_not_open_is_told);
    RUN_TEST(a_message_goes_to_a_name);
    RUN_TEST(what_comes_is_told_apart);
    RUN_TEST(a_socket_has_an_identity);
    RUN_TEST(a_watch_asks_for_all_of_a_type);
    RUN_TEST(a_watch_that_is_refused_is_told);
    return UNITY_END();
}
