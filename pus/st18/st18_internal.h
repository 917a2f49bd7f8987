// SPDX-License-Identifier: Apache-2.0
/// Parts of ST[18] that its files share. Internal to pus/.
#ifndef PUS_ST18_ST18_INTERNAL_H
#define PUS_ST18_ST18_INTERNAL_H

#include "pus/st18/st18_procedures.h"

// ---- Loaded procedures and their records (st18_loading.c) ----

/// Find a loaded procedure. Null if there is none.
pus_procedure_t* procedures_find(const pus_procedures_t* self, const uint8_t* id);
/// Load code from a request or a file.
pus_failure_t procedures_load(pus_procedures_t* self, const uint8_t* id, octet_reader_t* code);
pus_failure_t procedures_load_file(pus_procedures_t* self, const uint8_t* id, const pus_file_name_t* name);
pus_failure_t procedures_unload(pus_procedures_t* self, pus_procedure_t* procedure);
pus_failure_t procedures_save_engine(pus_procedures_t* self, bool is_stopped);
/// First four octets of an id, for failure notices.
uint32_t procedures_detail(const uint8_t* id);

// ---- Running (st18_running.c) ----

/// Begin an inactive procedure. `arguments` as in TC[18,3], well-formed.
pus_reply_t procedures_activate(pus_procedures_t* self, const pus_request_t* request,
                                pus_procedure_t* procedure, const uint8_t* arguments, size_t size);
/// Run of an active procedure.
pus_procedure_run_t* procedures_run_of(const pus_procedures_t* self, const pus_procedure_t* procedure);
/// End an active procedure; `what` is PUS_OBSERVED_STOPPED or _ABORTED.
void procedures_end(pus_procedures_t* self, pus_procedure_t* procedure, pus_observation_t what);
/// Raise the observation event if the observability level of the procedure is `level` or higher.
void procedures_report(const pus_procedures_t* self, const pus_procedure_t* procedure,
                       pus_observability_t level, pus_observation_t what, uint32_t detail);

#endif // PUS_ST18_ST18_INTERNAL_H
