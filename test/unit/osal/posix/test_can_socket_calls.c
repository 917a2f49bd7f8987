// SPDX-License-Identifier: Apache-2.0
// System calls of the SocketCAN port, and its reaction to each answer of a CAN controller. The calls are
// mocked, so that the test also runs without CAN in the kernel; test/contract/osal/posix/test_can_socket.c
// tests with a real kernel.
#define _GNU_SOURCE
#include "osal/common/can_port.h"

#include <errno.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <poll.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <time.h>

#include <cmocka.h>

#define DESCRIPTOR 0 // The lowest valid descriptor: a program gets it if its standard input is closed.
#define INDEX 5
#define WALL_S 2000000000 // Values of the clocks.
#define NOW_S 5000
#define NOW_NS (NOW_S * 1000000000ULL)

static osal_can_t can;
static struct {
    unsigned short family;
    short flags;
    int mtu;
} interface;
static struct canfd_frame raw; // The last frame sent, or the next frame received.
static struct can_filter filters[OSAL_CAN_FILTERS_MAX];
static struct {
    struct timespec stamp; // Seconds 0: no time stamp comes with the frame.
    uint32_t overruns;
    bool has_overruns;
    struct {
        int level;
        int type;
    } other; // Replaces all other control data if its level is set.
} reported;

/// Give a mocked call its outcome: it succeeds with `result`, or fails with the error number -`result`.
static int answer(const int result)
{
    // After a success errno may have any value: a caller that then looks at it repeats the call.
    errno = (result < 0) ? -result : EINTR;
    return (result < 0) ? -1 : result;
}

int __wrap_socket(int domain, int type, int protocol)
{
    assert_int_equal(PF_CAN, domain);
    assert_int_equal(SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, type);
    assert_int_equal(CAN_RAW, protocol);
    return answer(mock_type(int));
}

int __wrap_ioctl(int descriptor, unsigned long request, ...)
{
    va_list arguments;
    va_start(arguments, request);
    struct ifreq* const about = va_arg(arguments, struct ifreq*);
    va_end(arguments);
    assert_int_equal(DESCRIPTOR, descriptor);
    check_expected(request);
    if (request == SIOCGIFINDEX) {
        assert_string_equal("can7", about->ifr_name);
        about->ifr_ifindex = INDEX;
    } else if (request == SIOCGIFHWADDR) {
        about->ifr_hwaddr.sa_family = interface.family;
    } else if (request == SIOCGIFFLAGS) {
        about->ifr_flags = interface.flags;
    } else {
        about->ifr_mtu = interface.mtu;
    }
    return answer(mock_type(int));
}

int __wrap_setsockopt(int descriptor, int level, int option, const void* value, socklen_t size)
{
    (void)level;
    assert_int_equal(DESCRIPTOR, descriptor);
    check_expected(option);
    if (option == CAN_RAW_FILTER) {
        check_expected(size);
        (void)memcpy(filters, (value != NULL) ? value : filters, size);
    } else if (option == CAN_RAW_ERR_FILTER) {
        assert_memory_equal(&(can_err_mask_t){CAN_ERR_MASK}, value, sizeof(can_err_mask_t));
    } else {
        assert_int_equal(sizeof(int), size);
    }
    return answer(mock_type(int));
}

int __wrap_bind(int descriptor, const struct sockaddr* address, socklen_t size)
{
    struct sockaddr_can wanted = {.can_family = AF_CAN, .can_ifindex = INDEX};
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(sizeof wanted, size);
    assert_memory_equal(&wanted, address, sizeof wanted);
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

ssize_t __wrap_send(int descriptor, const void* octets, size_t size, int flags)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(0, flags);
    check_expected(size);
    (void)memcpy(&raw, octets, size);
    return answer(mock_type(int));
}

ssize_t __wrap_recvmsg(int descriptor, struct msghdr* message, int flags)
{
    assert_int_equal(DESCRIPTOR, descriptor);
    assert_int_equal(0, flags);
    (void)memcpy(message->msg_iov[0].iov_base, &raw, sizeof raw);
    size_t used          = 0U;
    struct cmsghdr* part = CMSG_FIRSTHDR(message);
    if ((reported.other.level != 0) && (part != NULL)) {
        *part = (struct cmsghdr){CMSG_LEN(sizeof reported.stamp), reported.other.level, reported.other.type};
        (void)memset(CMSG_DATA(part), 1, sizeof reported.stamp);
        message->msg_controllen = CMSG_SPACE(sizeof reported.stamp);
        return answer(mock_type(int));
    }
    if ((reported.stamp.tv_sec != 0) && (part != NULL)) {
        *part = (struct cmsghdr){CMSG_LEN(sizeof reported.stamp), SOL_SOCKET, SO_TIMESTAMPNS};
        (void)memcpy(CMSG_DATA(part), &reported.stamp, sizeof reported.stamp);
        used += CMSG_SPACE(sizeof reported.stamp);
        part = (struct cmsghdr*)(void*)((uint8_t*)message->msg_control + used);
    }
    if (reported.has_overruns && (part != NULL)) {
        *part = (struct cmsghdr){CMSG_LEN(sizeof reported.overruns), SOL_SOCKET, SO_RXQ_OVFL};
        (void)memcpy(CMSG_DATA(part), &reported.overruns, sizeof reported.overruns);
        used += CMSG_SPACE(sizeof reported.overruns);
    }
    message->msg_controllen = used;
    return answer(mock_type(int));
}

int __wrap_poll(struct pollfd* sockets, nfds_t count, int timeout_ms)
{
    assert_int_equal(1, count);
    assert_int_equal(DESCRIPTOR, sockets[0].fd);
    assert_int_equal(POLLIN, sockets[0].events);
    check_expected(timeout_ms);
    return answer(mock_type(int));
}

int __wrap_clock_gettime(clockid_t clock, struct timespec* out_time)
{
    *out_time = (clock == CLOCK_REALTIME) ? (struct timespec){WALL_S, 0} : (struct timespec){NOW_S, 0};
    return 0;
}

static int set_up(void** state)
{
    (void)state;
    can                   = (osal_can_t){.descriptor = DESCRIPTOR};
    raw                   = (struct canfd_frame){0};
    reported.stamp        = (struct timespec){0, 0};
    reported.has_overruns = false;
    reported.other.level  = 0;
    interface.family      = ARPHRD_CAN;
    interface.flags       = IFF_UP;
    interface.mtu         = CANFD_MTU;
    return 0;
}

// ---- Opening ----

static const unsigned long questions[] = {SIOCGIFINDEX, SIOCGIFHWADDR, SIOCGIFFLAGS, SIOCGIFMTU};
static const int options[]             = {CAN_RAW_FD_FRAMES, CAN_RAW_ERR_FILTER, SO_TIMESTAMPNS, SO_RXQ_OVFL,
                                          SO_RCVBUFFORCE};
#define QUESTIONS 4U
#define OPTIONS 5U
#define STEPS (QUESTIONS + OPTIONS + 1U)

/// Expect the calls of an opening; call number `failing` (0: none) ends it with that error.
static void expect_opening(const unsigned failing, const int error)
{
    will_return(__wrap_socket, DESCRIPTOR);
    for (unsigned step = 1U; (step <= STEPS) && ((failing == 0U) || (step <= failing)); step++) {
        const int result = (step == failing) ? -error : 0;
        if (step <= QUESTIONS) {
            expect_value(__wrap_ioctl, request, questions[step - 1U]);
            will_return(__wrap_ioctl, result);
        } else if (step <= (QUESTIONS + OPTIONS)) {
            expect_value(__wrap_setsockopt, option, options[step - QUESTIONS - 1U]);
            will_return(__wrap_setsockopt, result);
        } else {
            will_return(__wrap_bind, result);
        }
    }
}

static void opening_queries_the_interface_sets_the_options_and_binds(void** state)
{
    (void)state;
    can.descriptor = -1;
    expect_opening(0U, 0);
    assert_int_equal(STATUS_OK, can_socket_open(&can, "can7"));
    assert_int_equal(DESCRIPTOR, can.descriptor);
    assert_true(can.carries_fd);
    interface.mtu = CAN_MTU;
    expect_opening(0U, 0);
    assert_int_equal(STATUS_OK, can_socket_open(&can, "can7"));
    assert_false(can.carries_fd);
    expect_function_call(__wrap_close);
    can_socket_close(&can);
}

static void a_socket_that_does_not_open_is_reported_and_closed(void** state)
{
    static const struct {
        int error;
        status_t status;
    } errors[] = {{EAFNOSUPPORT, STATUS_UNSUPPORTED},
                  {EPROTONOSUPPORT, STATUS_UNSUPPORTED},
                  {ESOCKTNOSUPPORT, STATUS_UNSUPPORTED},
                  {ENODEV, STATUS_NOT_FOUND},
                  {ENXIO, STATUS_NOT_FOUND},
                  {ENETDOWN, STATUS_CLOSED},
                  {EPERM, STATUS_DENIED},
                  {EACCES, STATUS_DENIED},
                  {EMFILE, STATUS_IO}};
    (void)state;
    can.descriptor = -1;
    for (unsigned i = 0U; i < (sizeof errors / sizeof errors[0]); i++) {
        will_return(__wrap_socket, -errors[i].error);
        assert_int_equal(errors[i].status, can_socket_open(&can, "can7"));
        for (unsigned step = 1U; step <= STEPS; step++) {
            const bool is_option = (step > QUESTIONS) && (step < STEPS);
            expect_opening(step, errors[i].error);
            if (step == (QUESTIONS + OPTIONS)) {
                // If SO_RCVBUFFORCE is refused, the port sets SO_RCVBUF, which fails here, too.
                expect_value(__wrap_setsockopt, option, SO_RCVBUF);
                will_return(__wrap_setsockopt, -errors[i].error);
            }
            expect_function_call(__wrap_close);
            assert_int_equal(is_option ? STATUS_IO : errors[i].status, can_socket_open(&can, "can7"));
            assert_int_equal(-1, can.descriptor);
        }
    }
}

static void a_smaller_queue_is_used_if_the_wanted_one_is_refused(void** state)
{
    (void)state;
    expect_opening(QUESTIONS + OPTIONS, EPERM);
    expect_value(__wrap_setsockopt, option, SO_RCVBUF);
    will_return(__wrap_setsockopt, 0);
    will_return(__wrap_bind, 0);
    assert_int_equal(STATUS_OK, can_socket_open(&can, "can7"));
}

static void an_interface_that_is_down_or_no_can_interface_is_reported(void** state)
{
    (void)state;
    interface.family = ARPHRD_ETHER;
    expect_opening(2U, 0);
    expect_function_call(__wrap_close);
    assert_int_equal(STATUS_UNSUPPORTED, can_socket_open(&can, "can7"));
    interface.family = ARPHRD_CAN;
    interface.flags  = (short)~IFF_UP;
    expect_opening(3U, 0);
    expect_function_call(__wrap_close);
    assert_int_equal(STATUS_CLOSED, can_socket_open(&can, "can7"));
}

// ---- Filters ----

static void filters_with_the_kernel_s_own_bit_are_left_out(void** state)
{
    (void)state;
    can.filters[0]   = (osal_can_filter_t){.id = 0x181U, .mask = 0x7FFU | OSAL_CAN_ERROR};
    can.filters[1]   = (osal_can_filter_t){.id = 0x181U | OSAL_CAN_ERROR, .mask = 0x7FFU | OSAL_CAN_ERROR};
    can.filters[2]   = (osal_can_filter_t){.id = 0x701U, .mask = 0x700U};
    can.filter_count = 3U;
    expect_value(__wrap_setsockopt, option, CAN_RAW_FILTER);
    expect_value(__wrap_setsockopt, size, 2U * sizeof(struct can_filter));
    will_return(__wrap_setsockopt, 0);
    assert_int_equal(STATUS_OK, can_socket_filter(&can));
    assert_int_equal(0x181U, filters[0].can_id);
    assert_int_equal(0x7FFU, filters[0].can_mask);
    assert_int_equal(0x700U, filters[1].can_id);
    assert_int_equal(0x700U, filters[1].can_mask);
    can.filter_count = 0U; // No frame passes.
    expect_value(__wrap_setsockopt, option, CAN_RAW_FILTER);
    expect_value(__wrap_setsockopt, size, 0U);
    will_return(__wrap_setsockopt, -ENODEV);
    assert_int_equal(STATUS_IO, can_socket_filter(&can));
}

// ---- Frames ----

static void frames_are_sent_with_the_size_of_their_kind(void** state)
{
    const osal_can_frame_t classic = {
        .id = 0x201U, .length = 3U, .flags = OSAL_CAN_FLAG_BRS, .data = {1U, 2U, 3U}};
    const osal_can_frame_t fast = {
        .id = 0x202U, .length = 64U, .flags = OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS, .data = {[63] = 9U}};
    (void)state;
    expect_value(__wrap_send, size, CAN_MTU);
    expect_value(__wrap_send, size, CAN_MTU);
    will_return(__wrap_send, -EINTR);
    will_return(__wrap_send, CAN_MTU);
    assert_int_equal(STATUS_OK, can_socket_send(&can, &classic));
    assert_int_equal(0x201U, raw.can_id);
    assert_int_equal(3U, raw.len);
    assert_int_equal(0U, raw.flags); // A classic frame has no flags.
    assert_int_equal(3U, raw.data[2]);
    expect_value(__wrap_send, size, CANFD_MTU);
    will_return(__wrap_send, CANFD_MTU);
    assert_int_equal(STATUS_OK, can_socket_send(&can, &fast));
    assert_int_equal(CANFD_BRS, raw.flags);
    assert_int_equal(64U, raw.len);
    assert_int_equal(9U, raw.data[63]);
}

static void the_reason_why_a_frame_is_not_sent_is_reported(void** state)
{
    static const struct {
        int error;
        status_t status;
        unsigned refused;
    } errors[]                   = {{EAGAIN, STATUS_FULL, 1U},
                                    {ENOBUFS, STATUS_FULL, 2U},
                                    {EINVAL, STATUS_INVALID, 2U},
                                    {ENETDOWN, STATUS_CLOSED, 2U},
                                    {ENODEV, STATUS_CLOSED, 2U}};
    const osal_can_frame_t frame = {.id = 0x201U, .length = 8U};
    (void)state;
    for (unsigned i = 0U; i < (sizeof errors / sizeof errors[0]); i++) {
        expect_value(__wrap_send, size, CAN_MTU);
        will_return(__wrap_send, -errors[i].error);
        assert_int_equal(errors[i].status, can_socket_send(&can, &frame));
        assert_int_equal(errors[i].refused, can.refused);
    }
}

static void a_frame_is_received_with_its_time(void** state)
{
    static const struct {
        struct timespec stamp;
        uint64_t time_ns;
    } times[] = {
        {{WALL_S - 1, 250}, NOW_NS - 1000000000U + 250U}, // The frame has waited for a second.
        {{WALL_S, 0}, NOW_NS},
        {{WALL_S + 1000, 0}, NOW_NS}, // The wall clock was set back after the frame had arrived.
        {{1, 0}, NOW_NS},             // Longer ago than this machine has been running.
        {{0, 0}, NOW_NS},             // No time stamp.
    };
    osal_can_frame_t frame;
    (void)state;
    raw = (struct canfd_frame){.can_id = 0x181U, .len = 8U, .flags = CANFD_BRS, .data = {[7] = 3U, [8] = 4U}};
    will_return(__wrap_recvmsg, -EINTR);
    for (unsigned i = 0U; i < (sizeof times / sizeof times[0]); i++) {
        reported.stamp = times[i].stamp;
        will_return(__wrap_recvmsg, CAN_MTU);
        assert_int_equal(STATUS_OK, can_socket_receive(&can, &frame));
        assert_int_equal(times[i].time_ns, frame.time_ns);
        assert_int_equal(0x181U, frame.id);
        assert_int_equal(8U, frame.length);
        assert_int_equal(0U, frame.flags);
        assert_int_equal(3U, frame.data[7]);
        assert_int_equal(0U, frame.data[8]); // The data of a classic frame ends there.
        assert_int_equal(0U, can.overruns);
    }
    reported.has_overruns = true;
    reported.overruns     = 17U;
    will_return(__wrap_recvmsg, CANFD_MTU);
    assert_int_equal(STATUS_OK, can_socket_receive(&can, &frame));
    assert_int_equal(OSAL_CAN_FLAG_FD | OSAL_CAN_FLAG_BRS, frame.flags);
    assert_int_equal(4U, frame.data[8]);
    assert_int_equal(17U, can.overruns);
}

/// Level and type together define control data; neither suffices alone.
static void control_data_of_another_kind_is_ignored(void** state)
{
    static const struct {
        int level;
        int type;
    } others[] = {{SOL_SOCKET, SO_TIMESTAMP}, {SOL_CAN_RAW, SO_TIMESTAMPNS}, {SOL_CAN_RAW, SO_RXQ_OVFL}};
    osal_can_frame_t frame;
    (void)state;
    for (unsigned i = 0U; i < (sizeof others / sizeof others[0]); i++) {
        reported.other.level = others[i].level;
        reported.other.type  = others[i].type;
        will_return(__wrap_recvmsg, CAN_MTU);
        assert_int_equal(STATUS_OK, can_socket_receive(&can, &frame));
        assert_int_equal(NOW_NS, frame.time_ns);
        assert_int_equal(0U, can.overruns);
        assert_int_equal(0U, can.kernel_overruns);
    }
}

static void the_reason_why_no_frame_is_received_is_reported(void** state)
{
    osal_can_frame_t frame;
    (void)state;
    will_return(__wrap_recvmsg, -EAGAIN);
    assert_int_equal(STATUS_EMPTY, can_socket_receive(&can, &frame));
    will_return(__wrap_recvmsg, -ENETDOWN);
    assert_int_equal(STATUS_CLOSED, can_socket_receive(&can, &frame));
    static const int sizes[] = {0, 1, CAN_MTU - 1, CAN_MTU + 1, CANFD_MTU - 1};
    for (unsigned i = 0U; i < (sizeof sizes / sizeof sizes[0]); i++) { // The interface is gone.
        will_return(__wrap_recvmsg, sizes[i]);
        assert_int_equal(STATUS_CLOSED, can_socket_receive(&can, &frame));
    }
}

static void a_wait_ends_with_a_frame_a_signal_or_the_time(void** state)
{
    static const struct {
        int result;
        bool has_come;
    } ends[] = {{1, true}, {0, false}, {-EINTR, true}, {-ENOMEM, false}};
    (void)state;
    assert_false(can_socket_wait(&can, NOW_NS)); // The time is over, so the port does not call the kernel.
    for (unsigned i = 0U; i < 4U; i++) {
        expect_value(__wrap_poll, timeout_ms, 3); // Rounded up to a whole millisecond.
        will_return(__wrap_poll, ends[i].result);
        assert_int_equal(ends[i].has_come, can_socket_wait(&can, NOW_NS + 2999999U));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(opening_queries_the_interface_sets_the_options_and_binds, set_up),
        cmocka_unit_test_setup(a_socket_that_does_not_open_is_reported_and_closed, set_up),
        cmocka_unit_test_setup(a_smaller_queue_is_used_if_the_wanted_one_is_refused, set_up),
        cmocka_unit_test_setup(an_interface_that_is_down_or_no_can_interface_is_reported, set_up),
        cmocka_unit_test_setup(filters_with_the_kernel_s_own_bit_are_left_out, set_up),
        cmocka_unit_test_setup(frames_are_sent_with_the_size_of_their_kind, set_up),
        cmocka_unit_test_setup(the_reason_why_a_frame_is_not_sent_is_reported, set_up),
        cmocka_unit_test_setup(a_frame_is_received_with_its_time, set_up),
        cmocka_unit_test_setup(control_data_of_another_kind_is_ignored, set_up),
        cmocka_unit_test_setup(the_reason_why_no_frame_is_received_is_reported, set_up),
        cmocka_unit_test_setup(a_wait_ends_with_a_frame_a_signal_or_the_time, set_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
