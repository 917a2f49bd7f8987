// SPDX-License-Identifier: Apache-2.0
/// Writes the devices and buses that are not part of the plant to the truth log: drives on benches,
/// instruments, power units, buses.
///
/// Ownership  The caller provides device_log_t, with zero in its private part; the objects to which it points
///            must exist as long as it does.
#ifndef SIM_APP_DEVICE_LOG_H
#define SIM_APP_DEVICE_LOG_H

#include "sim/app/devices.h"
#include "sim/app/instrument_set.h"
#include "sim/app/segment.h"
#include "sim/truth/truth.h"

#include <stdint.h>

#define DEVICE_LOG_SUPPLIES_MAX (WORLD_POWER_UNITS_MAX * WORLD_SUPPLIES_MAX)

typedef struct {
    const world_t* world;
    const devices_t* devices;
    const instrument_set_t* instruments; ///< Null: there are none.
    const segment_t* segments;
    unsigned bus_count;
    // The rest is private.
    size_t supply[DEVICE_LOG_SUPPLIES_MAX]; // Indices of the devices that power units supply.
    unsigned supply_count;
    uint64_t next_ns;                      // Time at which the present interval of TRUTH_INTERVAL_NS ends.
    uint64_t busy_ns[SIMULATOR_BUSES_MAX]; // Sums since the start, at the end of the last interval.
    uint64_t frames[SIMULATOR_BUSES_MAX];
    uint64_t errors[SIMULATOR_BUSES_MAX];
    double load[SIMULATOR_BUSES_MAX]; // Load during the last interval, 0 to 1.
    // `state`, `off` and `plugged` are those of truth_buses_t, at the last step.
    int32_t state[SIMULATOR_BUSES_MAX];
    uint32_t off[SIMULATOR_BUSES_MAX];
    bool plugged[SIMULATOR_BUSES_MAX];
} device_log_t;

/// Write the names of devices and buses; call it once, before device_log_state. Returns STATUS_OK or
/// STATUS_IO.
status_t device_log_names(truth_t* log, device_log_t* device_log);
/// Write the state after a step. Returns STATUS_OK or STATUS_IO.
status_t device_log_state(truth_t* log, device_log_t* device_log, uint64_t now_ns);

#endif // SIM_APP_DEVICE_LOG_H
