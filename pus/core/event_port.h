// SPDX-License-Identifier: Apache-2.0
/// The port by which services raise events. ST[05] of the process implements it, or another module with the
/// event definitions.
#ifndef PUS_CORE_EVENT_PORT_H
#define PUS_CORE_EVENT_PORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct {
    void* context;
    /// True if the event is defined.
    bool (*is_known)(void* context, uint16_t event_id);
    /// True if a service that raises this event with `size` octets of auxiliary data supplies all auxiliary
    /// data of its definition. If this pointer is null, every size is accepted.
    bool (*can_fill)(void* context, uint16_t event_id, size_t size);
    /// Raise an event. The service that raises it defines `auxiliary` in its header; if the event is defined
    /// without auxiliary data or with other ones, the port omits them. The port counts events that it cannot
    /// raise.
    void (*raise)(void* context, uint16_t event_id, const uint8_t* auxiliary, size_t size, uint64_t now_ns);
} pus_event_port_t;

#endif // PUS_CORE_EVENT_PORT_H
