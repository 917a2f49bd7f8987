// SPDX-License-Identifier: Apache-2.0
/// One component of a mission with its storage, ready to be stepped. In the processes form it runs alone; the
/// image steps all of them in turn. The source file of each component contains its static storage and
/// connects its parts.
#ifndef FSW_PROGRAMS_COMPONENT_INSTANCE_H
#define FSW_PROGRAMS_COMPONENT_INSTANCE_H

#include "fsw/programs/component_runtime.h"
#include "fsw/framework/subsystem/subsystem_core.h"

#include <stddef.h>
#include <stdint.h>

typedef struct {
    void* self;
    /// Process received messages, run the work that is due. Returns the next wake [ns of the run].
    uint64_t (*step)(void* self, uint64_t now_ns, uint32_t octets_due);
    /// List further sockets whose data wake the component. May be null.
    size_t (*sockets)(void* self, osal_socket_t** out_sockets, size_t capacity);
    /// Process a datagram of a real-time link.
    void (*link_datagram)(void* self, const uint8_t* frame, size_t size);
    /// Release the system resources that the component has opened, without any message, as at the end of its
    /// process.
    void (*close)(void* self);
    subsystem_t* component; ///< Component whose loops of services may have their own tasks, or null.
    void* storage;          ///< All data of the component; zeros before it is opened.
    size_t size;
} component_instance_t;

/// Open the component in its static storage. False: runtime->error contains the reason.
typedef bool (*component_open_t)(component_runtime_t* runtime, component_instance_t* out_instance);

/// Declare the function <name>_open of each file fsw/programs/<name>_program.c. The build generates the
/// list of names.
#define COMPONENT(name, executable)                                                                          \
    bool name##_open(component_runtime_t* runtime, component_instance_t* out_instance);
#include "generated/programs.h"
#undef COMPONENT

/// Returns the function that opens the component of an executable ("manipulator"), or null.
component_open_t component_find(const char* executable);

#endif // FSW_PROGRAMS_COMPONENT_INSTANCE_H
