// SPDX-License-Identifier: Apache-2.0
/// Private to ST[12]: functions that its files share.
#ifndef PUS_ST12_ST12_INTERNAL_H
#define PUS_ST12_ST12_INTERNAL_H

#include "pus/core/list_report.h"
#include "pus/st12/st12_monitoring.h"

#define MONITORING_PMON_RECORD 0U ///< Kinds of records, in the high half of their keys.
#define MONITORING_FMON_RECORD 1U
#define MONITORING_SETTINGS_RECORD 2U
#define MONITORING_RECORD_MAX 640U    ///< Largest record [octets]: an FMON of 255 members.
#define MONITORING_PMON_MAX 96U       ///< Largest entry of TM[12,9] [octets].
#define MONITORING_TRANSITION_MAX 48U ///< Largest entry of TM[12,11] and TM[12,12] [octets].
#define MONITORING_PMON_EVENT 16U     ///< Auxiliary data of the event of a PMON [octets].
#define MONITORING_FMON_EVENT 4U      ///< Auxiliary data of the event of an FMON [octets].

/// Source of a definition: TC[12,5] or [12,23], TC[12,7], or a record. The source determines which fields the
/// definition has.
typedef enum {
    MONITORING_FROM_ADD,
    MONITORING_FROM_MODIFY,
    MONITORING_FROM_RECORD
} monitoring_origin_t;

// ---- Definitions of parameter monitoring (st12_definitions.c) ----

/// Read a definition of a PMON. False: the parameter is not a scalar, or the check type is unknown.
bool monitoring_read_pmon(octet_reader_t* reader, monitoring_origin_t origin, pus_pmon_t* out_pmon);
/// Write a definition as in TM[12,9] and in a persistent record.
void monitoring_write_pmon(octet_writer_t* writer, const pus_pmon_t* pmon);
/// Write a transition as in TM[12,11] and TM[12,12].
void monitoring_write_transition(octet_writer_t* writer, const pus_check_transition_t* transition);
bool monitoring_read_validity(octet_reader_t* reader, pus_validity_t* out_validity);
void monitoring_write_validity(octet_writer_t* writer, const pus_validity_t* validity);
/// Check a definition: its values, its events and, if it comes from a request, its parameters. `offset`:
/// octet offset of the definition, for the failure.
pus_failure_t monitoring_check_pmon(const pus_monitoring_t* self, monitoring_origin_t origin,
                                    pus_pmon_t* pmon, uint32_t offset);
pus_failure_t monitoring_check_validity(const pus_monitoring_t* self, monitoring_origin_t origin,
                                        pus_validity_t* validity, uint32_t offset);
pus_failure_t monitoring_check_event(const pus_monitoring_t* self, uint16_t event_id, size_t size);

// ---- Tables and records (st12_monitoring.c) ----

/// Returns the PMON with this id, or null.
pus_pmon_t* monitoring_pmon(const pus_monitoring_t* self, uint16_t id);
/// Store or erase a record. PUS_FAILURE_NONE or PUS_FAILURE_IO.
pus_failure_t monitoring_save(pus_monitoring_t* self, uint32_t kind, uint16_t id, const uint8_t* octets,
                              size_t size);
pus_failure_t monitoring_forget(pus_monitoring_t* self, uint32_t kind, uint16_t id);
pus_failure_t monitoring_save_settings(pus_monitoring_t* self, bool is_enabled, bool is_functional,
                                       uint32_t reporting_delay);
/// Returns PUS_DONE if there is no failure; otherwise counts the failure and returns PUS_REFUSED with it.
pus_reply_t monitoring_reply(pus_monitoring_t* self, const pus_failure_t* failure);
/// Perform an instruction if there is no failure; otherwise refuse it and count the refusal.
void monitoring_settle(pus_monitoring_t* self, pus_request_t* request, uint16_t instruction,
                       const pus_failure_t* failure);
typedef pus_failure_t (*monitoring_act_t)(pus_monitoring_t* self, uint16_t id);
/// Apply a function to each id of a request.
pus_reply_t monitoring_for_each(pus_monitoring_t* self, pus_request_t* request, monitoring_act_t act);
/// Check the ids of a request for reports: refuse each id that `look_up` does not find, and perform the other
/// ids. A request without ids asks for all definitions. False if there is nothing to report.
bool monitoring_accept_ids(pus_monitoring_t* self, pus_request_t* request, monitoring_act_t look_up);
/// Returns the status of pus_monitoring_restore for a failure of the checks of a record.
status_t monitoring_status(const pus_failure_t* failure);

// ---- Checking (st12_checks.c) ----

/// True if the validity condition is met.
bool monitoring_is_valid(const pus_monitoring_t* self, const pus_validity_t* validity);
/// Check a PMON from the next cycle on, if the PMON and the monitoring function are enabled.
void monitoring_schedule(pus_monitoring_t* self, const pus_pmon_t* pmon);
/// Stop checking a PMON; its status becomes unchecked.
void monitoring_uncheck(pus_monitoring_t* self, pus_pmon_t* pmon);

// ---- Functional monitoring (st12_functional.c) ----

/// Update the chains of FMON members that name the same PMON, if the definitions have changed.
void monitoring_link(pus_monitoring_t* self);
/// Mark the FMONs that name a PMON for evaluation.
void monitoring_touch(pus_monitoring_t* self, const pus_pmon_t* pmon);
/// Evaluate the FMONs that were marked.
void monitoring_evaluate_touched(pus_monitoring_t* self, uint64_t now_ns);
/// True if a protected FMON names the PMON.
bool monitoring_is_protected(pus_monitoring_t* self, const pus_pmon_t* pmon);
/// Restore an FMON from its record. Statuses of pus_monitoring_restore.
status_t monitoring_restore_fmon(pus_monitoring_t* self, octet_reader_t* reader);
pus_reply_t monitoring_enable_functional(void* self, pus_request_t* request);
pus_reply_t monitoring_disable_functional(void* self, pus_request_t* request);
pus_reply_t monitoring_enable_fmons(void* self, pus_request_t* request);
pus_reply_t monitoring_disable_fmons(void* self, pus_request_t* request);
pus_reply_t monitoring_protect_fmons(void* self, pus_request_t* request);
pus_reply_t monitoring_unprotect_fmons(void* self, pus_request_t* request);
pus_reply_t monitoring_add_fmons(void* self, pus_request_t* request);
pus_reply_t monitoring_delete_fmons(void* self, pus_request_t* request);
pus_reply_t monitoring_report_fmons(void* self, pus_request_t* request);
pus_reply_t monitoring_report_fmon_status(void* self, pus_request_t* request);

#endif // PUS_ST12_ST12_INTERNAL_H
