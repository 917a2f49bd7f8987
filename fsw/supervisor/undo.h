// SPDX-License-Identifier: Apache-2.0
/// A medium whose writes since the last commit of the checkpoint can be undone: before each write, the octets
/// that it overwrites are saved in an annex of the checkpoint. When the next life opens the medium, it is as
/// it was at the last commit. A write that goes beyond the end needs only the old size. Not saved: octets
/// beyond UNDO_CUT_MAX of one truncation (a medium that is emptied has no content that matters), and what
/// does not fit into the annex.
///
/// Ownership  The caller places undo_medium_t.
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

/// Undo the writes of the last life to `inner` after its last commit, and return the guarded medium.
/// `number` is the same in each life. Null checkpoint: `inner` itself.
medium_t supervisor_undo_open(undo_medium_t* place, checkpoint_t* checkpoint, uint8_t number,
                              const medium_t* inner);

#endif // FSW_SUPERVISOR_UNDO_H
