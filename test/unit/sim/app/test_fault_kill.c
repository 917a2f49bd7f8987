// SPDX-License-Identifier: Apache-2.0
// A process kills another child of its parent, or its parent, by name, and no other process.
#include "sim/app/fault_kill.h"
#include "unity.h"

#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

static int pipe_of_victims[2]; ///< Victims wait for octets in this pipe.

void setUp(void)
{
    TEST_ASSERT_EQUAL_INT(0, pipe(pipe_of_victims));
}

void tearDown(void)
{
    (void)close(pipe_of_victims[0]);
    (void)close(pipe_of_victims[1]);
}

/// Start a child that waits without end, with this name and a second word in its command line. Both are in
/// place on return.
static pid_t start(const char* name, const char* word)
{
    int begun[2];
    char octet = 0;
    TEST_ASSERT_EQUAL_INT(0, pipe(begun));
    TEST_ASSERT_EQUAL_INT(0, fcntl(begun[1], F_SETFD, FD_CLOEXEC));
    const pid_t id = fork();
    if (id == 0) {
        (void)dup2(pipe_of_victims[0], STDIN_FILENO);
        (void)execl("/bin/cat", name, "-", word, (char*)NULL);
        _exit(127);
    }
    (void)close(begun[1]);
    TEST_ASSERT_EQUAL_INT(0, (int)read(begun[0], &octet, 1U)); // The exec has closed its end.
    (void)close(begun[0]);
    return id;
}

/// Another child of this process kills `name`.
static void kill_by_sibling(const char* name)
{
    int exit_status = 0;
    const pid_t id  = fork();
    if (id == 0) {
        fault_kill(name);
        _exit(0);
    }
    TEST_ASSERT_EQUAL_INT(id, waitpid(id, &exit_status, 0));
    TEST_ASSERT_TRUE(WIFEXITED(exit_status));
}

static bool is_alive(pid_t id)
{
    return waitpid(id, NULL, WNOHANG) == 0;
}

static void expect_killed(pid_t id)
{
    int exit_status = 0;
    TEST_ASSERT_EQUAL_INT(id, waitpid(id, &exit_status, 0));
    TEST_ASSERT_TRUE(WIFSIGNALED(exit_status));
    TEST_ASSERT_EQUAL_INT(SIGKILL, WTERMSIG(exit_status));
}

static void a_sibling_is_found_by_its_program(void)
{
    const pid_t other    = start("/some/where/joystick2", "joystick");
    const pid_t joystick = start("/some/where/joystick", "-");
    kill_by_sibling("joystick");
    expect_killed(joystick);
    TEST_ASSERT_TRUE(is_alive(other));
    kill_by_sibling("joystick2");
    expect_killed(other);
}

static void the_operator_is_an_interpreter_with_a_script(void)
{
    const pid_t other     = start("python", "events");
    const pid_t operator_ = start("python", "script");
    kill_by_sibling("operator");
    expect_killed(operator_);
    TEST_ASSERT_TRUE(is_alive(other));
    kill_by_sibling("python");
    expect_killed(other);
}

static void killing_an_unknown_name_ends_no_process(void)
{
    const pid_t other = start("supervisor", "-");
    kill_by_sibling("manipulator");
    kill_by_sibling("");
    fault_kill("supervisor"); // The supervisor is a child of this process, not a sibling.
    TEST_ASSERT_TRUE(is_alive(other));
    kill_by_sibling("supervisor");
    expect_killed(other);
}

static void the_launcher_is_the_parent(void)
{
    const pid_t launcher = fork();
    if (launcher == 0) {
        if (fork() == 0) {
            fault_kill("launcher");
            _exit(0);
        }
        for (;;) {
            (void)pause();
        }
    }
    expect_killed(launcher);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_sibling_is_found_by_its_program);
    RUN_TEST(the_operator_is_an_interpreter_with_a_script);
    RUN_TEST(killing_an_unknown_name_ends_no_process);
    RUN_TEST(the_launcher_is_the_parent);
    return UNITY_END();
}
