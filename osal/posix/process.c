// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/process.h"

#include "base/assertion.h"
#include "base/text.h"
#include "osal/include/osal/clock.h"
#include "osal/posix/process_state.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/close_range.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define FIRST_UNNAMED 3U ///< Descriptors 0, 1 and 2 are always inherited.
#define NS_PER_MS 1000000ULL
#define EXIT_NOT_STARTED 127
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LIMITS_MEMORY false // The sanitizers map terabytes, so that any limit of address space would fail.
#else
#define LIMITS_MEMORY true
#endif

// A signal handler has no context pointer: these two are the only mutable globals of this layer.
static volatile sig_atomic_t stop_count;
static volatile sig_atomic_t stop_descriptor = -1;

// ---- In the child, between fork and exec: async-signal-safe calls only ----

static bool limit_to(const unsigned resource, const uint64_t most)
{
    struct rlimit limit = {0, 0};
    if (getrlimit(resource, &limit) != 0) {
        return false;
    }
    if ((limit.rlim_max == RLIM_INFINITY) || (most < limit.rlim_max)) {
        limit.rlim_max = (rlim_t)most;
    }
    limit.rlim_cur = limit.rlim_max;
    return setrlimit(resource, &limit) == 0;
}

static bool limit_resources(const osal_process_start_t* const start)
{
    return ((start->memory_limit_octets == 0U) || !LIMITS_MEMORY ||
            limit_to(RLIMIT_AS, start->memory_limit_octets)) &&
           ((start->descriptor_limit == 0U) || limit_to(RLIMIT_NOFILE, start->descriptor_limit));
}

/// Pin to processor `number` modulo the number of processors that this process may use, which may be fewer
/// than the machine has.
static void pin(const int number)
{
    cpu_set_t set;
    if ((number < 0) || (sched_getaffinity(0, sizeof set, &set) != 0) || (CPU_COUNT(&set) == 0)) {
        return;
    }
    int left = number % CPU_COUNT(&set);
    for (unsigned processor = 0U; processor < (unsigned)CPU_SETSIZE; processor++) {
        if (CPU_ISSET(processor, &set) != 0) {
            if (left == 0) {
                CPU_ZERO(&set);
                CPU_SET(processor, &set);
            }
            left--;
        }
    }
    (void)sched_setaffinity(0, sizeof set, &set); // Without permission the process is not pinned.
}

static bool redirect_output(const char* const path)
{
    const int file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    return (file >= 0) && (dup2(file, STDOUT_FILENO) == STDOUT_FILENO) &&
           (dup2(file, STDERR_FILENO) == STDERR_FILENO);
}

/// Have exec close all descriptors except 0, 1, 2 and the named ones.
static bool keep_only(const int* const descriptors, const size_t count)
{
    if (syscall(SYS_close_range, FIRST_UNNAMED, UINT_MAX, CLOSE_RANGE_CLOEXEC) != 0) {
        const long open_max = sysconf(_SC_OPEN_MAX);
        for (int i = (int)FIRST_UNNAMED; i < (int)((open_max > 0) ? open_max : 1024); i++) {
            (void)fcntl(i, F_SETFD, FD_CLOEXEC);
        }
    }
    for (size_t i = 0U; i < count; i++) {
        if (fcntl(descriptors[i], F_SETFD, 0) != 0) {
            return false;
        }
    }
    return true;
}

static void default_signals(void)
{
    sigset_t none;
    const int signals[] = {SIGINT, SIGTERM, SIGHUP, SIGPIPE};
    for (size_t i = 0U; i < (sizeof signals / sizeof signals[0]); i++) {
        (void)signal(signals[i], SIG_DFL);
    }
    (void)sigemptyset(&none);
    (void)sigprocmask(SIG_SETMASK, &none, NULL);
}

/// Replace this process by the program. Returns only on failure, with errno.
static void execute_program(const osal_process_start_t* const start, const pid_t parent)
{
    if (start->outlives) {
        // The child gets no signals that are sent to the session or process group of the parent.
        (void)setsid();
    } else {
        (void)prctl(PR_SET_PDEATHSIG, (unsigned long)SIGKILL);
        if (getppid() != parent) {
            // The parent has died before PR_SET_PDEATHSIG, so its death has sent no signal.
            _exit(EXIT_NOT_STARTED);
        }
    }
    if (start->has_own_group) {
        (void)setpgid(0, 0); // Cannot fail: the child is no leader of a session.
    }
    default_signals();
    if (start->ignores_terminal) {
        (void)signal(SIGINT, SIG_IGN); // A program that is executed inherits ignored signals.
        (void)signal(SIGHUP, SIG_IGN);
    }
    pin(start->processor);
    if ((start->output_path != NULL) && !redirect_output(start->output_path)) {
        return;
    }
    if (!keep_only(start->descriptors, start->descriptor_count)) {
        return;
    }
    if (!limit_resources(start)) {
        return;
    }
    char* const* arguments = NULL;
    (void)memcpy(&arguments, &start->arguments, sizeof arguments); // Removes the const: exec only reads them.
    (void)execv(start->arguments[0], arguments);
}

// ---- In the parent ----

static status_t status_of_start(const int error)
{
    switch (error) {
    case ENOENT:
    case ENOTDIR:
        return STATUS_NOT_FOUND;
    case EACCES:
    case EPERM:
        return STATUS_DENIED;
    case EAGAIN:
    case ENOMEM:
    case EMFILE:
    case ENFILE:
        return STATUS_EXHAUSTED;
    default:
        return STATUS_IO;
    }
}

static int open_pidfd(const pid_t id)
{
    return (int)syscall(SYS_pidfd_open, id, 0U);
}

static void reap(const pid_t id)
{
    while ((waitpid(id, NULL, 0) < 0) && (errno == EINTR)) {
        // A signal interrupted the call: repeat it.
    }
}

/// Read the result of the child's start: the errno that the child wrote, or 0 if exec closed the pipe.
static int read_outcome(const int pipe_end)
{
    int error    = 0;
    ssize_t size = 0;
    do {
        size = read(pipe_end, &error, sizeof error);
    } while ((size < 0) && (errno == EINTR));
    return (size == (ssize_t)sizeof error) ? error : 0;
}

static void run_child(const osal_process_start_t* start, pid_t parent, int pipe_end)
    __attribute__((noreturn));
static void run_child(const osal_process_start_t* const start, const pid_t parent, const int pipe_end)
{
    execute_program(start, parent);
    const int error       = errno;
    const ssize_t written = write(pipe_end, &error, sizeof error);
    (void)written; // If the parent cannot read the error, the exit code tells it.
    _exit(EXIT_NOT_STARTED);
}

status_t osal_process_start(osal_process_t* const process, const osal_process_start_t* const start)
{
    FSW_ASSERT((process != NULL) && (start != NULL) && (start->arguments != NULL));
    FSW_ASSERT((start->arguments[0] != NULL) &&
               ((start->descriptors != NULL) || (start->descriptor_count == 0U)));
    int outcome[2] = {-1, -1};
    *process       = (osal_process_t){.id = 0, .descriptor = -1};
    // A successful exec closes the pipe, so the parent reads no octets; otherwise the child writes its errno.
    if (pipe2(outcome, O_CLOEXEC) != 0) {
        return status_of_start(errno);
    }
    const pid_t parent = getpid();
    const pid_t id     = fork();
    if (id == 0) {
        run_child(start, parent, outcome[1]);
    }
    int error = (id < 0) ? errno : 0;
    (void)close(outcome[1]);
    if (id > 0) {
        error = read_outcome(outcome[0]);
        // Until the parent has reaped the child, its id cannot belong to another process.
        process->descriptor = (error == 0) ? open_pidfd(id) : -1;
        if ((error == 0) && (process->descriptor < 0)) {
            error = (errno == ESRCH) ? EIO : errno;
            (void)kill(id, SIGKILL);
        }
        if (error != 0) {
            reap(id);
        } else {
            process->id = (int32_t)id;
        }
    }
    (void)close(outcome[0]);
    return (error == 0) ? STATUS_OK : status_of_start(error);
}

status_t osal_process_poll(osal_process_t* const process, osal_process_result_t* const out_result)
{
    FSW_ASSERT((process != NULL) && (out_result != NULL));
    *out_result = (osal_process_result_t){.has_ended = false};
    if ((process->descriptor < 0) || (process->id <= 0)) {
        return STATUS_NOT_OURS;
    }
    int how  = 0;
    pid_t id = 0;
    struct rusage used;
    do {
        id = wait4((pid_t)process->id, &how, WNOHANG, &used);
    } while ((id < 0) && (errno == EINTR));
    if (id < 0) {
        return STATUS_NOT_OURS;
    }
    if (id > 0) {
        out_result->has_ended       = true;
        out_result->was_signalled   = WIFSIGNALED(how);
        out_result->code            = WIFSIGNALED(how) ? WTERMSIG(how) : WEXITSTATUS(how);
        out_result->memory_high_kib = (uint64_t)used.ru_maxrss;
        osal_process_release(process);
    }
    return STATUS_OK;
}

status_t osal_process_wait_any(osal_process_t* const* const processes, const size_t count,
                               const uint32_t timeout_ms)
{
    FSW_ASSERT((count <= OSAL_PROCESS_WAIT_MAX) && ((processes != NULL) || (count == 0U)));
    struct pollfd watched[OSAL_PROCESS_WAIT_MAX + 1U];
    for (size_t i = 0U; i < count; i++) {
        watched[i] = (struct pollfd){.fd = processes[i]->descriptor, .events = POLLIN};
    }
    watched[count]          = (struct pollfd){.fd = osal_process_stop_descriptor(), .events = POLLIN};
    const uint64_t until_ns = osal_clock_monotonic_ns() + ((uint64_t)timeout_ms * NS_PER_MS);
    int ready               = 0;
    do {
        const uint64_t now_ns = osal_clock_monotonic_ns();
        const uint64_t rest_ms =
            (until_ns > now_ns) ? ((until_ns - now_ns + NS_PER_MS - 1U) / NS_PER_MS) : 0U;
        ready = poll(watched, (nfds_t)(count + 1U), (rest_ms < (uint64_t)INT_MAX) ? (int)rest_ms : INT_MAX);
    } while ((ready < 0) && (errno == EINTR));
    if ((ready > 0) && (watched[count].revents != 0)) {
        osal_process_take_stop();
    }
    return (ready > 0) ? STATUS_OK : STATUS_TIMEOUT;
}

static status_t send_signal(const osal_process_t* const process, const int kind)
{
    if (process->descriptor < 0) {
        return STATUS_NOT_FOUND;
    }
    if (syscall(SYS_pidfd_send_signal, process->descriptor, kind, NULL, 0U) != 0) {
        return (errno == ESRCH) ? STATUS_NOT_FOUND : STATUS_DENIED;
    }
    return STATUS_OK;
}

status_t osal_process_stop(osal_process_t* const process, const bool by_force)
{
    FSW_ASSERT(process != NULL);
    return send_signal(process, by_force ? SIGKILL : SIGTERM);
}

status_t osal_process_suspend(osal_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    return send_signal(process, SIGSTOP);
}

/// Returns the state letter of /proc/<id>/stat: "id (program) state ...". The name of the program may contain
/// any character, also ')'.
char osal_process_state(const int32_t id)
{
    char path[32];
    char text[512];
    text_t name = text_in(path, sizeof path);
    text_add(&name, "/proc/");
    text_add_unsigned(&name, (uint64_t)id);
    text_add(&name, "/stat");
    const int file     = open(path, O_RDONLY | O_CLOEXEC);
    const ssize_t size = (file >= 0) ? read(file, text, sizeof text - 1U) : -1;
    if (file >= 0) {
        (void)close(file);
    }
    text[(size > 0) ? size : 0]   = '\0';
    const char* const end_of_name = strrchr(text, ')');
    return ((end_of_name != NULL) && (end_of_name[1] == ' ')) ? end_of_name[2] : '\0';
}

status_t osal_process_look(const osal_process_t* const process, osal_process_look_t* const out_look)
{
    FSW_ASSERT((process != NULL) && (out_look != NULL));
    clockid_t clock      = 0;
    struct timespec used = {0, 0};
    const char state     = (process->descriptor >= 0) ? osal_process_state(process->id) : '\0';
    if ((state == '\0') || (state == 'Z') || (clock_getcpuclockid((pid_t)process->id, &clock) != 0) ||
        (clock_gettime(clock, &used) != 0)) {
        return STATUS_NOT_FOUND;
    }
    *out_look = (osal_process_look_t){.is_stopped  = (state == 'T') || (state == 't'),
                                      .is_runnable = (state == 'R'),
                                      .processor_ns =
                                          ((uint64_t)used.tv_sec * 1000000000ULL) + (uint64_t)used.tv_nsec};
    return STATUS_OK;
}

status_t osal_process_watch(osal_process_t* const process, const int32_t id)
{
    FSW_ASSERT(process != NULL);
    *process             = (osal_process_t){.id = 0, .descriptor = -1};
    const int descriptor = (id > 0) ? open_pidfd((pid_t)id) : -1;
    if (descriptor < 0) {
        return ((id > 0) && (errno == ENOSYS)) ? STATUS_UNSUPPORTED : STATUS_NOT_FOUND;
    }
    process->id         = id;
    process->descriptor = descriptor;
    return STATUS_OK;
}

void osal_process_release(osal_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    if (process->descriptor >= 0) {
        (void)close(process->descriptor);
    }
    process->descriptor = -1;
}

bool osal_process_is_alive(const osal_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    struct pollfd watched = {.fd = process->descriptor, .events = POLLIN};
    int ready             = 0;
    if (process->descriptor < 0) {
        return false;
    }
    do {
        ready = poll(&watched, 1U, 0);
    } while ((ready < 0) && (errno == EINTR));
    return ready == 0; // A pidfd becomes readable when its process ends.
}

const char* osal_process_environment(const char* const name)
{
    FSW_ASSERT(name != NULL);
    const size_t length = strlen(name);
    for (char* const* entry = environ; (entry != NULL) && (*entry != NULL); entry++) {
        if ((strncmp(*entry, name, length) == 0) && ((*entry)[length] == '=')) {
            return &(*entry)[length + 1U];
        }
    }
    return NULL;
}

int32_t osal_process_own_id(void)
{
    return (int32_t)getpid();
}

// ---- Stop signals ----

static void on_stop(const int number)
{
    (void)number;
    const int kept     = errno;
    const uint64_t one = 1U;
    stop_count         = stop_count + 1;
    if (write((int)stop_descriptor, &one, sizeof one) < 0) {
        errno = kept; // The counter is full, so the descriptor is already readable.
    }
    errno = kept;
}

void osal_process_catch_stop(void)
{
    if (stop_descriptor < 0) {
        stop_descriptor = eventfd(0U, EFD_CLOEXEC | EFD_NONBLOCK);
    }
    struct sigaction action;
    (void)memset(&action, 0, sizeof action);
    action.sa_handler = on_stop;
    (void)sigaction(SIGINT, &action, NULL);
    (void)sigaction(SIGTERM, &action, NULL);
    (void)sigaction(SIGHUP, &action, NULL);
    (void)signal(SIGXFSZ, SIG_IGN); // A write beyond the limit returns an error instead.
}

unsigned osal_process_stop_count(void)
{
    return (unsigned)stop_count;
}

int osal_process_stop_descriptor(void)
{
    return (int)stop_descriptor;
}

void osal_process_take_stop(void)
{
    uint64_t count = 0U;
    if (read((int)stop_descriptor, &count, sizeof count) < 0) {
        return; // Another wait has already taken the stop signal.
    }
}

void osal_process_ignore_interrupt(void)
{
    (void)signal(SIGINT, SIG_IGN);
    (void)signal(SIGHUP, SIG_IGN);
    (void)signal(SIGPIPE, SIG_IGN);
}
