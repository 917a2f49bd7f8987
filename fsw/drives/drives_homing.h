// SPDX-License-Identifier: Apache-2.0
/// Homing: the axes search the references of their positions (CiA 402). The descriptor requests it by a
/// configuration with the mode of operation 6 (0x6060); method, speeds and offset are settings, too.
///
/// Only axes in operation search; the search of an axis ends when the axis leaves operation for any reason.
///
/// Context    The subsystem's task.
/// Time       O(devices and axes of the configuration).
#ifndef FSW_DRIVES_DRIVES_HOMING_H
#define FSW_DRIVES_DRIVES_HOMING_H

#include "fsw/drives/drives.h"

/// Start or end the search of all axes whose devices are in mode homing. STATUS_OK; STATUS_NOT_FOUND (no
/// device is in that mode).
status_t drives_home(drives_t* drives, bool is_wanted);
/// Returns the result of the search. STATUS_BUSY; STATUS_OK (all axes have found their references);
/// STATUS_INVALID (the drive *out_node reports an error); STATUS_EMPTY (not started, or an axis is not in
/// operation).
status_t drives_homing(drives_t* drives, uint8_t* out_node);

#endif // FSW_DRIVES_DRIVES_HOMING_H
