// SPDX-License-Identifier: Apache-2.0
/// Classes of CANopen devices: what their process data carry, and in which units.
///
/// The classes are made at build time from the data sheets (EDS) in descriptors/devices; a class is named as
/// its file. Commissioning reads identity and mapping back from each device and refuses one that differs.
/// Node ids, modes and rates are not part of a class.
#ifndef FSW_CANOPEN_DEVICE_PROFILE_H
#define FSW_CANOPEN_DEVICE_PROFILE_H

#include "generated/device_classes.h"

#include "fsw/canopen/emergency.h"
#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PROFILE_AXES_MAX DEVICE_CLASSES_AXES_MAX
#define PROFILE_PDOS_MAX 4U ///< In each direction.
#define PROFILE_ENTRIES_MAX 8U
#define PROFILE_VALUES_MAX 16U
#define PROFILE_UNITS_MAX 6U ///< Objects that state the units of an axis.
/// Distance between the object indices of one axis and those of the next one (CiA 402).
#define PROFILE_AXIS_STEP 0x800U
#define PROFILE_NO_VALUE 0xFFU

#define PROFILE_DRIVE 402U ///< CiA 402; 401: input and output modules, 404: measuring devices.

typedef enum { // Kind of a mapped object: a word of an axis, or a value.
    PROFILE_PADDING,
    PROFILE_VALUE,
    PROFILE_STATUSWORD,
    PROFILE_POSITION,
    PROFILE_VELOCITY,
    PROFILE_TORQUE,
    PROFILE_CURRENT,
    PROFILE_CONTROLWORD,
    PROFILE_TARGET_POSITION,
    PROFILE_TORQUE_OFFSET,
    PROFILE_TARGET_TORQUE,
    PROFILE_TARGET_VELOCITY
} canopen_profile_word_t;

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t octets; ///< 1 to 4.
    canopen_profile_word_t word;
    uint8_t number; ///< Number of the axis to which a word belongs, or of a value.
} canopen_profile_entry_t;

typedef struct {
    uint16_t cob_base; ///< The default identifier is this number plus the node id.
    bool is_valid;     ///< The PDO exists unless a setting disables it.
    bool is_each_sync; ///< Transmit PDO: sent at every SYNC, so that its absence shows a lost device.
    uint8_t entry_count;
    canopen_profile_entry_t entries[PROFILE_ENTRIES_MAX];
} canopen_profile_pdo_t;

typedef struct { // An object that states a unit, and its value.
    uint16_t index;
    uint8_t subindex;
    uint8_t octets;
    uint32_t value;
} canopen_profile_unit_t;

typedef struct { // Units and limits of an axis.
    double position_rad;
    double velocity_rad_s;
    double low_rad; ///< Limits of positions (0x607D); both 0: none.
    double high_rad;
    double speed_rad_s; ///< Largest speed (0x6080, at the output of the gear); 0: not limited.
    bool has_torque;    ///< The device has a rated torque; torques are fractions of it.
    /// Default of the interpolation time period, 0x60C2: period x 10^period_exponent s. 0: no such object.
    uint8_t period;
    int8_t period_exponent;
    uint8_t unit_count;
    canopen_profile_unit_t units[PROFILE_UNITS_MAX];
} canopen_profile_axis_t;

typedef struct { // An object that the data sheet allows in process data.
    uint16_t index;
    uint8_t subindex;
    uint8_t octets;
    canopen_profile_word_t transmit; ///< Word of the object in a transmit PDO; PROFILE_PADDING: none.
    /// Word of the object in a receive PDO; PROFILE_PADDING: none, the object is not allowed there.
    canopen_profile_word_t receive;
    uint8_t axis;
    bool is_signed;
    bool is_real; ///< REAL32 of CiA 301, not an integer.
    double scale;
} canopen_profile_object_t;

typedef struct { // An object in the process data that is no word of an axis.
    uint16_t index;
    uint8_t subindex;
    uint8_t octets;
    bool is_signed;
    bool is_real; ///< REAL32 of CiA 301, not an integer.
    double scale; ///< Size of one unit, for example from the decimal digits of CiA 404; 1 if none is defined.
} canopen_profile_value_t;

typedef struct {
    const char* type;      ///< Name of the class in descriptors.
    uint64_t sheet_hash;   ///< FNV-1a of the data sheet.
    uint16_t profile;      ///< CiA number, the lower half of object 0x1000; 0: none.
    uint32_t device_type;  ///< Object 0x1000.
    uint32_t vendor_id;    ///< Object 0x1018:01; 0: none is assigned.
    uint32_t product_code; ///< Object 0x1018:02.
    uint8_t axis_count;
    canopen_profile_axis_t axes[PROFILE_AXES_MAX];
    uint8_t value_count;
    canopen_profile_value_t values[PROFILE_VALUES_MAX];
    uint8_t transmit_count; ///< PDOs that the device transmits.
    canopen_profile_pdo_t transmit[PROFILE_PDOS_MAX];
    uint8_t receive_count; ///< PDOs that the device receives.
    canopen_profile_pdo_t receive[PROFILE_PDOS_MAX];
    uint8_t object_count;
    const canopen_profile_object_t* objects; ///< Objects that may be mapped.
    uint8_t emergency_count;
    const canopen_emergency_code_t* emergencies; ///< Emergency codes of the manufacturer.
} canopen_device_profile_t;

typedef struct {                          // The classes of a program.
    const canopen_device_profile_t* rows; ///< In the order of names.
    size_t count;
    const char* refusal; ///< Message that lists the classes which the type of a <Device> may name.
} canopen_device_classes_t;

/// All classes (device_classes.c). A program whose descriptors are compiled in has only those that its
/// descriptors name: descriptor-compiler writes the table.
extern const canopen_device_classes_t canopen_device_classes;

/// Returns class number `position` (0..) in the order of names; null after the last one.
const canopen_device_profile_t* canopen_device_profile_at(size_t position);

/// Returns the profile of a class; null if there is no such class.
const canopen_device_profile_t* canopen_device_profile_find(const char* type);
/// Returns the number of the value of an object; PROFILE_NO_VALUE if the process data do not have it.
uint8_t canopen_device_profile_value(const canopen_device_profile_t* profile, uint16_t index,
                                     uint8_t subindex);
/// True if process data to the device carry the value.
bool canopen_device_profile_is_output(const canopen_device_profile_t* profile, uint8_t value);
/// True for the objects of PDO mappings, 0x1600 to 0x17FF and 0x1A00 to 0x1BFF.
bool canopen_device_profile_is_mapping(uint16_t index);
/// Apply a write of a communication or mapping parameter of a PDO (0x1400 to 0x1BFF) to the profile of one
/// device; a write of another object changes nothing. STATUS_OK; STATUS_FORBIDDEN (CiA 301 forbids the write
/// while the PDO exists, or while the number of entries is not 0); STATUS_NOT_FOUND (mapping: no such PDO, an
/// object that the data sheet does not allow there with this length, or a number of entries with an empty
/// one); STATUS_TOO_LARGE (entries, octets or values).
status_t canopen_device_profile_map(canopen_device_profile_t* profile, uint16_t index, uint8_t subindex,
                                    uint32_t value);
/// Returns the sum of the octets of all entries of a PDO.
uint8_t canopen_device_profile_pdo_octets(const canopen_profile_pdo_t* pdo);

#endif // FSW_CANOPEN_DEVICE_PROFILE_H
