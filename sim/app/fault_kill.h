// SPDX-License-Identifier: Apache-2.0
/// Termination of a process of the run at an instant of simulated time: the scenario's `fault kill`.
///
/// With a scheduler the simulator holds the grant when it applies a fault, so no other process runs. The
/// killed process has done all its work before that instant, and none after it.
#ifndef SIM_APP_FAULT_KILL_H
#define SIM_APP_FAULT_KILL_H

/// Kill a process of this run (SIGKILL) by its name in run.json (supervisor, joystick, operator, simulator,
/// image, ...) or as `launcher`. Does not return when the caller kills itself. If the run has no such
/// process, a message on the console says so.
void fault_kill(const char* process);
/// Suspend and resume a process by a signal (SIGSTOP, SIGCONT). Used for processes that no scheduler
/// controls.
void fault_suspend(const char* process);
void fault_resume(const char* process);

#endif // SIM_APP_FAULT_KILL_H
