// SPDX-License-Identifier: Apache-2.0
#include "sim/app/device_log.h"

#include <string.h>

// ---- Names ----

static status_t write_names(truth_t* const log, const char* const channel, const unsigned count,
                            const char* const* const name)
{
    const truth_names_t names = {.count = count, .name = name};
    return (count > 0U) ? truth_names(log, 0U, channel, &names) : STATUS_OK;
}

static status_t name_benches(truth_t* const log, const world_t* const world)
{
    const char* name[WORLD_BENCHES_MAX];
    for (size_t i = 0U; i < world->bench_count; i++) {
        name[i] = world->bench[i].device.name;
    }
    return write_names(log, "BENCH", (unsigned)world->bench_count, name);
}

static status_t name_instruments(truth_t* const log, const instrument_set_t* const instruments)
{
    const char* name[WORLD_INSTRUMENTS_MAX];
    const size_t count = instrument_set_count(instruments);
    for (size_t i = 0U; i < count; i++) {
        name[i] = instrument_set_name(instruments, i);
    }
    return write_names(log, "INSTRUMENT", (unsigned)count, name);
}

static void find_supplies(device_log_t* const device_log, const world_power_unit_t* const unit)
{
    for (size_t i = 0U; i < unit->supply_count; i++) {
        for (size_t k = 0U; k < devices_count(device_log->devices); k++) {
            if (strcmp(device_entry(device_log->devices, k)->name, unit->supply[i]) == 0) {
                device_log->supply[device_log->supply_count] = k;
                device_log->supply_count++;
            }
        }
    }
}

static status_t name_supplies(truth_t* const log, const device_log_t* const device_log)
{
    const char* name[DEVICE_LOG_SUPPLIES_MAX];
    for (unsigned i = 0U; i < device_log->supply_count; i++) {
        name[i] = device_entry(device_log->devices, device_log->supply[i])->name;
    }
    return write_names(log, "POWER", device_log->supply_count, name);
}

status_t device_log_names(truth_t* const log, device_log_t* const device_log)
{
    const char* name[SIMULATOR_BUSES_MAX];
    for (unsigned i = 0U; i < device_log->bus_count; i++) {
        name[i] = device_log->segments[i].name;
    }
    for (size_t i = 0U; i < device_log->world->power_unit_count; i++) {
        find_supplies(device_log, &device_log->world->power_unit[i]);
    }
    status_t status = name_benches(log, device_log->world);
    status          = (status == STATUS_OK) ? name_instruments(log, device_log->instruments) : status;
    status          = (status == STATUS_OK) ? name_supplies(log, device_log) : status;
    return (status == STATUS_OK) ? write_names(log, "BUS", device_log->bus_count, name) : status;
}

// ---- State ----

static status_t log_benches(truth_t* const log, const devices_t* const devices, const uint64_t now_ns)
{
    double position[WORLD_BENCHES_MAX];
    double velocity[WORLD_BENCHES_MAX];
    double torque[WORLD_BENCHES_MAX];
    truth_benches_t benches = {
        .position_rad = position, .velocity_rad_s = velocity, .output_torque_nm = torque};
    for (size_t i = 0U; i < devices_count(devices); i++) {
        const motor_bench_t* bench = device_bench(devices, i);
        if (bench != NULL) {
            position[benches.count] = bench->rotor.position_rad;
            velocity[benches.count] = bench->rotor.velocity_rad_s;
            torque[benches.count]   = bench->output_torque_nm;
            benches.count++;
        }
    }
    return (benches.count > 0U) ? truth_benches(log, now_ns, &benches) : STATUS_OK;
}

static status_t log_instruments(truth_t* const log, const instrument_set_t* const instruments,
                                const uint64_t now_ns)
{
    double value[WORLD_INSTRUMENTS_MAX];
    bool enabled[WORLD_INSTRUMENTS_MAX];
    bool plugged[WORLD_INSTRUMENTS_MAX];
    const truth_instruments_t all = {.count   = (unsigned)instrument_set_count(instruments),
                                     .value   = value,
                                     .enabled = enabled,
                                     .plugged = plugged};
    for (unsigned i = 0U; i < all.count; i++) {
        const instrument_t* instrument = instrument_set_at(instruments, i);
        value[i]                       = instrument_value(instrument);
        enabled[i]                     = instrument_is_enabled(instrument);
        plugged[i]                     = instrument_is_plugged(instrument);
    }
    return (all.count > 0U) ? truth_instruments(log, now_ns, &all) : STATUS_OK;
}

static status_t log_power(truth_t* const log, const device_log_t* const device_log, const uint64_t now_ns)
{
    bool supplied[DEVICE_LOG_SUPPLIES_MAX];
    for (unsigned i = 0U; i < device_log->supply_count; i++) {
        supplied[i] = node_is_powered(device_model(device_log->devices, device_log->supply[i])->node);
    }
    return (device_log->supply_count > 0U) ? truth_power(log, now_ns, supplied, device_log->supply_count)
                                           : STATUS_OK;
}

/// Compute load, frames and errors of the buses for the interval that has ended.
static void end_interval(device_log_t* const device_log, const uint64_t now_ns)
{
    for (unsigned i = 0U; i < device_log->bus_count; i++) {
        const bus_statistics_t* statistics = bus_statistics(device_log->segments[i].bus);
        const double busy_ns               = (double)(statistics->busy_ns - device_log->busy_ns[i]);
        device_log->load[i]                = busy_ns / (double)TRUTH_INTERVAL_NS;
        device_log->busy_ns[i]             = statistics->busy_ns;
        device_log->frames[i]              = statistics->frames;
        device_log->errors[i]              = statistics->errors;
    }
    device_log->next_ns = now_ns + TRUTH_INTERVAL_NS;
}

/// Read the controllers of the buses. True if one has changed since the last step.
static bool read_controllers(device_log_t* const device_log)
{
    bool is_changed = false;
    for (unsigned i = 0U; i < device_log->bus_count; i++) {
        const bus_t* bus      = device_log->segments[i].bus;
        const unsigned flight = device_log->segments[i].flight_node;
        const bool has_flight = flight < BUS_NODES_MAX;
        const int32_t state   = has_flight ? (int32_t)bus_controller(bus, flight)->state : -1;
        const bool is_plugged = has_flight && bus_is_plugged(bus, flight);
        const uint32_t off    = bus_off_count(bus);
        is_changed = is_changed || (state != device_log->state[i]) || (off != device_log->off[i]) ||
                     (is_plugged != device_log->plugged[i]);
        device_log->state[i]   = state;
        device_log->off[i]     = off;
        device_log->plugged[i] = is_plugged;
    }
    return is_changed;
}

static status_t log_buses(truth_t* const log, device_log_t* const device_log, const uint64_t now_ns)
{
    const truth_buses_t buses = {.count   = device_log->bus_count,
                                 .load    = device_log->load,
                                 .frames  = device_log->frames,
                                 .errors  = device_log->errors,
                                 .state   = device_log->state,
                                 .off     = device_log->off,
                                 .plugged = device_log->plugged};
    const bool is_changed     = read_controllers(device_log);
    if (buses.count == 0U) {
        return STATUS_OK;
    }
    if (now_ns >= device_log->next_ns) {
        end_interval(device_log, now_ns);
    } else if (!is_changed) {
        return truth_buses_again(log, now_ns);
    } else {
        // A controller has changed within the interval.
    }
    return truth_buses(log, now_ns, &buses);
}

status_t device_log_state(truth_t* const log, device_log_t* const device_log, const uint64_t now_ns)
{
    status_t status = log_benches(log, device_log->devices, now_ns);
    status          = (status == STATUS_OK) ? log_instruments(log, device_log->instruments, now_ns) : status;
    status          = (status == STATUS_OK) ? log_power(log, device_log, now_ns) : status;
    return (status == STATUS_OK) ? log_buses(log, device_log, now_ns) : status;
}
