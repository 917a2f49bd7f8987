// SPDX-License-Identifier: Apache-2.0
/// ST[20] parameter management, all 7 messages: report and set values, define parameters by their place in
/// memory (st20_definitions.h, where that is configured; else TC[20,4] and [20,5] are refused with
/// PUS_FAILURE_ACCESS), and report definitions.
///
/// Each instruction is independent: an unknown, unreadable, read-only or out-of-range one is refused by
/// its own TM[1,4], the others are performed. TM[20,2] contains the values of all others; values beyond
/// the longest report of the process are refused (PUS_FAILURE_TABLE_FULL). If the report is longer than a
/// packet and there is no buffer, the request fails (PUS_FAILURE_IO, STATUS_FULL). In TC[20,3] the value of
/// an unknown id is skipped by the scalar type in the id's layout bits; if they name no type, the rest of the
/// request cannot be delimited and is refused as well.
#ifndef PUS_ST20_ST20_PARAMETERS_H
#define PUS_ST20_ST20_PARAMETERS_H

#include "pus/core/parameter_port.h"
#include "pus/core/service.h"
#include "pus/st20/st20_definitions.h"

#define PUS_PARAMETERS_REPORT 1U ///< Subtype of a request for values; the other sets them.

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_parameter_port_t port;
    pus_parameter_definitions_t* definitions; // Null: none can be made.
    struct {
        uint32_t read;    ///< Values reported.
        uint32_t set;     ///< Values set.
        uint32_t refused; ///< Instructions refused.
    } counters;
} pus_parameters_t;

void pus_parameters_init(pus_parameters_t* parameters, const pus_parameter_port_t* port);
/// From now on parameters may be defined by request; their port takes the place of the one given before.
void pus_parameters_define(pus_parameters_t* parameters, pus_parameter_definitions_t* definitions);
/// Restore a record. Statuses of pus_parameter_definitions_restore; STATUS_UNSUPPORTED (no definitions).
MUST_USE status_t pus_parameters_restore(pus_parameters_t* parameters, uint32_t key, const uint8_t* octets,
                                         size_t size);
pus_service_t pus_parameters_service(pus_parameters_t* parameters);

#endif // PUS_ST20_ST20_PARAMETERS_H
