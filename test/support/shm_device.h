// SPDX-License-Identifier: Apache-2.0
/// The other end of a stream device of kind shared memory, for tests: the test writes records to the flight
/// software and reads its commands.
#ifndef TEST_SUPPORT_SHM_DEVICE_H
#define TEST_SUPPORT_SHM_DEVICE_H

#include "fsw/framework/dataflow/flow.h"
#include "fsw/framework/dataflow/flow_shm.h"

typedef struct {
    const char* name; ///< Name of the end node in the descriptor.
    unsigned octets;  ///< Size of a record [octets].
} shm_device_end_t;

/// Open the writer of records and prepare the reader of commands, which opens when the flight software has
/// created the memory. Returns the status of the first step of the writer.
static inline status_t shm_device_open(flow_shm_t* const to_flight, const shm_device_end_t in,
                                       flow_shm_t* const to_device, const shm_device_end_t out,
                                       const flow_resolver_t* const resolver, const uint64_t now_ns)
{
    const flow_shm_setup_t writer = {.name             = in.name,
                                     .is_writer        = true,
                                     .shape            = {FLOW_SHM_QUEUE, in.octets, FLOW_DEPTH},
                                     .retry_first_ns   = 1U,
                                     .retry_longest_ns = 1U};
    const flow_shm_setup_t reader = {.name             = out.name,
                                     .shape            = {FLOW_SHM_QUEUE, out.octets, FLOW_DEPTH},
                                     .retry_first_ns   = 1U,
                                     .retry_longest_ns = 1U};
    flow_shm_init(to_flight, &writer, resolver);
    flow_shm_init(to_device, &reader, resolver);
    return flow_shm_step(to_flight, now_ns);
}

#endif // TEST_SUPPORT_SHM_DEVICE_H
