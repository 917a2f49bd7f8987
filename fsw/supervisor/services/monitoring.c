// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/services/monitoring.h"

#include "fsw/framework/subsystem/optional_services.h"
#include "fsw/supervisor/supervisor_internal.h"

#define OWN 0x8000U // Marks a handle of the supervisor's own parameters.

/// True if a descriptor of the mission defines a parameter.
static bool is_described(supervisor_t* const supervisor, const uint32_t parameter_id)
{
    const telemetry_cache_sizes_t sizes =
        supervisor_telemetry_directory_sizes(&supervisor->spacecraft.directory);
    uint16_t size = 0U;
    return sizes.size_of(sizes.context, parameter_id, &size) == STATUS_OK;
}

/// True if a reported value is current: its subsystem runs, sends reports and has parameters, and still
/// reports this one.
static bool is_valid(supervisor_t* const supervisor, const registry_entry_t* const entry,
                     const uint32_t parameter_id)
{
    const uint64_t time_ns = subsystem_process(&supervisor->subsystem)->epoch_ns + supervisor->now_ns;
    return (entry->process == PROCESS_RUNNING) && (entry->state != STATE_OFFLINE) &&
           !supervisor_doubt_exists(entry) &&
           !supervisor_telemetry_cache_is_old(&supervisor->spacecraft.cache, parameter_id, time_ns);
}

static bool has_value(supervisor_t* const supervisor, const uint32_t parameter_id)
{
    const registry_entry_t* const entry = supervisor_registry_find(supervisor, PARAMETER_APID(parameter_id));
    const uint8_t* octets               = NULL;
    uint16_t size                       = 0U;
    return (entry != NULL) && is_valid(supervisor, entry, parameter_id) &&
           (supervisor_telemetry_cache_value(&supervisor->spacecraft.cache, parameter_id, &octets, &size) ==
            STATUS_OK);
}

static status_t find(void* const context, const uint32_t parameter_id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    supervisor_t* const supervisor = context;
    if (PARAMETER_APID(parameter_id) == SUPERVISOR_APID) {
        const pus_parameter_port_t own = subsystem_parameter_port(&supervisor->subsystem);
        const status_t status          = own.find(own.context, parameter_id, out_handle, out_size);
        *out_handle                    = (uint16_t)(*out_handle | OWN);
        return status;
    }
    const pus_parameter_port_t others = supervisor_telemetry_cache_port(&supervisor->spacecraft.cache);
    if (!is_described(supervisor, parameter_id) ||
        (others.find(others.context, parameter_id, out_handle, out_size) != STATUS_OK)) {
        return STATUS_NOT_FOUND;
    }
    return has_value(supervisor, parameter_id) ? STATUS_OK : STATUS_EMPTY;
}

static void read(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    supervisor_t* const supervisor  = context;
    const bool is_own               = (handle & OWN) != 0U;
    const pus_parameter_port_t port = is_own ? subsystem_parameter_port(&supervisor->subsystem)
                                             : supervisor_telemetry_cache_port(&supervisor->spacecraft.cache);
    port.read(port.context, (uint16_t)(handle & ~OWN & UINT16_MAX), writer);
}

pus_parameter_port_t spacecraft_watched(void* const self)
{
    return (pus_parameter_port_t){.context = self, .find = find, .read = read};
}
