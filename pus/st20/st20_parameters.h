// SPDX-License-Identifier: Apache-2.0
/// ST[20] parameter management, all 7 messages: report and set values, report definitions, and define
/// parameters by their address in memory (st20_definitions.h; if that is not configured, TC[20,4] and [20,5]
/// are refused with PUS_FAILURE_ACCESS).
///
/// Instructions are independent: an instruction with an unknown, unreadable or read-only parameter or a value
/// out of range is refused with its own TM[1,4], the others are performed. TM[20,2] contains the values of
/// the accepted instructions; values beyond the longest report of the process are refused
/// (PUS_FAILURE_TABLE_FULL). If the report is longer than a packet and there is no buffer, the request fails
/// (PUS_FAILURE_IO, STATUS_FULL). In TC[20,3] the layout bits of an unknown id give the size of its value,
/// which is skipped. If these bits are no scalar type, the rest of the request cannot be read and is refused,
/// too.
#ifndef PUS_ST20_ST20_PARAMETERS_H
#define PUS_ST20_ST20_PARAMETERS_H

#include "pus/core/parameter_port.h"
#include "pus/core/service.h"

#define PUS_PARAMETERS_REPORT 1U ///< Subtype of TC[20,1], which requests values.

/// Functions to define parameters by request, implemented by st20_definitions.h. Their `context` is that of
/// `port`.
typedef struct {
    pus_parameter_port_t port; ///< Port to all parameters.
    /// Read one instruction of TC[20,4], or [20,5] if `is_object`, and perform it.
    pus_failure_t (*define)(void* context, octet_reader_t* reader, bool is_object);
    /// Get the memory address of a parameter that was defined by request. For other parameters the outputs do
    /// not change.
    void (*locate)(const void* context, uint32_t id, uint8_t* out_memory_id, uint32_t* out_address);
    /// Restore a record. STATUS_OK, STATUS_INVALID (no such record), STATUS_NOT_FOUND (its memory),
    /// STATUS_EXHAUSTED.
    status_t (*restore)(void* context, uint32_t key, const uint8_t* octets, size_t size);
} pus_parameter_definer_t;

typedef struct { // Type of a parameter in the terms of PUS.
    uint8_t ptc;
    uint16_t pfc;
} pus_parameter_code_t;

typedef struct {                     // Private, except `counters`: read-only, for telemetry.
    pus_parameter_definer_t definer; // Its functions are null if parameters cannot be defined by request.
    struct {
        uint32_t read;    ///< Values reported.
        uint32_t set;     ///< Values set.
        uint32_t refused; ///< Instructions refused.
    } counters;
} pus_parameters_t;

void pus_parameters_init(pus_parameters_t* parameters, const pus_parameter_port_t* port);
/// From now on parameters may be defined by request; the port of `definer` replaces the port of
/// pus_parameters_init.
void pus_parameters_define(pus_parameters_t* parameters, const pus_parameter_definer_t* definer);
/// PTC and PFC of the type in the layout bits of an id; for a structure or an array those of an octet string.
pus_parameter_code_t pus_parameter_code_of(uint32_t id);
/// Restore a record. Statuses of `restore` of the definer; STATUS_UNSUPPORTED (parameters cannot be defined
/// by request).
MUST_USE status_t pus_parameters_restore(pus_parameters_t* parameters, uint32_t key, const uint8_t* octets,
                                         size_t size);
pus_service_t pus_parameters_service(pus_parameters_t* parameters);

#endif // PUS_ST20_ST20_PARAMETERS_H
