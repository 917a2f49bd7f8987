// SPDX-License-Identifier: Apache-2.0
/// The instruments of a world with their end nodes, and the log of their records, `records.log`: one line for
/// each record with time, name, `>` (sent by the instrument) or `<` (taken), octets.
///
/// Ownership  instrument_set_open allocates, instrument_set_close frees and completes the log.
/// Context    One task.
#ifndef SIM_APP_INSTRUMENT_SET_H
#define SIM_APP_INSTRUMENT_SET_H

#include "sim/app/simulator.h"
#include "sim/devices/instrument.h"
#include "sim/world/world.h"

#include <stddef.h>
#include <stdint.h>

typedef struct instrument_set instrument_set_t;

/// Open the instruments and their log (none if config->output_path is null). If the world has no instruments,
/// or config->flows is null, there is no log, and the set is empty: null. STATUS_OK; STATUS_EXHAUSTED
/// (memory), STATUS_IO (log), statuses of instrument_open: *out_instruments is null and `error` is filled.
MUST_USE status_t instrument_set_open(const world_t* world, const simulator_config_t* config,
                                      instrument_set_t** out_instruments, char error[SIMULATOR_ERROR_MAX]);
/// Close and free all; null is allowed. STATUS_OK, STATUS_IO: the log is not complete.
status_t instrument_set_close(instrument_set_t* instruments);
/// Returns the number of instruments; 0 for null.
size_t instrument_set_count(const instrument_set_t* instruments);
instrument_t* instrument_set_at(const instrument_set_t* instruments, size_t index);
const char* instrument_set_name(const instrument_set_t* instruments, size_t index);
/// Step each instrument (instrument_step).
void instrument_set_step(instrument_set_t* instruments, uint64_t now_ns, uint64_t end_ns);
/// Returns the sum of instrument_lost over all instruments.
uint64_t instrument_set_lost(const instrument_set_t* instruments);
/// Flush the log.
void instrument_set_flush(instrument_set_t* instruments);

#endif // SIM_APP_INSTRUMENT_SET_H
