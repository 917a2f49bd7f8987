// SPDX-License-Identifier: Apache-2.0
/// Addresses of data flows in a run, without those of buses. Queues are named by the run. With real devices,
/// hosts and paths are those of the descriptor. Simulated devices are at addresses of the run, so that the
/// hosts, ports and paths of a descriptor are free in each run:
///
///     UDP, TCP      loopback addresses of the run (osal/socket.h), with the port of the descriptor
///     SERIAL, FILE  a link in the folder of the run's shared memory
///
/// In stepped time the octets and datagrams of simulated devices are counted (osal/hand_over.h).
#ifndef FSW_PROGRAMS_RUN_FLOW_ADDRESS_H
#define FSW_PROGRAMS_RUN_FLOW_ADDRESS_H

#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/programs/run_state.h"

/// Address of an end node that is not a bus. UDP, TCP: "HOST:PORT", or ":PORT" for the own end. STATUS_OK,
/// STATUS_NOT_FOUND (too long, or there are too many queues).
MUST_USE status_t run_flow_address(run_state_t* run, flow_endnode_kind_t kind, const char* name,
                                   flow_endnode_address_t* out_address);

#endif // FSW_PROGRAMS_RUN_FLOW_ADDRESS_H
