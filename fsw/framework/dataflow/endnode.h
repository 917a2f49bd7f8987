// SPDX-License-Identifier: Apache-2.0
/// End nodes of data flows: each has a logical name in the descriptor, and an address in this run.
///
/// A descriptor says `<Endnode type="CAN" bus="robot"/>`; the machine and the run decide which controller,
/// port or memory this name means. Therefore the program gives every component a resolver, which returns
/// the address. Addresses never enter a packet.
///
///     CAN  "shm:NAME" or "can:INTERFACE" (osal/can.h)      UDP, TCP  "127.0.0.1:10015"
///     SHM  "/NAME" (osal/shm.h)                            MQUEUE    "/NAME" (osal/mqueue.h)
///     SERIAL, FILE  path of the device (osal/serial.h, osal/device.h)
///
/// Ownership  The resolver is borrowed and outlives the flows opened with it.
/// Context    Any.
/// Time       O(length).
#ifndef FSW_FRAMEWORK_DATAFLOW_ENDNODE_H
#define FSW_FRAMEWORK_DATAFLOW_ENDNODE_H

#include "base/status.h"
#include "osal/include/osal/hand_over.h"
#include "osal/include/osal/socket.h"

#include <stdbool.h>
#include <stdint.h>

#define ENDNODE_ADDRESS_MAX 72U ///< Characters of an address, NUL included.

typedef enum {
    ENDNODE_CAN,
    ENDNODE_UDP,
    ENDNODE_TCP,
    ENDNODE_SHM,
    ENDNODE_MQUEUE,
    ENDNODE_SERIAL,
    ENDNODE_FILE
} flow_endnode_kind_t;

typedef struct {
    char address[ENDNODE_ADDRESS_MAX];
    /// Streams and datagrams: name of the counts of stepped time (osal/hand_over.h); "" if there are none.
    char counts[ENDNODE_ADDRESS_MAX];
    bool is_fd; ///< CAN: process data travels in FD frames with bit rate switch.
} flow_endnode_address_t;

/// Resolver of the addresses of this run.
typedef struct {
    void* context;
    /// Look up an address. STATUS_OK; STATUS_NOT_FOUND (no such end node in this run).
    status_t (*resolve)(void* context, flow_endnode_kind_t kind, const char* name,
                        flow_endnode_address_t* out_address);
} flow_resolver_t;

/// Get an address from the resolver. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID (an address without NUL).
MUST_USE status_t flow_endnode_resolve(const flow_resolver_t* resolver, flow_endnode_kind_t kind,
                                       const char* name, flow_endnode_address_t* out_address);

/// Ask the resolver for an end node whose address is a socket address, and open its counts, if it has any.
/// Statuses of flow_endnode_resolve; STATUS_NOT_FOUND also: the device is not present.
MUST_USE status_t flow_endnode_resolve_socket(const flow_resolver_t* resolver, flow_endnode_kind_t kind,
                                              const char* name, osal_address_t* out_address,
                                              osal_hand_over_t* out_counts);
/// Open the counts of an end node; if it has none, *out_counts is closed. Statuses of osal_hand_over_open.
MUST_USE status_t flow_endnode_open_counts(const flow_endnode_address_t* address,
                                           osal_hand_over_t* out_counts);

/// Convert "A.B.C.D:PORT" to a socket address. STATUS_OK, STATUS_INVALID.
MUST_USE status_t flow_endnode_socket_address(const char* text, osal_address_t* out_address);

#endif // FSW_FRAMEWORK_DATAFLOW_ENDNODE_H
