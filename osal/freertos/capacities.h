// SPDX-License-Identifier: Apache-2.0
/// Capacities of the programs that fly on a board. Each macro replaces the default value in the header named
/// beside it. The compiler includes this file before each source of such a program, but not in tests.
#ifndef OSAL_FREERTOS_CAPACITIES_H
#define OSAL_FREERTOS_CAPACITIES_H

// base/capacities.h: the descriptors are compiled in, so models need no room.
#define CAPACITY_OF_STORAGE(most) 1U

// fsw/programs/record_store.h: the medium of the records has 64 KiB.
#define RECORD_STORE_LIMIT 32768U
#define RECORD_STORE_SLACK 4096U

#define SHM_STORE_OCTETS 393216U // osal/freertos/shm.c: room for the rings of all eight buses of a mission.
#define COMPONENT_PLAY_OUTS_MAX                                                                              \
    1U // fsw/programs/component_runtime.h: a program on a board has no link with a relay.

#endif // OSAL_FREERTOS_CAPACITIES_H
