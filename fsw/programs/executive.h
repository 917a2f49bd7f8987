// SPDX-License-Identifier: Apache-2.0
/// The loop of a program with one component. The program waits only in this loop.
#ifndef FSW_PROGRAMS_EXECUTIVE_H
#define FSW_PROGRAMS_EXECUTIVE_H

#include "fsw/programs/component_instance.h"

struct mission_scope; // descriptor.h

/// Command line `--run NAME --component INDEX`, which the launcher passes, or `--run NAME --proxy
/// DESCRIPTOR`, which the proxy of a remote-endian program passes (remote_endian_wire.h). Returns the exit
/// code: 0: the run has ended; 1: the program could not start (one line on standard error); 2: wrong usage.
int executive_run(int argument_count, char* const arguments[], const char* executable, component_open_t open,
                  const component_descriptors_t* descriptors);
/// Like executive_run, with descriptors from files. `scope`: `descriptor_mission_whole` for the supervisor;
/// NULL for other components, which read only their own part of the mission; the launcher has checked the
/// whole mission.
int executive_main(int argument_count, char* const arguments[], const char* executable, component_open_t open,
                   const struct mission_scope* scope);

#endif // FSW_PROGRAMS_EXECUTIVE_H
