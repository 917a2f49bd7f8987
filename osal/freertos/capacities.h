// SPDX-License-Identifier: Apache-2.0
/// Capacities of the programs that fly on a board; each replaces a default of the header that it belongs to.
/// The compiler includes this file before each source of such a program, and not in tests.
#ifndef OSAL_FREERTOS_CAPACITIES_H
#define OSAL_FREERTOS_CAPACITIES_H

#define CAPACITY_OF_STORAGE(most) 1U // base/capacities.h: descriptors are compiled in.

// fsw/programs/record_store.h: the records are on a medium of 64 KiB.
#define RECORD_STORE_LIMIT 32768U
#define RECORD_STORE_SLACK 4096U

#define SHM_STORE_OCTETS 393216U // osal/freertos/shm.c: the rings of all eight buses that a mission may have.
#define COMPONENT_PLAY_OUTS_MAX                                                                              \
    1U // fsw/programs/component_runtime.h: a program on a board has no link with a relay.

#endif // OSAL_FREERTOS_CAPACITIES_H
