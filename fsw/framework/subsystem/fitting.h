// SPDX-License-Identifier: Apache-2.0
/// Checks that a program supports its descriptor: before the program starts, and before a reloaded descriptor
/// comes into force. The reader of descriptors cannot check these properties of the program: the callbacks of
/// the subsystem, the sizes of the component, and the devices that the subsystem can drive.
///
/// Context    At start and on TC[129,6].
/// Time       O(descriptor).
#ifndef FSW_FRAMEWORK_SUBSYSTEM_FITTING_H
#define FSW_FRAMEWORK_SUBSYSTEM_FITTING_H

#include "fsw/framework/descriptor/subsystem_descriptor.h"
#include "fsw/framework/subsystem/subsystem.h"

#include <stdbool.h>

/// True if the program supports the descriptor; otherwise *out_misfit is the first content that the program
/// does not support.
bool subsystem_fits(const subsystem_descriptor_t* descriptor, const subsystem_callbacks_t* callbacks,
                    subsystem_misfit_t* out_misfit);

#endif // FSW_FRAMEWORK_SUBSYSTEM_FITTING_H
