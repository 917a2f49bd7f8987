// SPDX-License-Identifier: Apache-2.0
/// Lists of object accesses at one node, performed one after the other through its SDO client.
///
/// Ownership  The caller provides list and run; the list must outlive the run, which stores in it the values
///            that it reads.
/// Context    One task. Never blocks.
/// Time       O(1) per step.
#ifndef FSW_CANOPEN_SETTING_H
#define FSW_CANOPEN_SETTING_H

#include "fsw/canopen/sdo_client.h"
#include "base/status.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum {
    SETTING_WRITE,
    SETTING_READ,  ///< The value is stored in the list.
    SETTING_VERIFY ///< The value must be the one in the list.
} canopen_setting_kind_t;

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t octets; ///< 1, 2, 4 or 8.
    canopen_setting_kind_t kind;
    uint64_t value; ///< Value on the wire; a negative one in two's complement of `octets`.
} canopen_setting_t;

typedef struct { // Read-only outside.
    canopen_setting_t* settings;
    uint16_t count;
    uint16_t position; ///< Setting in progress; after a failure, the one that failed.
    bool is_started;
    uint32_t abort_code; ///< Code with which the node or the client aborted the failed access; 0: neither.
    bool is_other_value; ///< The value of the node differs from that of SETTING_VERIFY.
    uint64_t found;      ///< Value of the node if is_other_value, else 0.
    status_t result;     ///< STATUS_BUSY while running.
} canopen_setting_run_t;

/// Begin at the first setting. The list may be empty.
void canopen_setting_run_begin(canopen_setting_run_t* run, canopen_setting_t* settings, uint16_t count);
/// Perform the next step. STATUS_BUSY; STATUS_OK (all done); STATUS_FORBIDDEN (aborted by the node);
/// STATUS_TIMEOUT (also: the client was reset meanwhile); STATUS_INVALID (value other than expected, or of
/// another size, or protocol broken); STATUS_TOO_LARGE. Of an answer of 4 octets, which may have no size,
/// only the octets of the setting count.
status_t canopen_setting_run_step(canopen_setting_run_t* run, canopen_sdo_client_t* client);

#endif // FSW_CANOPEN_SETTING_H
