// SPDX-License-Identifier: Apache-2.0
/// Child processes. A child dies with its parent, unless it is started with `outlives`, and inherits only the
/// descriptors that osal_process_start_t lists.
///
/// Errors   On a system without processes each function with a status returns STATUS_UNSUPPORTED.
/// Context  "Parent" is the task that started the child: when that task ends, the child is killed
///          unless it `outlives`.
///          One task of a program waits for stop signals (osal_process_wait_any, osal_clock_wait).
#ifndef OSAL_PROCESS_H
#define OSAL_PROCESS_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_PROCESS_WAIT_MAX 64U ///< Processes for which one osal_process_wait_any waits.

typedef struct {    // Private, except id.
    int32_t id;     ///< Process id; for text output only, never in a packet.
    int descriptor; ///< pidfd, -1 when not running.
} osal_process_t;

typedef struct {
    const char* const* arguments; ///< Null-terminated; [0] is the executable's path.
    const int* descriptors;       ///< Descriptors that the child inherits; 0, 1, 2 are always inherited.
    size_t descriptor_count;
    uint64_t memory_limit_octets; ///< Limit of the address space; 0, or a build with sanitizers: none.
    uint32_t descriptor_limit;    ///< New descriptors have lower numbers; 0: the limit of the parent.
    /// Pin to this processor, modulo the number of those that this process may use; -1: not pinned.
    int processor;
    const char* output_path; ///< Standard output and error are appended to this file; null: inherited.
    bool outlives;           ///< Continues when its parent ends, in a session of its own.
    bool ignores_terminal;   ///< Starts with SIGINT and SIGHUP ignored: they are for its parent.
    /// Starts in a process group of its own, to which the terminal sends no signals. For programs that do not
    /// keep SIGINT ignored.
    bool has_own_group;
} osal_process_start_t;

#define OSAL_SIGNAL_KILL 9 ///< Value of osal_process_result_t.code: SIGKILL.
#define OSAL_SIGNAL_END 15 ///< Value of osal_process_result_t.code: SIGTERM.

typedef struct {
    bool has_ended;
    bool was_signalled; ///< Ended by a signal.
    int code;           ///< Exit code, or signal number.
    /// Peak resident size [KiB]; at least the resident size of its parent when it was started.
    uint64_t memory_high_kib;
} osal_process_result_t;

typedef struct {
    bool is_stopped;       ///< Stopped by a signal: it cannot continue by itself.
    bool is_runnable;      ///< Runs or is ready to run. False: the process is blocked.
    uint64_t processor_ns; ///< Processor time that the process has used.
} osal_process_look_t;

/// Start a child. `process` is for the calls below. STATUS_OK, STATUS_NOT_FOUND (no such executable, or
/// directory of output_path), STATUS_DENIED, STATUS_EXHAUSTED, STATUS_IO.
MUST_USE status_t osal_process_start(osal_process_t* process, const osal_process_start_t* start);
/// Octets of memory that an executable needs when it is loaded, without its shared libraries. STATUS_OK,
/// STATUS_NOT_FOUND, STATUS_DENIED, STATUS_INVALID (no executable of this machine), STATUS_IO.
MUST_USE status_t osal_process_loaded_size(const char* path, uint64_t* out_octets);
/// Check without waiting whether a child has ended. Called by the parent only; reports the end once.
/// STATUS_OK, STATUS_NOT_OURS (not a child, or its end was reported).
MUST_USE status_t osal_process_poll(osal_process_t* process, osal_process_result_t* out_result);
/// Wait (wall-clock) until any of the processes has ended or a stop signal has come, at most timeout_ms.
/// `count` is at most OSAL_PROCESS_WAIT_MAX. STATUS_OK, STATUS_TIMEOUT.
status_t osal_process_wait_any(osal_process_t* const* processes, size_t count, uint32_t timeout_ms);
/// Request the process to end (SIGTERM), or kill it (SIGKILL). STATUS_OK, STATUS_NOT_FOUND (has ended),
/// STATUS_DENIED.
status_t osal_process_stop(osal_process_t* process, bool by_force);
/// Suspend the process (SIGSTOP) until it is ended. Same statuses as osal_process_stop.
status_t osal_process_suspend(osal_process_t* process);
/// State of the process now. STATUS_OK, STATUS_NOT_FOUND (has ended).
MUST_USE status_t osal_process_look(const osal_process_t* process, osal_process_look_t* out_look);
/// Watch a process that is not a child of this one, by its id. STATUS_OK, STATUS_NOT_FOUND (also: no
/// descriptor left), STATUS_UNSUPPORTED.
MUST_USE status_t osal_process_watch(osal_process_t* process, int32_t id);
/// Stop watching; the process itself continues. Not necessary for a child whose end was reported.
void osal_process_release(osal_process_t* process);
/// True if the process has not ended. False also after osal_process_release.
bool osal_process_is_alive(const osal_process_t* process);
int32_t osal_process_own_id(void);
/// Returns the value of an environment variable of this program, or null if there is none. Valid until the
/// program ends.
const char* osal_process_environment(const char* name);

/// Ctrl-C, SIGTERM and SIGHUP are counted instead of ending the program; writing beyond the permitted file
/// size does not end it either. osal_process_stop_count returns the number of stop signals so far.
void osal_process_catch_stop(void);
unsigned osal_process_stop_count(void);
/// For the waiting functions of this layer. The first function returns a descriptor that is readable when a
/// stop signal has come (-1: stop signals are not caught); the second one makes it unreadable again.
int osal_process_stop_descriptor(void);
void osal_process_take_stop(void);
/// This process ignores SIGINT, SIGHUP and SIGPIPE from now on: the parent handles Ctrl-C and the end of the
/// terminal, which the terminal reports to the whole process group.
void osal_process_ignore_interrupt(void);

#endif // OSAL_PROCESS_H
