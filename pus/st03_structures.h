// SPDX-License-Identifier: Apache-2.0
/// Private part of ST[03]: report structures are put together in the service's candidate, so that a request
/// that fails leaves nothing behind. Functions that judge return a failure with code PUS_FAILURE_NONE if all
/// is well.
#ifndef PUS_ST03_STRUCTURES_H
#define PUS_ST03_STRUCTURES_H

#include "pus/st03_housekeeping.h"

#define HK_ID_SIZE 2U ///< Structure id before the values of a report [octets].

/// Structure with this id, or null.
pus_hk_structure_t* hk_structure_of(const pus_hk_t* hk, uint16_t id);
/// Begin an empty candidate. Its verdict tells whether there may be such a structure; *out_place is where it
/// goes. After a failure nothing more is added, and the verdict stays.
void hk_candidate_begin(pus_hk_t* hk, uint16_t id, uint32_t interval, pus_hk_structure_t** out_place);
/// Begin with what a structure has already.
void hk_candidate_extend(pus_hk_t* hk, const pus_hk_structure_t* structure);
/// Add a simply commutated parameter. They come before the sets: sets already there move up by one entry.
void hk_candidate_add(pus_hk_t* hk, uint32_t parameter_id);
/// Open a set of `count` parameters, which follow by hk_candidate_add_to_set. `offset`: detail of a failure.
void hk_candidate_add_set(pus_hk_t* hk, uint16_t repetitions, uint8_t count, uint32_t offset);
void hk_candidate_add_to_set(pus_hk_t* hk, uint32_t parameter_id);
/// All that there is to add, `entries` parameters and sets, has been added: place the samples of the
/// candidate in a sample buffer. `offset`: detail of the failure if it was nothing.
void hk_candidate_lay_out(pus_hk_t* hk, unsigned entries, uint32_t offset);

#endif // PUS_ST03_STRUCTURES_H
