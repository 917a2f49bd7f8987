// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/statistics_service.h"

#include "base/assertion.h"
#include "fsw/framework/subsystem/optional_services.h"

#define SAMPLING_NS 1000000U

static status_t restore(void* const self, const uint32_t key, const uint8_t* const octets, const size_t size)
{
    return pus_statistics_restore(self, key, octets, size);
}

/// The period of a cycle depends on the configuration, so sampling intervals are counted in time, not in
/// cycles.
static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    (void)cycle;
    pus_statistics_step(self, now_ns, (uint32_t)(now_ns / SAMPLING_NS));
}

void subsystem_statistics_service_add(subsystem_t* const subsystem, statistics_service_t* const service,
                                      const statistics_room_t* const room)
{
    FSW_ASSERT((subsystem != NULL) && (service != NULL) && (room != NULL));
    const pus_statistics_config_t config = {.process     = subsystem_process(subsystem),
                                            .parameters  = subsystem_parameter_port(subsystem),
                                            .persistence = subsystem_persistence(subsystem),
                                            .statistics  = room->statistics,
                                            .due         = room->due,
                                            .positions   = room->positions,
                                            .capacity    = room->capacity,
                                            .cycle_ns    = SAMPLING_NS};
    pus_statistics_init(&service->statistics, &config);
    pus_service_t entry = pus_statistics_service(&service->statistics);
    entry.step          = step;
    subsystem_add_service(subsystem, &entry, restore);
}
