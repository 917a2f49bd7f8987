// SPDX-License-Identifier: Apache-2.0
/// A medium whose writes since the last commit of the checkpoint can be undone: before each write, the octets
/// that it overwrites are saved in an annex of the checkpoint. When the next life opens the medium, its
/// content is that of the last commit. For a write beyond the end, only the old size is saved. Three kinds of
/// octets are not saved: those that a truncation by more than UNDO_CUT_MAX removes (the content of a
/// medium that is emptied is no longer needed), those for which the annex has no room, and those that cannot
/// be read; the write is performed nevertheless.
///
/// Ownership  The caller provides undo_medium_t.
/// Context    One loop.
/// Time       A read of the octets that are overwritten.
#ifndef FSW_SUPERVISOR_UNDO_H
#define FSW_SUPERVISOR_UNDO_H

#include "base/medium.h"
#include "fsw/supervisor/checkpoint.h"

#include <stdint.h>

#define UNDO_CUT_MAX 65536U

typedef struct { // Private.
    medium_t inner;
    checkpoint_t* checkpoint;
    uint8_t number;
} undo_medium_t;

/// Undo the writes to `inner` that the last life made after its last commit, and return the medium whose
/// writes can be undone. `number` identifies the medium and must be the same in each life. With a null
/// checkpoint, returns `inner`.
medium_t supervisor_undo_open(undo_medium_t* medium, checkpoint_t* checkpoint, uint8_t number,
                              const medium_t* inner);

#endif // FSW_SUPERVISOR_UNDO_H
