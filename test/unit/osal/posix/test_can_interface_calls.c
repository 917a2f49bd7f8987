// SPDX-License-Identifier: Apache-2.0
// Requests of the port to rtnetlink, octet for octet, and its reaction to each answer. The system calls are
// mocked, so that the test also runs without CAN in the kernel; test/contract/osal/posix/test_can_socket.c
// tests with a real kernel.
#define _GNU_SOURCE
#include "osal/include/osal/can_interface.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/netlink.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <cmocka.h>

#define CAN 0 // Descriptors: the lowest one, and some that are not open.
#define NETLINK 4711
#define CLAIM 4712
#define COUNT(table) (sizeof(table) / sizeof((table)[0]))

typedef struct {
    uint8_t octets[512];
    size_t size;
} message_t;

static message_t asked[3]; // Requests since the last call.
static unsigned asked_count;
static message_t answers[3];   // Answers of the kernel in order.
static int errors[3];          // Error of the call for each answer; 0: none.
static unsigned interruptions; // Signals before the next answer.
static int open_count;
static int can_error;    // Error of the socket for CAN.
static int socket_error; // Error of any other socket.
static int send_error;
static int bind_error;
static struct sockaddr_un bound;
static socklen_t bound_size;

static int failure(const int error)
{
    errno = error;
    return -1;
}

int __wrap_socket(int domain, int type, int protocol)
{
    const int error = (domain == PF_CAN) ? can_error : socket_error;
    if (domain == PF_CAN) {
        assert_int_equal(SOCK_RAW | SOCK_CLOEXEC, type);
        assert_int_equal(CAN_RAW, protocol);
    } else if (domain == AF_NETLINK) {
        assert_int_equal(SOCK_RAW | SOCK_CLOEXEC, type);
        assert_int_equal(NETLINK_ROUTE, protocol);
    } else {
        assert_int_equal(AF_UNIX, domain);
        assert_int_equal(SOCK_DGRAM | SOCK_CLOEXEC, type);
        assert_int_equal(0, protocol);
    }
    if (error != 0) {
        return failure(error);
    }
    open_count++;
    return (domain == PF_CAN) ? CAN : ((domain == AF_NETLINK) ? NETLINK : CLAIM);
}

int __real_close(int descriptor);
int __wrap_close(int descriptor)
{
    if ((descriptor != CAN) && (descriptor != NETLINK) && (descriptor != CLAIM)) {
        return __real_close(descriptor); // A coverage build makes such calls itself.
    }
    open_count--;
    return 0;
}

/// The wait for the answer has a limit.
int __wrap_setsockopt(int descriptor, int level, int option, const void* value, socklen_t size)
{
    const struct timeval timeout = {.tv_sec = 5};
    assert_int_equal(NETLINK, descriptor);
    assert_int_equal(SOL_SOCKET, level);
    assert_int_equal(SO_RCVTIMEO, option);
    assert_int_equal(sizeof timeout, size);
    assert_memory_equal(&timeout, value, sizeof timeout);
    function_called();
    return 0;
}

ssize_t __wrap_send(int descriptor, const void* octets, size_t size, int flags)
{
    assert_int_equal(NETLINK, descriptor);
    assert_int_equal(0, flags);
    assert_true((asked_count < COUNT(asked)) && (size <= sizeof asked[0].octets));
    (void)memcpy(asked[asked_count].octets, octets, size);
    asked[asked_count].size = size;
    asked_count++;
    return (send_error != 0) ? failure(send_error) : (ssize_t)size;
}

ssize_t __wrap_recv(int descriptor, void* octets, size_t capacity, int flags)
{
    const message_t* const answer = &answers[asked_count - 1U];
    assert_int_equal(NETLINK, descriptor);
    assert_int_equal(0, flags);
    assert_true(capacity >= 8192U); // Enough for a link with all its statistics.
    if (interruptions > 0U) {
        interruptions--;
        return failure(EINTR);
    }
    if (errors[asked_count - 1U] != 0) {
        return failure(errors[asked_count - 1U]);
    }
    (void)memset(octets, 0xA5, capacity);
    (void)memcpy(octets, answer->octets, answer->size);
    return (ssize_t)answer->size;
}

int __wrap_bind(int descriptor, const struct sockaddr* address, socklen_t size)
{
    assert_int_equal(CLAIM, descriptor);
    assert_true(size <= sizeof bound);
    (void)memcpy(&bound, address, size);
    bound_size = size;
    return (bind_error != 0) ? failure(bind_error) : 0;
}

// ---- Messages of netlink, encoded independently of the port ----

static void append(message_t* message, const void* octets, const size_t size)
{
    assert_true((message->size + size) <= sizeof message->octets);
    (void)memcpy(&message->octets[message->size], octets, size);
    message->size += size;
}

static void begin(message_t* message, const uint16_t type, const uint16_t flags,
                  const struct ifinfomsg* device)
{
    const struct nlmsghdr header = {.nlmsg_type = type, .nlmsg_flags = flags};
    *message                     = (message_t){.size = 0U};
    append(message, &header, sizeof header);
    append(message, device, sizeof *device);
}

/// Begin an attribute; all octets up to close_attribute() are its content.
static size_t open_attribute(message_t* message, const uint16_t type)
{
    const struct rtattr attribute = {.rta_type = type};
    const size_t at               = message->size;
    append(message, &attribute, sizeof attribute);
    return at;
}

static void close_attribute(message_t* message, const size_t at)
{
    static const uint8_t padding[4] = {0};
    const uint16_t length           = (uint16_t)(message->size - at);
    (void)memcpy(&message->octets[at], &length, sizeof length);
    append(message, padding, (4U - (message->size % 4U)) % 4U);
}

static void attribute(message_t* message, const uint16_t type, const void* octets, const size_t size)
{
    const size_t at = open_attribute(message, type);
    append(message, octets, size);
    close_attribute(message, at);
}

static void end(message_t* message)
{
    const uint32_t length = (uint32_t)message->size;
    (void)memcpy(message->octets, &length, sizeof length);
}

/// The kernel's answer number `at`: an error, 0 for success.
static void will_answer(const unsigned at, const int error)
{
    const struct nlmsghdr header       = {.nlmsg_type = NLMSG_ERROR};
    const struct nlmsgerr kernel_error = {.error = -error};
    answers[at]                        = (message_t){.size = 0U};
    errors[at]                         = 0;
    append(&answers[at], &header, sizeof header);
    append(&answers[at], &kernel_error, sizeof kernel_error);
    end(&answers[at]);
}

typedef struct {
    unsigned flags;
    uint32_t mtu;
    const char* label;
    const char* kind;
    uint32_t bit_rate;
    uint32_t data_bit_rate;
    uint32_t state;
} link_t;

static void will_answer_link(const link_t* link, const unsigned short type)
{
    const struct ifinfomsg device = {.ifi_type = type, .ifi_flags = link->flags};
    message_t* const answer       = &answers[0];
    begin(answer, RTM_NEWLINK, 0U, &device);
    attribute(answer, IFLA_IFNAME, "can7", 5U);
    attribute(answer, IFLA_MTU, &link->mtu, sizeof link->mtu);
    attribute(answer, IFLA_IFALIAS, link->label, strlen(link->label));
    const size_t information = open_attribute(answer, IFLA_LINKINFO);
    attribute(answer, IFLA_INFO_KIND, link->kind, strlen(link->kind));
    const size_t controller      = open_attribute(answer, IFLA_INFO_DATA);
    const uint32_t bit_timing[]  = {link->bit_rate, 875U};
    const uint32_t data_timing[] = {link->data_bit_rate, 750U};
    const struct can_clock clock = {.freq = 80000000U};
    attribute(answer, IFLA_CAN_BITTIMING, bit_timing, sizeof bit_timing);
    attribute(answer, IFLA_CAN_DATA_BITTIMING, data_timing, sizeof data_timing);
    attribute(answer, IFLA_CAN_CLOCK, &clock, sizeof clock);
    attribute(answer, IFLA_CAN_STATE, &link->state, sizeof link->state);
    close_attribute(answer, controller);
    close_attribute(answer, information);
    end(answer);
}

static void assert_asked(const unsigned at, message_t* expected)
{
    end(expected);
    assert_true(at < asked_count);
    assert_int_equal(expected->size, asked[at].size);
    assert_memory_equal(expected->octets, asked[at].octets, expected->size);
}

static int set_up(void** state)
{
    (void)state;
    for (unsigned i = 0U; i < COUNT(answers); i++) {
        will_answer(i, 0);
    }
    asked_count   = 0U;
    interruptions = 0U;
    open_count    = 0;
    can_error     = 0;
    socket_error  = 0;
    send_error    = 0;
    bind_error    = 0;
    return 0;
}

static status_t look(osal_can_interface_t* out_seen)
{
    (void)memset(out_seen, 0xFF, sizeof *out_seen);
    asked_count           = 0U;
    const status_t status = osal_can_interface_look("can7", out_seen);
    assert_int_equal(0, open_count);
    return status;
}

// ---- Queries ----

static void the_attributes_of_an_interface_are_reported(void** state)
{
    static const char long_label[] = "0123456789012345678901234567890123456789";
    static const struct {
        link_t link;
        osal_can_interface_t seen;
    } links[] = {
        {{IFF_UP, CANFD_MTU, "hirosco", "vcan", 1U, 2U, CAN_STATE_BUS_OFF},
         {.is_virtual = true, .is_up = true, .carries_fd = true, .label = "hirosco"}},
        {{IFF_UP | IFF_RUNNING, CAN_MTU, "", "vxcan", 0U, 0U, 0U}, {.is_virtual = true, .is_up = true}},
        {{IFF_RUNNING, CANFD_MTU - 1U, "a", "can", 500000U, 2000000U, CAN_STATE_ERROR_PASSIVE},
         {.bit_rate = 500000U, .data_bit_rate = 2000000U, .label = "a"}},
        {{0U, CANFD_MTU + 1U, long_label, "vca", 1000000U, 0U, CAN_STATE_BUS_OFF},
         {.carries_fd = true,
          .is_bus_off = true,
          .bit_rate   = 1000000U,
          .label      = "0123456789012345678901234567890"}},
        {{0U, 0U, "b", "slcan", 7U, 8U, CAN_STATE_STOPPED},
         {.bit_rate = 7U, .data_bit_rate = 8U, .label = "b"}},
    };
    osal_can_interface_t seen;
    message_t expected;
    (void)state;
    for (unsigned i = 0U; i < COUNT(links); i++) {
        will_answer_link(&links[i].link, ARPHRD_CAN);
        interruptions = i;
        expect_function_call(__wrap_setsockopt);
        assert_int_equal(STATUS_OK, look(&seen));
        assert_int_equal(links[i].seen.is_virtual, seen.is_virtual);
        assert_int_equal(links[i].seen.is_up, seen.is_up);
        assert_int_equal(links[i].seen.is_bus_off, seen.is_bus_off);
        assert_int_equal(links[i].seen.carries_fd, seen.carries_fd);
        assert_int_equal(links[i].seen.bit_rate, seen.bit_rate);
        assert_int_equal(links[i].seen.data_bit_rate, seen.data_bit_rate);
        assert_string_equal(links[i].seen.label, seen.label);
        begin(&expected, RTM_GETLINK, NLM_F_REQUEST, &(struct ifinfomsg){.ifi_family = AF_UNSPEC});
        attribute(&expected, IFLA_IFNAME, "can7", 5U);
        assert_asked(0U, &expected);
    }
}

/// An answer truncated at any position: the port reads nothing beyond it and reports the part before.
static void a_truncated_answer_is_used_up_to_its_last_complete_attribute(void** state)
{
    const link_t link = {IFF_UP, CANFD_MTU, "hirosco", "can", 500000U, 2000000U, CAN_STATE_BUS_OFF};
    const size_t head = sizeof(struct nlmsghdr) + sizeof(struct ifinfomsg);
    osal_can_interface_t whole;
    osal_can_interface_t seen;
    (void)state;
    will_answer_link(&link, ARPHRD_CAN);
    const size_t size = answers[0].size;
    expect_function_call(__wrap_setsockopt);
    assert_int_equal(STATUS_OK, look(&whole));
    for (size_t left = 0U; left < size; left++) {
        will_answer_link(&link, ARPHRD_CAN);
        answers[0].size = left; // Shorter than the length in its header.
        expect_function_call(__wrap_setsockopt);
        assert_int_equal(STATUS_IO, look(&seen));
        end(&answers[0]); // The header has the truncated length, too.
        if (left < head) {
            expect_function_call(__wrap_setsockopt);
            assert_int_equal(STATUS_IO, look(&seen));
            continue;
        }
        expect_function_call(__wrap_setsockopt);
        assert_int_equal(STATUS_OK, look(&seen));
        const size_t name_end = head + 12U;
        const size_t mtu_end  = name_end + 8U;
        assert_true(seen.is_up);
        assert_int_equal(left >= mtu_end, seen.carries_fd);
        assert_string_equal((left >= (mtu_end + 4U + strlen(link.label))) ? link.label : "", seen.label);
        assert_int_equal(0U, seen.bit_rate); // The information of the link is incomplete.
    }
    assert_int_equal(500000U, whole.bit_rate);
}

/// An attribute with a wrong size ends the parsing: no endless loop, no read beyond the end.
static void attributes_of_a_wrong_size_end_the_search(void** state)
{
    static const uint16_t sizes[] = {0U, 1U, 3U, 21U, UINT16_MAX};
    const link_t link             = {0U, CANFD_MTU, "hirosco", "can", 500000U, 0U, 0U};
    const size_t head             = sizeof(struct nlmsghdr) + sizeof(struct ifinfomsg);
    osal_can_interface_t seen;
    (void)state;
    for (unsigned i = 0U; i < COUNT(sizes); i++) {
        will_answer_link(&link, ARPHRD_CAN);
        answers[0].size = head + 20U;
        end(&answers[0]);
        // Size of the name attribute; the MTU follows it.
        (void)memcpy(&answers[0].octets[head], &sizes[i], sizeof sizes[i]);
        expect_function_call(__wrap_setsockopt);
        assert_int_equal(STATUS_OK, look(&seen));
        assert_false(seen.carries_fd);
    }
    const uint16_t none = (uint16_t)sizeof(struct rtattr); // An attribute without content is valid.
    will_answer_link(&link, ARPHRD_CAN);
    (void)memmove(&answers[0].octets[head + 4U], &answers[0].octets[head + 12U],
                  answers[0].size - head - 12U);
    answers[0].size -= 8U;
    end(&answers[0]);
    (void)memcpy(&answers[0].octets[head], &none, sizeof none);
    expect_function_call(__wrap_setsockopt);
    assert_int_equal(STATUS_OK, look(&seen));
    assert_true(seen.carries_fd);
    assert_int_equal(500000U, seen.bit_rate);
    const struct ifinfomsg device = {.ifi_type = ARPHRD_CAN};
    begin(&answers[0], RTM_NEWLINK, 0U, &device); // Too short for a number.
    attribute(&answers[0], IFLA_MTU, "\xFF\xFF", 2U);
    end(&answers[0]);
    expect_function_call(__wrap_setsockopt);
    assert_int_equal(STATUS_OK, look(&seen));
    assert_false(seen.carries_fd);
}

static void an_interface_that_is_no_can_interface_is_reported(void** state)
{
    const link_t link = {IFF_UP, 65536U, "", "can", 0U, 0U, 0U};
    osal_can_interface_t seen;
    (void)state;
    will_answer_link(&link, ARPHRD_LOOPBACK);
    expect_function_call(__wrap_setsockopt);
    assert_int_equal(STATUS_NOT_OURS, look(&seen));
    assert_false(seen.is_up);
    will_answer(0U, 0); // The kernel reports success, but sends no link.
    expect_function_call(__wrap_setsockopt);
    assert_int_equal(STATUS_IO, look(&seen));
    can_error = EAFNOSUPPORT;
    assert_int_equal(STATUS_UNSUPPORTED, look(&seen));
    assert_int_equal(0U, asked_count);
    assert_int_equal(STATUS_INVALID, osal_can_interface_look("a:b", &seen));
}

static const struct {
    int error;
    status_t look;
    status_t make;
    status_t remove;
} kernel_error[] = {{EPERM, STATUS_DENIED, STATUS_DENIED, STATUS_DENIED},
                    {EACCES, STATUS_DENIED, STATUS_DENIED, STATUS_DENIED},
                    {EEXIST, STATUS_IO, STATUS_EXISTS, STATUS_IO},
                    {ENODEV, STATUS_NOT_FOUND, STATUS_IO, STATUS_NOT_FOUND},
                    {EOPNOTSUPP, STATUS_IO, STATUS_UNSUPPORTED, STATUS_UNSUPPORTED},
                    {EAFNOSUPPORT, STATUS_IO, STATUS_UNSUPPORTED, STATUS_UNSUPPORTED},
                    {EPROTONOSUPPORT, STATUS_IO, STATUS_UNSUPPORTED, STATUS_UNSUPPORTED},
                    {EIO, STATUS_IO, STATUS_IO, STATUS_IO},
                    {ENOBUFS, STATUS_IO, STATUS_IO, STATUS_IO}};

/// Expect that each of the three calls reports the error of its first request.
static void expect_refusals(const unsigned i, const unsigned socket_options)
{
    osal_can_interface_t seen;
    expect_function_calls(__wrap_setsockopt, (int)(3U * socket_options));
    assert_int_equal(kernel_error[i].look, look(&seen));
    asked_count = 0U;
    assert_int_equal(kernel_error[i].make, osal_can_interface_create("can7", true, ""));
    assert_true(asked_count <= 1U); // An interface that was not made is not removed: it may belong to others.
    asked_count = 0U;
    assert_int_equal(kernel_error[i].remove, osal_can_interface_remove("can7"));
    assert_int_equal(0, open_count);
}

static void errors_of_the_kernel_are_reported(void** state)
{
    (void)state;
    for (unsigned i = 0U; i < COUNT(kernel_error); i++) {
        will_answer(0U, kernel_error[i].error);
        expect_refusals(i, 1U);
        will_answer(0U, 0);
        send_error = kernel_error[i].error;
        expect_refusals(i, 1U);
        send_error   = 0;
        socket_error = kernel_error[i].error;
        osal_can_interface_t seen;
        assert_int_equal(kernel_error[i].look, look(&seen));
        assert_int_equal(kernel_error[i].make, osal_can_interface_create("can7", true, ""));
        assert_int_equal(kernel_error[i].remove, osal_can_interface_remove("can7"));
        assert_int_equal(0, open_count);
        socket_error = 0;
    }
    errors[0] = EAGAIN; // No answer in time.
    expect_function_call(__wrap_setsockopt);
    assert_int_equal(STATUS_IO, osal_can_interface_remove("can7"));
    assert_int_equal(0, open_count);
}

// ---- Making and removing ----

static void begin_removal(message_t* message)
{
    begin(message, RTM_DELLINK, NLM_F_REQUEST | NLM_F_ACK, &(struct ifinfomsg){.ifi_family = AF_UNSPEC});
    attribute(message, IFLA_IFNAME, "can7", 5U);
}

static void an_interface_is_made_with_its_label(void** state)
{
    static const char longest[] = "0123456789012345678901234567890";
    message_t expected;
    (void)state;
    for (unsigned is_fd = 0U; is_fd <= 1U; is_fd++) {
        const uint32_t mtu = (is_fd != 0U) ? CANFD_MTU : CAN_MTU;
        asked_count        = 0U;
        expect_function_calls(__wrap_setsockopt, 2);
        assert_int_equal(STATUS_OK, osal_can_interface_create("can7", is_fd != 0U, longest));
        assert_int_equal(0, open_count);
        assert_int_equal(2U, asked_count);
        begin(&expected, RTM_NEWLINK, NLM_F_REQUEST | NLM_F_ACK | NLM_F_CREATE | NLM_F_EXCL,
              &(struct ifinfomsg){.ifi_family = AF_UNSPEC, .ifi_flags = IFF_UP, .ifi_change = IFF_UP});
        attribute(&expected, IFLA_IFNAME, "can7", 5U);
        attribute(&expected, IFLA_MTU, &mtu, sizeof mtu);
        const size_t information = open_attribute(&expected, IFLA_LINKINFO);
        attribute(&expected, IFLA_INFO_KIND, "vcan", 4U);
        close_attribute(&expected, information);
        assert_asked(0U, &expected);
        begin(&expected, RTM_SETLINK, NLM_F_REQUEST | NLM_F_ACK,
              &(struct ifinfomsg){.ifi_family = AF_UNSPEC});
        attribute(&expected, IFLA_IFNAME, "can7", 5U);
        attribute(&expected, IFLA_IFALIAS, longest, sizeof longest - 1U);
        assert_asked(1U, &expected);
    }
    assert_int_equal(STATUS_INVALID,
                     osal_can_interface_create("can7", true, "01234567890123456789012345678901"));
}

static void an_interface_that_gets_no_label_is_removed(void** state)
{
    message_t expected;
    (void)state;
    for (unsigned i = 0U; i < COUNT(kernel_error); i++) {
        asked_count = 0U;
        will_answer(1U, kernel_error[i].error);
        expect_function_calls(__wrap_setsockopt, 3);
        assert_int_equal(STATUS_IO, osal_can_interface_create("can7", true, "label"));
        assert_int_equal(3U, asked_count);
        begin_removal(&expected);
        assert_asked(2U, &expected);
    }
}

static void an_interface_is_removed(void** state)
{
    message_t expected;
    (void)state;
    expect_function_call(__wrap_setsockopt);
    assert_int_equal(STATUS_OK, osal_can_interface_remove("can7"));
    assert_int_equal(1U, asked_count);
    begin_removal(&expected);
    assert_asked(0U, &expected);
}

// ---- Claims ----

static void a_claim_is_an_abstract_name(void** state)
{
    static const char path[] = "\0hirosco.can.can7";
    osal_can_claim_t claim;
    (void)state;
    assert_int_equal(STATUS_OK, osal_can_interface_claim("can7", &claim));
    assert_int_equal(AF_UNIX, bound.sun_family);
    assert_int_equal(offsetof(struct sockaddr_un, sun_path) + sizeof path - 1U, bound_size);
    assert_memory_equal(path, bound.sun_path, sizeof path - 1U);
    assert_int_equal(CLAIM, claim.descriptor);
    osal_can_interface_release(&claim);
    osal_can_interface_release(&claim);
    assert_int_equal(0, open_count);
    claim.descriptor = CAN; // Descriptor 0 is valid.
    open_count       = 1;
    osal_can_interface_release(&claim);
    assert_int_equal(0, open_count);
    assert_int_equal(-1, claim.descriptor);
}

static void a_claim_that_is_not_granted_leaves_nothing(void** state)
{
    osal_can_claim_t claim;
    (void)state;
    bind_error = EADDRINUSE;
    assert_int_equal(STATUS_EXISTS, osal_can_interface_claim("can7", &claim));
    assert_int_equal(-1, claim.descriptor);
    bind_error = ENOMEM;
    assert_int_equal(STATUS_IO, osal_can_interface_claim("can7", &claim));
    assert_int_equal(-1, claim.descriptor);
    socket_error = EMFILE;
    assert_int_equal(STATUS_IO, osal_can_interface_claim("can7", &claim));
    assert_int_equal(-1, claim.descriptor);
    assert_int_equal(0, open_count);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(the_attributes_of_an_interface_are_reported, set_up),
        cmocka_unit_test_setup(a_truncated_answer_is_used_up_to_its_last_complete_attribute, set_up),
        cmocka_unit_test_setup(attributes_of_a_wrong_size_end_the_search, set_up),
        cmocka_unit_test_setup(an_interface_that_is_no_can_interface_is_reported, set_up),
        cmocka_unit_test_setup(errors_of_the_kernel_are_reported, set_up),
        cmocka_unit_test_setup(an_interface_is_made_with_its_label, set_up),
        cmocka_unit_test_setup(an_interface_that_gets_no_label_is_removed, set_up),
        cmocka_unit_test_setup(an_interface_is_removed, set_up),
        cmocka_unit_test_setup(a_claim_is_an_abstract_name, set_up),
        cmocka_unit_test_setup(a_claim_that_is_not_granted_leaves_nothing, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
