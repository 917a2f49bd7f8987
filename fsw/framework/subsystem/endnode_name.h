// SPDX-License-Identifier: Apache-2.0
/// End nodes of a descriptor in the form of data flows: kind, and the name to resolve.
///
/// Ownership  The caller keeps the buffer.
/// Context    Any.
/// Time       O(length).
#ifndef FSW_FRAMEWORK_SUBSYSTEM_ENDNODE_NAME_H
#define FSW_FRAMEWORK_SUBSYSTEM_ENDNODE_NAME_H

#include "base/status.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/descriptor/subsystem_descriptor.h"

/// CAN: the bus; UDP and TCP: "ADDRESS:PORT"; else the name. STATUS_OK, STATUS_TOO_LARGE (no flow takes a
/// name that long; out_name is then empty).
MUST_USE status_t subsystem_endnode_name(const descriptor_endnode_t* endnode, flow_endnode_kind_t* out_kind,
                                         char out_name[ENDNODE_ADDRESS_MAX]);

#endif // FSW_FRAMEWORK_SUBSYSTEM_ENDNODE_NAME_H
