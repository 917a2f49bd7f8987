// SPDX-License-Identifier: Apache-2.0
/// Private to ST[03]: a structure is first assembled as the candidate of the service, so that a failed
/// request changes no structure.
#ifndef PUS_ST03_ST03_STRUCTURES_H
#define PUS_ST03_ST03_STRUCTURES_H

#include "pus/st03/st03_housekeeping.h"

#define HK_ID_SIZE 2U ///< Size of the structure id before the values of a report [octets].

/// Returns the structure of this kind with this id, or null.
pus_hk_structure_t* hk_structure_of(const pus_hk_t* hk, bool is_diagnostic, uint16_t id);
/// Begin an empty candidate; *out_slot is the structure that it will become. `verdict` is the failure if
/// such a structure is not possible. After a failure, additions have no effect and `verdict` does not change.
void hk_candidate_begin(pus_hk_t* hk, bool is_diagnostic, uint16_t id, uint32_t interval,
                        pus_hk_structure_t** out_slot);
/// Begin a candidate with the contents of an existing structure.
void hk_candidate_extend(pus_hk_t* hk, const pus_hk_structure_t* structure);
/// Add a simply commutated parameter. It is placed before the sets, which move up by one entry.
void hk_candidate_add(pus_hk_t* hk, uint32_t parameter_id);
/// Open a set of `count` parameters; hk_candidate_add_to_set then adds each. `offset`: detail of a failure.
void hk_candidate_add_set(pus_hk_t* hk, uint16_t repetitions, uint8_t count, uint32_t offset);
void hk_candidate_add_to_set(pus_hk_t* hk, uint32_t parameter_id);
/// Assign offsets in the sample buffer. Called after the last addition; `entries` is the number of parameters
/// and sets added. If it is 0, the candidate fails with detail `offset`.
void hk_candidate_lay_out(pus_hk_t* hk, unsigned entries, uint32_t offset);

/// Copy the candidate to the structure `slot` if there was no failure.
void hk_candidate_settle(const pus_hk_t* hk, pus_hk_structure_t* slot);

/// Lock and unlock `mutex`, so that no other loop samples while structures change.
void hk_lock(const pus_hk_t* hk);
void hk_unlock(const pus_hk_t* hk);
/// Enable or disable periodic generation; an interval begins with the next step.
void hk_set_periodic(pus_hk_structure_t* structure, bool is_periodic);
/// Shortest interval that a structure may have: the largest repetition number of its sets.
uint32_t hk_interval_min(const pus_hk_structure_t* structure);
/// Answer a request with a report of the present values of a structure.
void hk_sample_now(pus_hk_t* hk, const pus_hk_structure_t* structure, pus_request_t* request);
/// st03_requests.c: entry of the service for a dispatcher, without its step.
pus_service_t hk_requests(pus_hk_t* hk);

/// st03_functional.c: TC[3,37] to [3,44].
pus_reply_t hk_functional_apply(void* self, pus_request_t* request);
pus_reply_t hk_functional_create(void* self, pus_request_t* request);
pus_reply_t hk_functional_delete(void* self, pus_request_t* request);
pus_reply_t hk_functional_report(void* self, pus_request_t* request);
pus_reply_t hk_functional_add(void* self, pus_request_t* request);
pus_reply_t hk_functional_remove(void* self, pus_request_t* request);
pus_reply_t hk_functional_modify(void* self, pus_request_t* request);

#endif // PUS_ST03_ST03_STRUCTURES_H
