// SPDX-License-Identifier: Apache-2.0
/// The loop of a program that holds one component: the only place where it waits.
#ifndef FSW_PROGRAMS_EXECUTIVE_H
#define FSW_PROGRAMS_EXECUTIVE_H

#include "fsw/programs/component_instance.h"
#include "fsw/framework/descriptor/descriptor.h"

/// Command line `--run NAME --component INDEX`, as the launcher gives it, or `--run NAME --proxy
/// DESCRIPTOR`, as the proxy of a remote-endian program does (remote_endian_wire.h). Returns the exit code: 0
/// the run ended, 1 could not start (one line on standard error), 2 usage. `scope`:
/// `descriptor_mission_whole` for the supervisor; others read only their own part of the mission (NULL); the
/// launcher has checked the whole mission.
int executive_main(int argument_count, char* const arguments[], const char* executable, component_open_t open,
                   const mission_scope_t* scope);

#endif // FSW_PROGRAMS_EXECUTIVE_H
