// SPDX-License-Identifier: Apache-2.0
/// Death of a process of the run at an instant of simulated time: the scenario's `fault kill`.
///
/// In a calendar the simulator holds the grant when it applies a fault, so that nobody else runs: whoever is
/// killed then has lived through all of its work before that instant, and does none after it.
#ifndef SIM_APP_DEATH_H
#define SIM_APP_DEATH_H

/// SIGKILL for a process of this run by its name in run.json (supervisor, joystick, operator, simulator,
/// image
/// ...), or for `launcher`. Our own death returns to nobody. Without such a process a line on the console
/// says so.
void death_of(const char* process);
/// SIGSTOP and SIGCONT in the same way: a process that hangs, where no calendar can suspend it.
void stop_of(const char* process);
void continuation_of(const char* process);

#endif // SIM_APP_DEATH_H
