// SPDX-License-Identifier: Apache-2.0
/// Addresses of data flows in a run, except those of buses. Names of queues begin with the name of the run.
/// Hosts and paths of real devices are those of the descriptor. Simulated devices have addresses of the run
/// instead, so that several runs on one machine do not use the same hosts, ports and paths:
///
///     UDP, TCP      loopback addresses of the run (osal/socket.h), with the port of the descriptor
///     SERIAL, FILE  a link in the directory of the run's shared memory
///
/// In stepped time the octets and datagrams of simulated devices are counted (osal/hand_over.h).
#ifndef FSW_PROGRAMS_RUN_FLOW_ADDRESS_H
#define FSW_PROGRAMS_RUN_FLOW_ADDRESS_H

#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/programs/run_state.h"

/// Get the address of an end node that is not a bus. UDP, TCP: "HOST:PORT", or ":PORT" for the end in
/// flight. STATUS_OK, STATUS_NOT_FOUND (too long, or there are too many queues).
MUST_USE status_t run_flow_address(run_state_t* run, flow_endnode_kind_t kind, const char* name,
                                   flow_endnode_address_t* out_address);

#endif // FSW_PROGRAMS_RUN_FLOW_ADDRESS_H
