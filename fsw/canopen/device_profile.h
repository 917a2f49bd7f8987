// SPDX-License-Identifier: Apache-2.0
/// Classes of CiA 402 devices: which objects their process data carry, and in which units.
///
/// Identity and default mapping of a device class are part of its interface, as its data sheet has them;
/// commissioning reads both back from each device and refuses one that differs. Node ids, modes and rates are
/// not part of this table.
#ifndef FSW_CANOPEN_DEVICE_PROFILE_H
#define FSW_CANOPEN_DEVICE_PROFILE_H

#include <stdbool.h>
#include <stdint.h>

#define PROFILE_AXES_MAX 2U
#define PROFILE_PDOS_MAX 2U ///< In each direction.
#define PROFILE_ENTRIES_MAX 4U
#define PROFILE_AXIS_STEP 0x800U ///< Objects of axis n lie n times this higher.

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t octets; ///< 2 or 4.
} canopen_profile_entry_t;

typedef struct {
    uint16_t cob_base; ///< Default identifier is this plus the node id.
    bool is_valid;     ///< Exists unless a setting says otherwise.
    bool is_each_sync; ///< Transmit PDO: comes with every SYNC, so that its absence shows a lost device.
    uint8_t entry_count;
    canopen_profile_entry_t entries[PROFILE_ENTRIES_MAX];
} canopen_profile_pdo_t;

typedef struct {
    const char* type;      ///< Word in descriptors.
    uint32_t device_type;  ///< Object 0x1000.
    uint32_t vendor_id;    ///< Object 0x1018:01; 0: none is assigned.
    uint32_t product_code; ///< Object 0x1018:02.
    uint8_t axis_count;
    double position_rad;    ///< Position unit [rad].
    double velocity_rad_s;  ///< Velocity unit [rad/s].
    uint8_t transmit_count; ///< PDOs that the device transmits.
    canopen_profile_pdo_t transmit[PROFILE_PDOS_MAX];
    uint8_t receive_count; ///< PDOs that the device receives.
    canopen_profile_pdo_t receive[PROFILE_PDOS_MAX];
} canopen_device_profile_t;

/// Profile of a class; null if there is none.
const canopen_device_profile_t* canopen_device_profile_find(const char* type);
/// Octets of all entries of a PDO together.
uint8_t canopen_device_profile_pdo_octets(const canopen_profile_pdo_t* pdo);

#endif // FSW_CANOPEN_DEVICE_PROFILE_H
