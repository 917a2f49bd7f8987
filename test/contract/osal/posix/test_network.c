// SPDX-License-Identifier: Apache-2.0
// Network namespaces. The test makes the namespace that it enters, and a child process keeps it. If the user
// has no permission for that, the test checks the refusal.
#define _GNU_SOURCE
#include "osal/include/osal/network.h"

#include "osal/include/osal/socket.h"
#include "unity.h"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define OWN "/proc/thread-self/ns/net"

static osal_network_t home;
static pid_t keeper;
static char kept[64];

void setUp(void)
{
    home = (osal_network_t){-1};
}

void tearDown(void)
{
}

static ino_t stack_now(void)
{
    struct stat facts;
    TEST_ASSERT_EQUAL(0, stat(OWN, &facts));
    return facts.st_ino;
}

/// Start a child in a namespace of its own. False if this is not permitted.
static bool make_namespace(void)
{
    int ready[2];
    char word = '\0';
    TEST_ASSERT_EQUAL(0, pipe(ready));
    keeper = fork();
    if (keeper == 0) {
        const char made = (unshare(CLONE_NEWNET) == 0) ? 'y' : 'n';
        if (write(ready[1], &made, 1U) != 1) {
            _exit(1);
        }
        pause();
        _exit(0);
    }
    TEST_ASSERT_EQUAL(1, read(ready[0], &word, 1U));
    (void)close(ready[0]);
    (void)close(ready[1]);
    (void)snprintf(kept, sizeof kept, "/proc/%ld/ns/net", (long)keeper);
    return word == 'y';
}

static void end_keeper(void)
{
    (void)kill(keeper, SIGKILL);
    (void)waitpid(keeper, NULL, 0);
}

static void without_privilege_entering_a_namespace_is_denied(void)
{
    const ino_t before = stack_now();
    TEST_ASSERT_EQUAL(STATUS_DENIED, osal_network_enter(&home, OWN));
    TEST_ASSERT_EQUAL(before, stack_now());
}

static void a_socket_stays_in_the_namespace_in_which_it_was_opened(void)
{
    const ino_t before     = stack_now();
    osal_socket_t here     = OSAL_SOCKET_CLOSED;
    osal_socket_t there    = OSAL_SOCKET_CLOSED;
    osal_address_t address = {OSAL_IPV4_LOOPBACK, 0U};
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&here, address, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_socket_local_address(&here, &address));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_network_enter(&home, kept));
    TEST_ASSERT_TRUE(before != stack_now());
    // The port is free, because it belongs to another network stack.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_udp_open(&there, address, 0U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_network_leave(&home));
    TEST_ASSERT_EQUAL(before, stack_now());
    osal_socket_close(&here);
    osal_socket_close(&there);
}

static void a_path_that_is_no_namespace_is_reported(void)
{
    const ino_t before = stack_now();
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_network_enter(&home, "/nowhere/net"));
    TEST_ASSERT_EQUAL(STATUS_IO, osal_network_enter(&home, "/dev/null"));
    TEST_ASSERT_EQUAL(before, stack_now());
}

/// No descriptor stays open, not even 0, which is the next free one in a program without standard input.
static void an_unsuccessful_entry_closes_what_it_opened(void)
{
    const int input = dup(STDIN_FILENO);
    TEST_ASSERT_TRUE(input > 0);
    (void)close(STDIN_FILENO);
    const status_t status = osal_network_enter(&home, "/nowhere/net");
    const bool is_open    = (fcntl(STDIN_FILENO, F_GETFD) >= 0);
    (void)dup2(input, STDIN_FILENO);
    (void)close(input);
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, status);
    TEST_ASSERT_EQUAL(-1, home.descriptor);
    TEST_ASSERT_FALSE(is_open);
}

static void a_name_is_removed_with_or_without_its_mount(void)
{
    char path[] = "/tmp/hirosco-test-network-XXXXXX";
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_network_remove("/nowhere/net"));
    int file = mkstemp(path);
    TEST_ASSERT_TRUE(file >= 0);
    (void)close(file);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_network_remove(path));
    TEST_ASSERT_TRUE(access(path, F_OK) != 0);
    file = open(path, O_CREAT | O_RDONLY, 0600);
    TEST_ASSERT_TRUE(file >= 0);
    (void)close(file);
    TEST_ASSERT_EQUAL(0, mount(kept, path, "none", MS_BIND, NULL));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_network_enter(&home, path));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_network_leave(&home));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_network_remove(path));
    TEST_ASSERT_TRUE(access(path, F_OK) != 0);
}

int main(void)
{
    UNITY_BEGIN();
    if (!make_namespace()) {
        RUN_TEST(without_privilege_entering_a_namespace_is_denied);
    } else {
        RUN_TEST(a_socket_stays_in_the_namespace_in_which_it_was_opened);
        RUN_TEST(a_path_that_is_no_namespace_is_reported);
        RUN_TEST(an_unsuccessful_entry_closes_what_it_opened);
        RUN_TEST(a_name_is_removed_with_or_without_its_mount);
    }
    end_keeper();
    return UNITY_END();
}
