// SPDX-License-Identifier: Apache-2.0
/// One device on a bus: its axes (CiA 402), the other values of its process data (CiA 401, 404, manufacturer
/// objects), and how long it has been silent.
///
/// The settings that are written to the device decide which PDOs exist, and under which identifiers.
///
/// Ownership  The caller provides canopen_device_t; it must not be moved while attached. Master and profile
///            are borrowed.
/// Context    One task. Never blocks.
/// Errors     Each function lists its statuses.
#ifndef FSW_CANOPEN_DEVICE_H
#define FSW_CANOPEN_DEVICE_H

#include "fsw/canopen/axis.h"
#include "fsw/canopen/device_profile.h"
#include "fsw/canopen/master.h"
#include "fsw/canopen/setting.h"
#include "base/capacities.h"
#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

/// Numbers of accesses in one step of an identification. The first step reads type, vendor and product of the
/// device, and the torques of each axis; a step for each axis reads its units; each further step reads the
/// mapping of one PDO, which is the longest step.
#define DEVICE_IDENTIFY_FIRST (3U + (2U * PROFILE_AXES_MAX))
#define DEVICE_IDENTIFY_MAX (1U + PROFILE_ENTRIES_MAX)
CAPACITY_CHECK(steps_of_an_identification_fit,
               (DEVICE_IDENTIFY_MAX >= DEVICE_IDENTIFY_FIRST) && (DEVICE_IDENTIFY_MAX >= PROFILE_UNITS_MAX));

typedef struct {
    uint16_t cob;
    bool is_valid;
    /// Receive PDO: the master has sent it, so the device may hold values of it that are not zero.
    bool is_sent;
    bool is_heard; ///< Transmit PDO: received at least once since canopen_device_connect.
    /// Transmit PDO: number of SYNCs that the master had sent when the PDO arrived last.
    uint32_t heard_count;
} canopen_device_pdo_t;

typedef struct { // PDO mapping of a device whose settings change it.
    const canopen_device_profile_t* class_profile;
    /// Profile of the class with the mapping that the settings define.
    canopen_device_profile_t profile;
    canopen_profile_pdo_t earlier[PROFILE_PDOS_MAX]; ///< Receive PDOs of the previous configuration.
} canopen_mapping_t;

typedef struct { // axes may be used as axis.h says; all else is read-only outside.
    const canopen_device_profile_t* profile; ///< Profile of the class, or the one in `mapping`.
    canopen_mapping_t* mapping;              ///< NULL: PDOs are mapped as in the class.
    canopen_master_t* master;
    uint8_t node;   ///< Node id.
    uint8_t index;  ///< Index in master->nodes.
    uint32_t boots; ///< Number of boot-up messages counted when the device was last commissioned.
    canopen_cia402_axis_t axes[PROFILE_AXES_MAX];
    canopen_device_pdo_t transmit[PROFILE_PDOS_MAX];
    canopen_device_pdo_t receive[PROFILE_PDOS_MAX];
    uint32_t values[PROFILE_VALUES_MAX]; ///< Bits of each value of the profile.
    canopen_setting_t identify[DEVICE_IDENTIFY_MAX];
    uint32_t malformed; ///< Process data of a wrong length, dropped [frames, wraps].
    uint8_t identified; ///< Steps of the identification that have ended.
    bool is_followed;   ///< The settings have been written, and the PDOs have been changed accordingly.
    uint8_t cleared;    ///< Number of receive PDOs whose values are set to zero, or need not be set.
    canopen_setting_run_t run;
} canopen_device_t;

/// Register the device with the master. STATUS_OK, STATUS_EXISTS (node), STATUS_EXHAUSTED, STATUS_INVALID
/// (node id).
MUST_USE status_t canopen_device_attach(canopen_device_t* device, canopen_master_t* master,
                                        const canopen_device_profile_t* profile, uint8_t node);
/// From now on, settings of mapping objects change the process data of the device; `mapping` stores them
/// and must outlive the device. Without this call, settings are written to the device but its process data
/// remain those of the class.
void canopen_device_follow_mapping(canopen_device_t* device, canopen_mapping_t* mapping);
/// Set the device object to the defaults of its profile, as the device itself does at its boot-up.
void canopen_device_reset(canopen_device_t* device);

/// Start to identify the device; continue with canopen_device_identify_step.
void canopen_device_identify(canopen_device_t* device);
/// Returns STATUS_BUSY; STATUS_OK: type, identity, units and mapping are those of the profile, and the torque
/// units of the axes are known; otherwise statuses of canopen_setting_run_step, and run.position is the
/// access that failed.
status_t canopen_device_identify_step(canopen_device_t* device);
/// Start to write settings; continue with canopen_device_configure_step. All values of the next process
/// data become zero. In the device, torque offsets and values that the process data no longer contain are
/// set to zero. Statuses as canopen_setting_run_step, and run.position is the access that failed.
void canopen_device_configure(canopen_device_t* device, canopen_setting_t* settings, uint16_t count);
status_t canopen_device_configure_step(canopen_device_t* device);

/// Receive process data from now on. STATUS_OK, STATUS_EXISTS (an identifier that is received already),
/// STATUS_EXHAUSTED. After a failure, canopen_device_disconnect removes what was connected.
MUST_USE status_t canopen_device_connect(canopen_device_t* device);
void canopen_device_disconnect(canopen_device_t* device);
/// Returns value number `value` of the profile, as received or set last, in its unit. NaN if the value is not
/// valid: the device has sent a REAL32 that is NaN or infinite.
double canopen_device_value(const canopen_device_t* device, uint8_t value);
/// Set a value of the next process data, rounded to the nearest finite value that its object can hold; 0 for
/// NaN.
void canopen_device_set_value(canopen_device_t* device, uint8_t value, double wanted);
/// Set all values of the next process data to 0.
void canopen_device_clear_outputs(canopen_device_t* device);
/// Send the process data that exist.
void canopen_device_emit(canopen_device_t* device);

/// True if each PDO that is sent at every SYNC was received at least once.
bool canopen_device_is_heard(const canopen_device_t* device);
/// Of the PDOs that the device sends at every SYNC, finds the one that arrived least recently. Returns the
/// number of SYNCs that were sent since then; 0 if all have arrived.
uint32_t canopen_device_silence(const canopen_device_t* device);

#endif // FSW_CANOPEN_DEVICE_H
