// SPDX-License-Identifier: Apache-2.0
/// The loop of a program that holds one component: the only place where it waits.
#ifndef FSW_PROGRAMS_EXECUTIVE_H
#define FSW_PROGRAMS_EXECUTIVE_H

#include "fsw/programs/program.h"
#include "fsw/framework/descriptor/descriptor.h"

/// Command line `--run NAME --component INDEX`, as the launcher gives it, or `--run NAME --stand-in
/// DESCRIPTOR`, as the stand-in of a foreign program does (foreign_wire.h). Returns the exit code: 0 the run
/// ended, 1 could not start (one line on standard error), 2 usage. `scope`: `mission_whole` for the
/// supervisor; others read only their own part of the mission (NULL); the launcher has checked the whole
/// mission.
int executive_main(int argument_count, char* const arguments[], const char* executable, program_open_t open,
                   const mission_scope_t* scope);

#endif // FSW_PROGRAMS_EXECUTIVE_H
