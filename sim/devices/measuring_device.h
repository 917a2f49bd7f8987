// SPDX-License-Identifier: Apache-2.0
/// A device that only measures: analogue inputs of CiA 404 (gyro.eds), or manufacturer-specific objects
/// (star-tracker.eds, pose-camera.eds).
///
/// Values     0x9130:01.. with digits 0x6132 and status 0x6150 (CiA 404), or 0x2100:01.. with 0x2101:01.. and
///            0x2102. An integer is the measured value times ten to the power of its digits; a REAL32 or
///            REAL64 is the value, also in 0x6130:01.. of CiA 404, with or instead of 0x9130.
/// Exposures  At each SYNC, or in each period. 0x2103 counts measurements. 0x2104:01, :02, if the data sheet
///            has them, stamp the exposure: SYNCs received in OPERATIONAL, time since the last of them [us].
/// Errors     Before the first measurement, and while an error other than over-temperature is present, values
///            do not change and the status is 1, not valid.
/// Ownership  measuring_device_create allocates, measuring_device_destroy frees.
#ifndef SIM_DEVICES_MEASURING_DEVICE_H
#define SIM_DEVICES_MEASURING_DEVICE_H

#include "base/status.h"
#include "sim/devices/node.h"

#include <stdbool.h>
#include <stdint.h>

#define MEASURING_VALUES_MAX 8U
#define MEASURING_DELAYED_MAX 16U ///< Measurements that wait for the end of their delay.

typedef struct {
    unsigned value_count;
    uint64_t period_ns; ///< 0: measures at each SYNC.
    uint64_t delay_ns;  ///< From the exposure to the value; less than MEASURING_DELAYED_MAX periods.
    uint64_t step_ns;   ///< Step of the simulation: numbers the measurements at SYNC.
    /// Measure now. `number` identifies the measurement, for its noise. False: the measurement failed.
    bool (*measure)(void* context, uint64_t number, double* out_values);
    void* context;
} measuring_config_t;

typedef struct measuring_device measuring_device_t;

/// Create a measuring device. Statuses of node_create.
MUST_USE status_t measuring_device_create(bus_t* bus, const char* eds_path, uint8_t node_id,
                                          const measuring_config_t* config, measuring_device_t** out_device,
                                          char error[EDS_ERROR_MAX]);
void measuring_device_destroy(measuring_device_t* device);
node_t* measuring_device_node(measuring_device_t* device);

/// Called after a step of the world that ended at `now_ns`: make the exposures that are due.
void measuring_device_end_step(measuring_device_t* device, uint64_t now_ns);
/// Set by a scenario: an error of the table in README.md appears or disappears.
void measuring_device_set_error(measuring_device_t* device, uint16_t code, bool is_present, uint64_t now_ns);

#endif // SIM_DEVICES_MEASURING_DEVICE_H
