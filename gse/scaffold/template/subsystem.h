// SPDX-License-Identifier: Apache-2.0
/// The subsystem @NAME@: in OPERATIONAL a motor and a probe follow DES_VALUE at RATE, twice as fast at the
/// pace FAST; an event reports the arrival. MOVE commands both with one request, which ends at the arrival.
///
/// Ownership  The program provides @name@_t and the generic subsystem. Neither may be moved after
///            @name@_init.
/// Context    The task of the generic subsystem; its callbacks block only as those of fsw/devices do.
#ifndef FSW_SUBSYSTEMS_@NAME@_@NAME@_H
#define FSW_SUBSYSTEMS_@NAME@_@NAME@_H

#include "fsw/equipment/equipment.h"
#include "fsw/framework/dataflow/endnode.h"
#include "fsw/framework/subsystem/subsystem.h"

#include "generated/@name@_descriptor.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct {           // All fields are private.
    equipment_t equipment; ///< First: the callbacks of equipment.h have the same context.
    subsystem_t* generic;
    @name@_parameters_t parameters;
    double value;        ///< Commanded angle of both devices [rad].
    bool is_under_way;   ///< The value has not arrived yet.
    uint32_t move_token; ///< Token of the MOVE that is performed; 0: there is none.
} @name@_t;

/// Initialise the subsystem. Must be called once, before the generic subsystem runs. The pointers are kept.
void @name@_init(@name@_t* own, subsystem_t* generic, const flow_resolver_t* resolver);
/// Callbacks for the generic subsystem; their context is the @name@_t.
const subsystem_callbacks_t* @name@_callbacks(void);

#endif // FSW_SUBSYSTEMS_@NAME@_@NAME@_H
