// SPDX-License-Identifier: Apache-2.0
/// Functions that only the source files of the launcher share.
#ifndef LAUNCHER_LAUNCHER_INTERNAL_H
#define LAUNCHER_LAUNCHER_INTERNAL_H

#include "base/text.h"
#include "launcher/arguments.h"
#include "launcher/launcher.h"

/// Interval of checks in a run without a scheduler or in stepped time [ms].
#define LAUNCHER_LOOP_MS 20U
/// Interval of checks if the scheduler works in real time [ms]; short, because a hang must be detected soon.
#define LAUNCHER_REAL_LOOP_MS 5U
#define LAUNCHER_NO_PARTICIPANT OSAL_LOCKSTEP_PARTICIPANTS_MAX

// ---- Start of children: launcher_children.c ----

/// Returns the path of the project's own Python interpreter if it exists, otherwise of the system's.
const char* launcher_python(void);
/// Start a child with its arguments; it inherits the descriptors. If it cannot be started, the run fails.
void launcher_start_child(launcher_t* launcher, child_t* child, const arguments_t* arguments,
                          const int* descriptors, size_t descriptor_count);
/// Start the process of a component (or its proxy) for its present life.
void launcher_start_component(launcher_t* launcher, child_t* child);
/// Start all children of a run.
void launcher_start_all(launcher_t* launcher);

// ---- On-board computers, and the sockets of messages and links on them: launcher_computers.c ----

/// Check the requirements of the options before anything is created. False: `reason` says what is missing.
bool launcher_check_system(launcher_t* launcher);
/// Create the on-board computers of the run, if it has more than one. False: `reason` says why not.
bool launcher_create_computers(launcher_t* launcher);
/// Remove the namespaces of a run with this identity; no effect if there are none.
void launcher_remove_computers(const char* identity);
/// Open every socket of messages and links on the on-board computer of its owner. False: `reason` says what
/// is missing.
bool launcher_open_sockets(launcher_t* launcher);
/// Let sockets and processes that are created from now on belong to that computer; no effect with one
/// computer.
bool launcher_enter_computer(launcher_t* launcher, unsigned computer);
/// Return to the network namespace of the launcher.
void launcher_leave_computer(launcher_t* launcher);

/// launcher_device_classes.c: check that the data sheets in descriptors/devices are those from which the
/// device classes of this build were made. A missing sheet is no error, because flight software does not
/// read them. False: `reason` says which one has changed and what to do.
bool launcher_check_device_classes(launcher_t* launcher);

/// launcher_remote_endian.c: check a subsystem whose program is for another processor. False: `reason` says
/// what is missing and what to do.
bool launcher_check_remote_endian(launcher_t* launcher);
/// True if the program of the component runs on another processor and has a proxy.
bool launcher_has_proxy(const launcher_t* launcher, unsigned component);
/// Octets of messages that may be on their way to the component (message_set_window).
uint32_t launcher_message_window(const launcher_t* launcher, unsigned component);
/// Add program and arguments of a component's process, or of its proxy.
void launcher_add_component(const launcher_t* launcher, unsigned component, arguments_t* arguments);

/// launcher_limits.c: determine the limits of memory and descriptors for each subsystem. False: `reason` says
/// which limit is too low. A limit that the mission does not define is derived from the program and printed.
bool launcher_set_limits(launcher_t* launcher, const char* mission_path);
/// Write the limits of the child into the description of its start.
void launcher_limit(const launcher_t* launcher, const child_t* child, osal_process_start_t* start);
/// Check whether a child has ended, and store its peak memory. True only once for each end.
bool launcher_has_ended(const launcher_t* launcher, child_t* child);

/// launcher_prepare.c: take over the remains of a run whose launcher was killed, to clean them up. `run` is
/// null if the run state was not created yet.
void launcher_take_over(launcher_t* launcher, const launch_options_t* options, const char* program_directory,
                        run_state_t* run);
/// Returns the process number after "hirosco-" in an identity; 0 if there is none.
int32_t launcher_owner_of(const char* identity);

/// launcher_clean_up.c: remove every name of a run with this identity.
void launcher_remove_all(const char* identity);
/// Run a tool to its end. False if it failed.
bool launcher_run_tool(launcher_t* launcher, const arguments_t* arguments, const char* name);

/// launcher_buses.c: prepare the interfaces of the buses before the run state exists; then create the shared
/// memory, and write the addresses to the run state. False: `reason` says what is wrong and what to do.
/// Removing the buses also reports frames that did not arrive as announced.
bool launcher_ready_interfaces(launcher_t* launcher);
bool launcher_create_buses(launcher_t* launcher);
void launcher_remove_buses(launcher_t* launcher);
/// Take over virtual interfaces that a killed launcher has created, so that they are removed with the buses.
void launcher_adopt_interfaces(launcher_t* launcher);

/// launcher_streams.c: check the stream devices of a run on two on-board computers, whose network leads to no
/// host of a device: end nodes of types UDP and TCP are refused. False: `reason` says which one, with file
/// and line. The mission keeps its content; `scratch` changes.
bool launcher_check_streams(launcher_t* launcher, const char* mission_path);

/// launcher_watch.c: suspend a process that hangs while it holds the grant; end the life of a process that
/// was started again and does not join or, unless time is stepped, makes no step.
void launcher_watch_lives(launcher_t* launcher);
/// True if the holder of the grant is ready to run but gets no processor.
bool launcher_is_starved(launcher_t* launcher);
/// Returns the name of the process that holds the grant, for messages.
const char* launcher_holder(launcher_t* launcher);

/// launcher.c: returns mission time [ns]: simulated time, or without a scheduler the time since the origin of
/// the run.
uint64_t launcher_now_ns(const launcher_t* launcher);
/// True if a flag in shared memory is set.
bool launcher_is_set(const uint32_t* flag);
/// Let the run fail, with the concatenated words of a list (null at the end) as its reason; only the first
/// reason is kept. Returns false.
bool launcher_refuse(launcher_t* launcher, const char* const* words);
/// Like launcher_refuse, with two words. Returns false, so that a step of the preparation can return it.
bool launcher_fail(launcher_t* launcher, const char* what, const char* detail);
/// True if the end of a child is not a failure: its exit code is 0, or it is an operator that has lost its
/// link because the user ended the mission before the script ended. A step of the script that failed is a
/// failure.
bool launcher_has_ended_well(const launcher_t* launcher, const child_t* child);
/// React to the unexpected end of a process: the run continues as far as possible, and its result is a
/// failure.
void launcher_part_lost(launcher_t* launcher, child_t* child);

#endif // LAUNCHER_LAUNCHER_INTERNAL_H
