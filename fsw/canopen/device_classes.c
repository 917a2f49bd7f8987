// SPDX-License-Identifier: Apache-2.0
// The classes of all data sheets.
#include "fsw/canopen/device_profile.h"

static const canopen_device_profile_t rows[] = {DEVICE_CLASSES};

const canopen_device_classes_t canopen_device_classes = {
    .rows    = rows,
    .count   = sizeof rows / sizeof rows[0],
    .refusal = "type of <Device>: expected a class of descriptors/devices: " DEVICE_CLASSES_NAMES,
};
