// SPDX-License-Identifier: Apache-2.0
/// An instrument with one axis that exchanges records with the flight software over an end node: each period
/// it sends COUNT (UINT16), ENABLED (UINT8) and VALUE; a record to it has ENABLE (UINT8) and TARGET. While
/// enabled, its value follows the target at a limited speed. Value and target are integers or real numbers on
/// the wire: raw = (value - offset) / scale.
///
/// Ownership  instrument_open allocates, instrument_close frees.
/// Context    One task.
#ifndef SIM_DEVICES_INSTRUMENT_H
#define SIM_DEVICES_INSTRUMENT_H

#include "sim/devices/stream_port.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    INSTRUMENT_INT16,
    INSTRUMENT_INT32,
    INSTRUMENT_FLOAT,
    INSTRUMENT_DOUBLE,
    INSTRUMENT_VALUES
} instrument_value_t;

typedef struct {
    stream_port_config_t port; ///< The sizes of messages are filled in by the instrument.
    instrument_value_t value;
    bool has_checksum; ///< CRC-16/CCITT-FALSE after each record, in the byte order of the port.
    double scale;
    double offset;
    double speed; ///< Largest change of the value [1/s].
    uint64_t period_ns;
    /// Called with each record that the instrument has sent or received, without framing. May be null.
    void (*seen)(void* context, uint64_t now_ns, bool is_sent, const uint8_t* octets, size_t size);
    void* context;
} instrument_config_t;

typedef struct instrument instrument_t;

/// STATUS_OK; statuses of stream_port_open: *out_instrument is null and `error` is filled.
MUST_USE status_t instrument_open(const instrument_config_t* config, instrument_t** out_instrument,
                                  char error[STREAM_PORT_ERROR_MAX]);
/// Null is allowed.
void instrument_close(instrument_t* instrument);
/// Perform one step: take records, move the axis, send a record if it is due.
void instrument_step(instrument_t* instrument, uint64_t now_ns, uint64_t end_ns);
void instrument_plug(instrument_t* instrument, bool is_plugged);
bool instrument_is_plugged(const instrument_t* instrument);
/// Fault: the instrument sends nothing.
void instrument_set_silent(instrument_t* instrument, bool is_silent);
/// Fault: the instrument sends octets that are not a record.
void instrument_set_garbage(instrument_t* instrument, bool is_garbage);
double instrument_value(const instrument_t* instrument);
bool instrument_is_enabled(const instrument_t* instrument);
/// Octets and datagrams that did not arrive (stream_port_lost).
uint32_t instrument_lost(const instrument_t* instrument);

#endif // SIM_DEVICES_INSTRUMENT_H
