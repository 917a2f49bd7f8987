// SPDX-License-Identifier: Apache-2.0
/// Private to ST[18]: functions that its files share.
#ifndef PUS_ST18_ST18_INTERNAL_H
#define PUS_ST18_ST18_INTERNAL_H

#include "pus/st18/st18_procedures.h"

// ---- Loaded procedures and their records (st18_loading.c) ----

/// Returns the loaded procedure with this id, or null.
pus_procedure_t* procedures_find(const pus_procedures_t* self, const uint8_t* id);
/// Load code from a request or from a file.
pus_failure_t procedures_load(pus_procedures_t* self, const uint8_t* id, octet_reader_t* code);
pus_failure_t procedures_load_file(pus_procedures_t* self, const uint8_t* id, const pus_file_name_t* name);
/// Delete a procedure and its records.
pus_failure_t procedures_unload(pus_procedures_t* self, pus_procedure_t* procedure);
/// Store whether the engine is stopped.
pus_failure_t procedures_save_engine(pus_procedures_t* self, bool is_stopped);
/// Returns the first four octets of an id, for failure notices.
uint32_t procedures_detail(const uint8_t* id);

// ---- Running (st18_running.c) ----

/// Begin an inactive procedure. `arguments` have the layout of TC[18,3] and are well-formed.
pus_reply_t procedures_activate(pus_procedures_t* self, const pus_request_t* request,
                                pus_procedure_t* procedure, const uint8_t* arguments, size_t size);
/// Returns the run of an active procedure.
pus_procedure_run_t* procedures_run_of(const pus_procedures_t* self, const pus_procedure_t* procedure);
/// End an active procedure; `what` is PUS_OBSERVED_STOPPED or _ABORTED.
void procedures_end(pus_procedures_t* self, pus_procedure_t* procedure, pus_observation_t what);
/// Raise the observation event if the observability level of the procedure is `level` or higher.
void procedures_report(const pus_procedures_t* self, const pus_procedure_t* procedure,
                       pus_observability_t level, pus_observation_t what, uint32_t detail);

#endif // PUS_ST18_ST18_INTERNAL_H
