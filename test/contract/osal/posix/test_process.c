// SPDX-License-Identifier: Apache-2.0
// The children are this program itself, called with the name of their role.
#define _GNU_SOURCE
#include "osal/include/osal/process.h"

#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>
#include "unity.h"

#define SELF "/proc/self/exe"
#define LONG_MS 60000U

static char path[64];

void setUp(void)
{
    (void)snprintf(path, sizeof path, "/tmp/osal-process-test-%d", (int)getpid());
}

void tearDown(void)
{
    (void)unlink(path);
}

// ---- Roles of a child ----

static int hold_on(void)
{
    return pause(); // Until a signal ends it.
}

/// Exit code in which bit i is set if descriptor 3 + i is open.
static int show_descriptors(void)
{
    int code = 0;
    for (int i = 0; i < 6; i++) {
        code |= (fcntl(3 + i, F_GETFD) >= 0) ? (1 << i) : 0;
    }
    return code;
}

static int show_memory_limit(const char* expected)
{
    struct rlimit limit;
    return ((getrlimit(RLIMIT_AS, &limit) == 0) && (limit.rlim_cur == strtoull(expected, NULL, 10))) ? 0 : 1;
}

/// Exit code 0 if descriptors up to this number are available, and no higher ones.
static int show_descriptor_limit(int limit)
{
    int last = 0;
    int next = 0;
    while (next >= 0) {
        last = next;
        next = open("/dev/null", O_RDONLY | O_CLOEXEC);
    }
    for (int i = 3; i <= last; i++) {
        (void)close(i); // The leak sanitizer needs a free descriptor at the end.
    }
    return (last == (limit - 1)) ? 0 : 1;
}

/// Use this number of MiB of memory.
static int take_memory(size_t mebibytes)
{
    uint8_t* const octets = malloc(mebibytes << 20U);
    if (octets == NULL) {
        return 1;
    }
    (void)memset(octets, 1, mebibytes << 20U);
    const int code = (*(volatile uint8_t*)&octets[mebibytes] == 1U) ? 0 : 1;
    free(octets);
    return code;
}

#define NAMED_PROCESSORS 100 // An exit code below this is the number of a processor.

static int show_processor(void)
{
    cpu_set_t set;
    if ((sched_getaffinity(0, sizeof set, &set) != 0) || (CPU_COUNT(&set) != 1)) {
        return 100;
    }
    for (int i = 0; i < NAMED_PROCESSORS; i++) {
        if (CPU_ISSET((unsigned)i, &set)) {
            return i;
        }
    }
    return 101;
}

/// Exit code 0 if the signals have the states that a program expects.
static int show_signals(void)
{
    sigset_t blocked;
    struct sigaction action;
    if ((sigprocmask(SIG_SETMASK, NULL, &blocked) != 0) || (sigismember(&blocked, SIGTERM) != 0)) {
        return 1;
    }
    return ((sigaction(SIGPIPE, NULL, &action) == 0) && (action.sa_handler == SIG_DFL)) ? 0 : 2;
}

/// A parent that starts a child, reports its id, and then waits to be killed.
static int be_parent(int report, bool outlives)
{
    const char* const arguments[]    = {SELF, "hold", NULL};
    const osal_process_start_t start = {
        .arguments = arguments, .processor = -1, .outlives = outlives, .has_own_group = !outlives};
    osal_process_t child;
    if ((osal_process_start(&child, &start) != STATUS_OK) ||
        (write(report, &child.id, sizeof child.id) != (ssize_t)sizeof child.id)) {
        return 1;
    }
    return hold_on();
}

/// Exit code: the number of stop signals, plus 50, or plus 90 if a second wait returned at once, too.
static int catch_stop(void)
{
    osal_process_catch_stop();
    (void)puts("ready");
    (void)fflush(stdout);
    do {
        (void)osal_process_wait_any(NULL, 0U, LONG_MS);
    } while (osal_process_stop_count() == 0U);
    // A stop signal ends only one wait.
    const bool is_taken = (osal_process_wait_any(NULL, 0U, 10U) == STATUS_TIMEOUT);
    return (is_taken ? 50 : 90) + (int)osal_process_stop_count();
}

static int ignore_interrupt(void)
{
    osal_process_ignore_interrupt();
    (void)puts("ready");
    (void)fflush(stdout);
    (void)raise(SIGINT);
    (void)raise(SIGHUP);
    (void)raise(SIGPIPE);
    return 7;
}

/// A program that handles no signals itself, such as an interpreter.
static int hang_up(void)
{
    (void)raise(SIGINT);
    (void)raise(SIGHUP);
    return 7;
}

static int play(const char* role, const char* argument)
{
    if (strcmp(role, "exit") == 0) {
        return atoi(argument);
    }
    if (strcmp(role, "hang_up") == 0) {
        return hang_up();
    }
    if (strcmp(role, "hold") == 0) {
        return hold_on();
    }
    if (strcmp(role, "descriptors") == 0) {
        return show_descriptors();
    }
    if (strcmp(role, "memory") == 0) {
        return show_memory_limit(argument);
    }
    if (strcmp(role, "limited") == 0) {
        return show_descriptor_limit(atoi(argument));
    }
    if (strcmp(role, "large") == 0) {
        return take_memory((size_t)atoi(argument));
    }
    if (strcmp(role, "processor") == 0) {
        return show_processor();
    }
    if (strcmp(role, "signals") == 0) {
        return show_signals();
    }
    if (strcmp(role, "parent") == 0) {
        return be_parent(atoi(argument), false);
    }
    if (strcmp(role, "predecessor") == 0) {
        return be_parent(atoi(argument), true);
    }
    if (strcmp(role, "speak") == 0) {
        return ((write(1, "out\n", 4U) == 4) && (write(2, "err\n", 4U) == 4)) ? 0 : 1;
    }
    return (strcmp(role, "catch") == 0) ? catch_stop() : ignore_interrupt();
}

// ---- The tests ----

static osal_process_t start_role(const char* role, const char* argument, const osal_process_start_t* like)
{
    const char* const arguments[] = {SELF, role, argument, NULL};
    osal_process_start_t start    = *like;
    osal_process_t process;
    start.arguments = arguments;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_start(&process, &start));
    TEST_ASSERT_TRUE(process.id > 0);
    return process;
}

static osal_process_result_t result_of(osal_process_t* process)
{
    osal_process_t* const one[]  = {process};
    osal_process_result_t result = {.has_ended = false};
    while (!result.has_ended) {
        TEST_ASSERT_EQUAL(STATUS_OK, osal_process_wait_any(one, 1U, LONG_MS));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_process_poll(process, &result));
    }
    return result;
}

static const osal_process_start_t plain = {.processor = -1};

static void exit_code_is_reported_once(void)
{
    osal_process_t process       = start_role("exit", "42", &plain);
    osal_process_result_t result = result_of(&process);
    TEST_ASSERT_FALSE(result.was_signalled);
    TEST_ASSERT_EQUAL(42, result.code);
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, osal_process_poll(&process, &result));
    TEST_ASSERT_FALSE(result.has_ended);
    TEST_ASSERT_FALSE(osal_process_is_alive(&process));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_process_stop(&process, true));
}

static void a_running_child_ends_by_sigterm_or_sigkill(void)
{
    for (int by_force = 0; by_force <= 1; by_force++) {
        osal_process_t process      = start_role("hold", NULL, &plain);
        osal_process_t* const one[] = {&process};
        osal_process_result_t result;
        TEST_ASSERT_TRUE(osal_process_is_alive(&process));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_process_poll(&process, &result));
        TEST_ASSERT_FALSE(result.has_ended);
        TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_process_wait_any(one, 1U, 10U));
        TEST_ASSERT_EQUAL(STATUS_OK, osal_process_stop(&process, by_force != 0));
        result = result_of(&process);
        TEST_ASSERT_TRUE(result.was_signalled);
        TEST_ASSERT_EQUAL((by_force != 0) ? SIGKILL : SIGTERM, result.code);
    }
}

static void signals_of_the_terminal_are_ignored_from_the_start(void)
{
    const osal_process_start_t start = {.ignores_terminal = true, .processor = -1};
    osal_process_t process           = start_role("hang_up", NULL, &start);
    TEST_ASSERT_EQUAL(7, result_of(&process).code);
    process                            = start_role("hang_up", NULL, &plain);
    const osal_process_result_t result = result_of(&process);
    TEST_ASSERT_TRUE(result.was_signalled);
    TEST_ASSERT_EQUAL(SIGINT, result.code);
}

static void a_program_that_cannot_be_started_is_reported(void)
{
    const char* const missing[]   = {"/no/such/program", NULL};
    const char* const directory[] = {"/tmp", NULL};
    osal_process_start_t start    = plain;
    osal_process_t process;
    osal_process_result_t result;
    start.arguments = missing;
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_process_start(&process, &start));
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, osal_process_poll(&process, &result));
    TEST_ASSERT_FALSE(osal_process_is_alive(&process));
    start.arguments = directory;
    TEST_ASSERT_EQUAL(STATUS_DENIED, osal_process_start(&process, &start));
    const int bad[]          = {777};
    const char* const good[] = {SELF, "exit", "0", NULL};
    start.arguments          = good;
    start.descriptors        = bad;
    start.descriptor_count   = 1U;
    TEST_ASSERT_EQUAL(STATUS_IO, osal_process_start(&process, &start));
    start.descriptor_count = 0U;
    start.output_path      = "/no/such/directory/output";
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_process_start(&process, &start));
    TEST_ASSERT_EQUAL(-1, waitpid(-1, NULL, WNOHANG)); // No partly started process is left.
}

static void a_child_keeps_only_the_named_descriptors(void)
{
    // Whatever descriptors the test was started with, 3..8 are open here, some without close-on-exec.
    for (int i = 3; i <= 8; i++) {
        TEST_ASSERT_EQUAL(i, dup2(2, i));
    }
    const int kept[]                 = {7, 4};
    const osal_process_start_t start = {.descriptors = kept, .descriptor_count = 2U, .processor = -1};
    osal_process_t process           = start_role("descriptors", NULL, &start);
    TEST_ASSERT_EQUAL((1 << (7 - 3)) | (1 << (4 - 3)), result_of(&process).code);
    process = start_role("descriptors", NULL, &plain);
    TEST_ASSERT_EQUAL(0, result_of(&process).code);
    for (int i = 3; i <= 8; i++) {
        (void)close(i);
    }
}

static void memory_limit_holds_for_the_child_only(void)
{
#if defined(__SANITIZE_ADDRESS__)
    TEST_IGNORE_MESSAGE("the address sanitizer maps terabytes: nothing is limited");
#endif
    const char* const octets         = "500000000";
    const osal_process_start_t start = {.memory_limit_octets = strtoull(octets, NULL, 10), .processor = -1};
    osal_process_t process           = start_role("memory", octets, &start);
    TEST_ASSERT_EQUAL(0, result_of(&process).code);
    struct rlimit limit;
    TEST_ASSERT_EQUAL(0, getrlimit(RLIMIT_AS, &limit));
    TEST_ASSERT_TRUE(limit.rlim_cur > start.memory_limit_octets);
}

static void only_a_child_that_was_started_with_a_descriptor_limit_has_it(void)
{
    const osal_process_start_t start = {.descriptor_limit = 40U, .processor = -1};
    osal_process_t process           = start_role("limited", "40", &start);
    TEST_ASSERT_EQUAL(0, result_of(&process).code);
    process = start_role("limited", "40", &plain);
    TEST_ASSERT_EQUAL(1, result_of(&process).code);
}

static void end_reports_the_memory_that_was_needed(void)
{
    osal_process_t process = start_role("exit", "0", &plain);
    const uint64_t least   = result_of(&process).memory_high_kib;
    process                = start_role("large", "64", &plain);
    const uint64_t more    = result_of(&process).memory_high_kib;
    TEST_ASSERT_TRUE(least > 0U);
    TEST_ASSERT_TRUE(more >= (64U * 1024U));
    TEST_ASSERT_TRUE(more > least);
}

static volatile uint8_t large[3U << 20U]; // Static zeros: they need memory, but no room in the file.

static void the_size_of_a_program_is_that_of_its_loaded_segments(void)
{
    char name[]     = "/tmp/loaded_size.XXXXXX";
    uint64_t octets = 0U;
    large[0]        = 1U;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_loaded_size(SELF, &octets));
    TEST_ASSERT_TRUE((octets > sizeof large) && (octets < (64U << 20U)));
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_process_loaded_size("/nowhere/none", &octets));
    TEST_ASSERT_EQUAL_UINT64(0U, octets);
    const int file = mkstemp(name);
    TEST_ASSERT_TRUE(file >= 0);
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_process_loaded_size(name, &octets)); // The file is empty.
    char words[100] = "#!/bin/sh\n";
    TEST_ASSERT_EQUAL_INT(sizeof words, write(file, words, sizeof words));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_process_loaded_size(name, &octets));
    // The file has only the first octets: a header without the parts to which it refers.
    const int self = open(SELF, O_RDONLY | O_CLOEXEC);
    TEST_ASSERT_EQUAL_INT(sizeof words, read(self, words, sizeof words));
    TEST_ASSERT_EQUAL_INT(sizeof words, pwrite(file, words, sizeof words, 0));
    TEST_ASSERT_EQUAL(STATUS_INVALID, osal_process_loaded_size(name, &octets));
    (void)close(self);
    (void)close(file);
    (void)unlink(name);
}

/// The number wraps at the number of permitted processors, which may be fewer than the machine has.
static void a_child_is_pinned_to_one_of_the_permitted_processors(void)
{
    cpu_set_t set;
    TEST_ASSERT_EQUAL(0, sched_getaffinity(0, sizeof set, &set));
    const int count = CPU_COUNT(&set);
    int number      = 0;
    for (unsigned i = 0U; i < (unsigned)NAMED_PROCESSORS; i++) {
        if (CPU_ISSET(i, &set)) {
            for (int round = 0; round < 2; round++) {
                osal_process_start_t start = plain;
                start.processor            = number + (round * count);
                osal_process_t process     = start_role("processor", NULL, &start);
                TEST_ASSERT_EQUAL(i, result_of(&process).code);
            }
            number++;
        }
    }
    TEST_ASSERT_TRUE(number > 0);
}

static void output_goes_to_the_file_and_is_appended(void)
{
    char text[64]              = "";
    osal_process_start_t start = plain;
    start.output_path          = path;
    for (int i = 0; i < 2; i++) {
        osal_process_t process = start_role("speak", NULL, &start);
        TEST_ASSERT_EQUAL(0, result_of(&process).code);
    }
    const int file = open(path, O_RDONLY);
    TEST_ASSERT_EQUAL(16, read(file, text, sizeof text));
    (void)close(file);
    TEST_ASSERT_EQUAL_STRING("out\nerr\nout\nerr\n", text);
}

static void a_child_begins_with_the_default_actions_of_signals(void)
{
    sigset_t all;
    sigset_t kept;
    TEST_ASSERT_EQUAL(0, sigfillset(&all));
    TEST_ASSERT_EQUAL(0, sigprocmask(SIG_BLOCK, &all, &kept));
    (void)signal(SIGPIPE, SIG_IGN);
    osal_process_t process = start_role("signals", NULL, &plain);
    (void)signal(SIGPIPE, SIG_DFL);
    TEST_ASSERT_EQUAL(0, sigprocmask(SIG_SETMASK, &kept, NULL));
    TEST_ASSERT_EQUAL(0, result_of(&process).code);
}

/// Start a child that is itself a parent, and watch the process that it has started.
static osal_process_t start_parent(const char* role, osal_process_t* out_grandchild)
{
    int report[2];
    int32_t grandchild_id = 0;
    char number[16];
    TEST_ASSERT_EQUAL(0, pipe(report));
    (void)snprintf(number, sizeof number, "%d", report[1]);
    const int kept[]                 = {report[1]};
    const osal_process_start_t start = {.descriptors = kept, .descriptor_count = 1U, .processor = -1};
    const osal_process_t parent      = start_role(role, number, &start);
    TEST_ASSERT_EQUAL((ssize_t)sizeof grandchild_id, read(report[0], &grandchild_id, sizeof grandchild_id));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_watch(out_grandchild, grandchild_id));
    (void)close(report[0]);
    (void)close(report[1]);
    return parent;
}

static void child_dies_with_its_parent(void)
{
    osal_process_t grandchild;
    osal_process_t* const one[] = {&grandchild};
    osal_process_result_t result;
    osal_process_t parent = start_parent("parent", &grandchild);
    TEST_ASSERT_TRUE(osal_process_is_alive(&grandchild));
    TEST_ASSERT_EQUAL(grandchild.id, getpgid(grandchild.id)); // A signal to another group does not end it.
    // The process is not a child of this program.
    TEST_ASSERT_EQUAL(STATUS_NOT_OURS, osal_process_poll(&grandchild, &result));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_process_wait_any(one, 1U, 10U));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_stop(&parent, true));
    (void)result_of(&parent);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_wait_any(one, 1U, LONG_MS));
    TEST_ASSERT_FALSE(osal_process_is_alive(&grandchild));
    osal_process_release(&grandchild);
    osal_process_release(&grandchild);
    TEST_ASSERT_FALSE(osal_process_is_alive(&grandchild));
}

static void a_child_that_outlives_its_parent_survives_the_end_of_its_group(void)
{
    osal_process_t grandchild;
    osal_process_t* const one[] = {&grandchild};
    osal_process_t parent       = start_parent("predecessor", &grandchild);
    TEST_ASSERT_TRUE(getsid(grandchild.id) != getsid(0));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_stop(&parent, true));
    (void)result_of(&parent);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_process_wait_any(one, 1U, 50U));
    TEST_ASSERT_TRUE(osal_process_is_alive(&grandchild));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_stop(&grandchild, true));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_wait_any(one, 1U, LONG_MS));
    osal_process_release(&grandchild);
}

static void watch_needs_a_process(void)
{
    static const int32_t none[] = {0, -5, INT32_MAX};
    osal_process_t process;
    for (size_t i = 0U; i < (sizeof none / sizeof none[0]); i++) {
        (void)memset(&process, 1, sizeof process);
        errno = ENOSYS; // Of an earlier call: it says nothing about this id.
        TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, osal_process_watch(&process, none[i]));
        TEST_ASSERT_EQUAL_INT32(0, process.id); // Otherwise a later call could end another process.
        TEST_ASSERT_EQUAL_INT(-1, process.descriptor);
        TEST_ASSERT_FALSE(osal_process_is_alive(&process));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_watch(&process, osal_process_own_id()));
    TEST_ASSERT_TRUE(osal_process_is_alive(&process));
    osal_process_release(&process);
    TEST_ASSERT_EQUAL_INT(-1, process.descriptor);
}

static void wait_any_finds_the_process_that_ended(void)
{
    osal_process_t holding       = start_role("hold", NULL, &plain);
    osal_process_t ending        = start_role("exit", "5", &plain);
    osal_process_t* const both[] = {&holding, &ending};
    osal_process_result_t result;
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_wait_any(both, 2U, LONG_MS));
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_poll(&holding, &result));
    TEST_ASSERT_FALSE(result.has_ended);
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_poll(&ending, &result));
    TEST_ASSERT_TRUE(result.has_ended);
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT,
                      osal_process_wait_any(both, 2U, 10U)); // The end of a process is not reported again.
    TEST_ASSERT_EQUAL(STATUS_OK, osal_process_stop(&holding, true));
    (void)result_of(&holding);
}

/// Start `role` with its output in the file and wait until it reports that it is ready.
static osal_process_t start_ready(const char* role)
{
    osal_process_start_t start = plain;
    start.output_path          = path;
    osal_process_t process     = start_role(role, NULL, &start);
    for (int tries = 0; tries < 5000; tries++) {
        char text[8]       = "";
        const int file     = open(path, O_RDONLY);
        const ssize_t size = (file >= 0) ? read(file, text, sizeof text - 1U) : 0;
        (void)close(file);
        if (size > 0) {
            break;
        }
        (void)usleep(1000U);
    }
    return process;
}

static void caught_stop_signal_ends_a_wait_and_not_the_program(void)
{
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t i = 0U; i < 3U; i++) {
        osal_process_t process = start_ready("catch");
        TEST_ASSERT_EQUAL(0, kill((pid_t)process.id, signals[i]));
        const osal_process_result_t result = result_of(&process);
        TEST_ASSERT_FALSE(result.was_signalled);
        TEST_ASSERT_EQUAL(50 + 1, result.code); // See catch_stop.
        (void)unlink(path);
    }
}

static void a_child_can_leave_the_interrupt_to_its_parent(void)
{
    osal_process_t process = start_ready("ignore");
    TEST_ASSERT_EQUAL(7, result_of(&process).code);
}

static void ignore_it(int number)
{
    (void)number;
}

static void other_signals_do_not_shorten_a_wait(void)
{
    struct sigaction action         = {.sa_handler = ignore_it};
    const struct itimerval every_ms = {{0, 1000}, {0, 1000}};
    const struct itimerval off      = {{0, 0}, {0, 0}};
    TEST_ASSERT_EQUAL(0, sigaction(SIGALRM, &action, NULL));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &every_ms, NULL));
    TEST_ASSERT_EQUAL(STATUS_TIMEOUT, osal_process_wait_any(NULL, 0U, 30U));
    osal_process_t process = start_role("exit", "0", &plain); // A signal interrupts reading the outcome.
    TEST_ASSERT_EQUAL(0, result_of(&process).code);
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &off, NULL));
}

static void a_child_has_the_environment_that_its_starter_set(void)
{
    TEST_ASSERT_EQUAL(0, setenv("OSAL_TEST_WORD", "a=b", 1));
    TEST_ASSERT_EQUAL(0, setenv("OSAL_TEST_WORDS", "", 1));
    TEST_ASSERT_EQUAL_STRING("a=b", osal_process_environment("OSAL_TEST_WORD"));
    TEST_ASSERT_EQUAL_STRING("", osal_process_environment("OSAL_TEST_WORDS"));
    TEST_ASSERT_NULL(osal_process_environment("OSAL_TEST"));
    TEST_ASSERT_EQUAL(0, unsetenv("OSAL_TEST_WORD"));
    TEST_ASSERT_NULL(osal_process_environment("OSAL_TEST_WORD"));
}

int main(int count, char** arguments)
{
    if (count > 1) {
        return play(arguments[1], (count > 2) ? arguments[2] : "");
    }
    UNITY_BEGIN();
    RUN_TEST(exit_code_is_reported_once);
    RUN_TEST(a_running_child_ends_by_sigterm_or_sigkill);
    RUN_TEST(signals_of_the_terminal_are_ignored_from_the_start);
    RUN_TEST(a_program_that_cannot_be_started_is_reported);
    RUN_TEST(a_child_keeps_only_the_named_descriptors);
    RUN_TEST(memory_limit_holds_for_the_child_only);
    RUN_TEST(only_a_child_that_was_started_with_a_descriptor_limit_has_it);
    RUN_TEST(end_reports_the_memory_that_was_needed);
    RUN_TEST(the_size_of_a_program_is_that_of_its_loaded_segments);
    RUN_TEST(a_child_is_pinned_to_one_of_the_permitted_processors);
    RUN_TEST(output_goes_to_the_file_and_is_appended);
    RUN_TEST(a_child_begins_with_the_default_actions_of_signals);
    RUN_TEST(child_dies_with_its_parent);
    RUN_TEST(a_child_that_outlives_its_parent_survives_the_end_of_its_group);
    RUN_TEST(watch_needs_a_process);
    RUN_TEST(wait_any_finds_the_process_that_ended);
    RUN_TEST(caught_stop_signal_ends_a_wait_and_not_the_program);
    RUN_TEST(a_child_can_leave_the_interrupt_to_its_parent);
    RUN_TEST(other_signals_do_not_shorten_a_wait);
    RUN_TEST(a_child_has_the_environment_that_its_starter_set);
    return UNITY_END();
}
