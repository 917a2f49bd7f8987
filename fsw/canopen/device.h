// SPDX-License-Identifier: Apache-2.0
/// One CiA 402 device on a bus: its axes, its process data in both directions, and how long it has been
/// silent.
///
/// The settings that are written to the device decide which PDOs exist, and under which identifiers.
///
/// Ownership  The caller places canopen_device_t; it must not be moved while attached. Master and profile are
///            borrowed.
/// Context    One task. Never blocks.
/// Errors     Each function lists its statuses.
#ifndef FSW_CANOPEN_DEVICE_H
#define FSW_CANOPEN_DEVICE_H

#include "fsw/canopen/axis.h"
#include "fsw/canopen/device_profile.h"
#include "fsw/canopen/master.h"
#include "fsw/canopen/setting.h"
#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

/// Accesses that identify a device: type, vendor, product, units of each axis, and the mapping of each PDO.
#define DEVICE_IDENTIFY_MAX                                                                                  \
    (3U + (2U * PROFILE_AXES_MAX) + (2U * PROFILE_PDOS_MAX * (1U + PROFILE_ENTRIES_MAX)))

typedef struct {
    uint16_t cob;
    bool is_valid;
    bool is_heard;        ///< Transmit PDO: received at least once since canopen_device_connect.
    uint32_t heard_count; ///< Transmit PDO: number of SYNCs sent when it was received last.
} canopen_device_pdo_t;

typedef struct { // axes may be used as axis.h says; all else is read-only outside.
    const canopen_device_profile_t* profile;
    canopen_master_t* master;
    uint8_t node;   ///< Node id.
    uint8_t index;  ///< In master->nodes.
    uint32_t boots; ///< Boot-up messages counted when it was last commissioned.
    canopen_cia402_axis_t axes[PROFILE_AXES_MAX];
    canopen_device_pdo_t transmit[PROFILE_PDOS_MAX];
    canopen_device_pdo_t receive[PROFILE_PDOS_MAX];
    int16_t temperature;     ///< [0.1 degC]
    uint32_t digital_inputs; ///< Object 0x60FD.
    uint32_t malformed;      ///< Process data of a wrong length, dropped [frames, wraps].
    canopen_setting_t identify[DEVICE_IDENTIFY_MAX];
    canopen_setting_run_t run;
} canopen_device_t;

/// Make it known to the master. STATUS_OK, STATUS_EXISTS (node), STATUS_EXHAUSTED, STATUS_INVALID (node id).
MUST_USE status_t canopen_device_attach(canopen_device_t* device, canopen_master_t* master,
                                        const canopen_device_profile_t* profile, uint8_t node);
/// Back to the defaults of its profile, as after a boot-up.
void canopen_device_reset(canopen_device_t* device);

/// Start to identify the device; continue with canopen_device_identify_step. STATUS_BUSY; STATUS_OK: type,
/// identity and mapping are those of the profile, and the axes have their units; else as
/// canopen_setting_run_step, and run.position is the access that failed.
void canopen_device_identify(canopen_device_t* device);
status_t canopen_device_identify_step(canopen_device_t* device);
/// Start to write settings; continue with canopen_device_configure_step. Statuses as
/// canopen_setting_run_step.
void canopen_device_configure(canopen_device_t* device, canopen_setting_t* settings, uint16_t count);
status_t canopen_device_configure_step(canopen_device_t* device);

/// Receive process data from now on. STATUS_OK, STATUS_EXISTS (identifier used by another device),
/// STATUS_EXHAUSTED.
MUST_USE status_t canopen_device_connect(canopen_device_t* device);
void canopen_device_disconnect(canopen_device_t* device);
/// Send the process data that exist.
void canopen_device_emit(canopen_device_t* device);

/// True if each PDO that is sent at every SYNC was received at least once.
bool canopen_device_is_heard(const canopen_device_t* device);
/// SYNCs that its slowest such PDO has not answered; 0 if all were answered.
uint32_t canopen_device_silence(const canopen_device_t* device);

#endif // FSW_CANOPEN_DEVICE_H
