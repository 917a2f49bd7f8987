// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/subsystem/subsystem_core.h"

#include "base/assertion.h"

void subsystem_health(const subsystem_t* const subsystem, subsystem_health_t* const out_health)
{
    FSW_ASSERT((subsystem != NULL) && (out_health != NULL));
    const parameter_refusals_t* const parameters = &subsystem->dictionary.refusals;
    *out_health                                  = (subsystem_health_t){
                                         .pool_peak        = subsystem->call_tokens.stats.peak,
                                         .pool_refused     = subsystem->call_tokens.stats.refused,
                                         .requests_refused = subsystem->dispatcher.counters.rejected + subsystem->dispatcher.counters.refused +
                                                             subsystem->dispatcher.counters.ignored,
                                         .parameters_refused = parameters->unknown + parameters->read_only + parameters->out_of_range +
                                                               parameters->malformed + parameters->no_room,
                                         .events_suppressed    = subsystem->events.counters.suppressed,
                                         .events_refused       = subsystem->events.counters.refused,
                                         .housekeeping_dropped = subsystem->housekeeping.counters.dropped,
                                         .reports_lost         = subsystem->process.counters.lost + subsystem->process.counters.oversized +
                                                         subsystem->loop_reports_lost};
}
