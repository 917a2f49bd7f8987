// SPDX-License-Identifier: Apache-2.0
/// Capacities of the programs that fly on a board. Each macro replaces the default value in the header named
/// beside it. The compiler includes this file before each source of such a program, but not in tests. If a
/// source is compiled for one program only, the generated header with the capacities of that program comes
/// before this file.
#ifndef OSAL_FREERTOS_CAPACITIES_H
#define OSAL_FREERTOS_CAPACITIES_H

// base/capacities.h: the descriptors are compiled in, so models need no room.
#define CAPACITY_OF_STORAGE(most) 1U

// fsw/programs/record_store.h: the medium of the records has 64 KiB.
#define RECORD_STORE_LIMIT 32768U
#define RECORD_STORE_SLACK 4096U
// docs/porting.md, "How long a commit blocks".
#define RECORD_STORE_MOVES 4U

#define SHM_STORE_OCTETS 393216U // osal/freertos/shm.c: room for the rings of all eight buses of a mission.
#define COMPONENT_PLAY_OUTS_MAX                                                                              \
    1U // fsw/programs/component_runtime.h: a program on a board has no link with a relay.

#define PUS_PACKET_MAX 1024U // pus/core/tailoring.h: longer requests are rejected with TM[1,2].
#define PUS_PLAIN_SIZE 3584U // pus/core/app_process.h
// fsw/framework/message/message.h: the launcher gives this window to components on a board.
#define MESSAGE_ROOM_OCTETS MESSAGE_SMALL_WINDOW_OCTETS
// fsw/framework/subsystem/subsystem_core.h
#define SUBSYSTEM_INBOX_OCTETS 1536U
#define SUBSYSTEM_LOOP_ANSWER 1536U
#define SUBSYSTEM_FUNCTIONAL 2U
// fsw/programs/run_state.h: flows that the program itself creates; it starts no process.
#define RUN_FLOWS_MAX 8U
#define RUN_PROCESSES_MAX 1U
#define RTLINK_PAYLOAD_MAX 256U  // fsw/framework/rtlink/agreement.h
#define JOURNAL_RECORD_MAX 2048U // fsw/framework/journal/journal.h
// fsw/framework/rtlink/play_out.h: a program on a board does not use the buffer.
#define RTLINK_PLAY_OUT_SAMPLES 1U
#define RTLINK_PLAY_OUT_OCTETS RTLINK_PAYLOAD_MAX

// A source that is compiled once for all programs must not use a capacity that differs between programs: it
// would not compile.
#ifndef SUBSYSTEM_PARAMETERS
#define SUBSYSTEM_PARAMETERS known_only_for_one_program
#define SUBSYSTEM_LINKS known_only_for_one_program
#define DRIVES_BUSES_MAX known_only_for_one_program
#define DRIVES_DEVICES_MAX known_only_for_one_program
#endif

#endif // OSAL_FREERTOS_CAPACITIES_H
