// SPDX-License-Identifier: Apache-2.0
/// The subsystem @NAME@: in OPERATIONAL a value follows DES_VALUE at RATE; an event reports its arrival.
///
/// Ownership  The program places @name@_t and the generic subsystem. Neither may be moved after @name@_init.
/// Context    The task of the generic subsystem; its callbacks never block.
#ifndef FSW_SUBSYSTEMS_@NAME@_@NAME@_H
#define FSW_SUBSYSTEMS_@NAME@_@NAME@_H

#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/subsystem/subsystem.h"

#include "generated/@name@_descriptor.h"

#include <stdbool.h>

typedef struct { // All fields are private.
    subsystem_t* generic;
    const flow_resolver_t* resolver; ///< For devices: gives the address of an end node in this run.
    @name@_parameters_t parameters;
    double value;
    bool is_under_way; ///< The value has not arrived yet.
} @name@_t;

/// Once, before the generic subsystem runs. Pointers are kept.
void @name@_init(@name@_t* own, subsystem_t* generic, const flow_resolver_t* resolver);
/// Callbacks for the generic subsystem; their context is the @name@_t.
const subsystem_callbacks_t* @name@_callbacks(void);

#endif // FSW_SUBSYSTEMS_@NAME@_@NAME@_H
