// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/instrument.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAD_OCTETS 3U    // COUNT and ENABLED before the value.
#define COMMAND_OCTETS 1U // ENABLE before the target.
#define CHECKSUM_OCTETS 2U
#define NS_PER_S 1e9

struct instrument {
    instrument_config_t config;
    stream_port_t* port;
    uint64_t due_ns; // Time of the next record.
    uint16_t count;
    bool is_enabled;
    bool is_silent;
    bool is_garbage;
    uint32_t noise;
    double value;
    double target;
};

// ---- Records ----

static size_t value_octets(const instrument_value_t value)
{
    static const size_t octets[INSTRUMENT_VALUES] = {2U, 4U, 4U, 8U};
    return octets[value];
}

static void put_bits(const instrument_t* const instrument, const uint64_t bits, const size_t size,
                     uint8_t* const octets)
{
    for (size_t i = 0U; i < size; i++) {
        const size_t position = instrument->config.port.framing.is_little ? i : (size - 1U - i);
        octets[position]      = (uint8_t)(bits >> (8U * i));
    }
}

static uint64_t get_bits(const instrument_t* const instrument, const uint8_t* const octets, const size_t size)
{
    uint64_t bits = 0U;
    for (size_t i = 0U; i < size; i++) {
        const size_t position = instrument->config.port.framing.is_little ? i : (size - 1U - i);
        bits |= (uint64_t)octets[position] << (8U * i);
    }
    return bits;
}

static uint16_t checksum_of(const uint8_t* const octets, const size_t size)
{
    uint16_t checksum = 0xFFFFU;
    for (size_t i = 0U; i < size; i++) {
        checksum = (uint16_t)(checksum ^ (uint16_t)((uint16_t)octets[i] << 8U));
        for (unsigned bit = 0U; bit < 8U; bit++) {
            const bool is_set = (checksum & 0x8000U) != 0U;
            checksum          = (uint16_t)((uint16_t)(checksum << 1U) ^ (is_set ? 0x1021U : 0U));
        }
    }
    return checksum;
}

static uint64_t raw_of(const instrument_t* const instrument)
{
    const double raw = (instrument->value - instrument->config.offset) / instrument->config.scale;
    uint64_t bits    = 0U;
    if (instrument->config.value == INSTRUMENT_DOUBLE) {
        memcpy(&bits, &raw, sizeof raw);
    } else if (instrument->config.value == INSTRUMENT_FLOAT) {
        const float single = (float)raw;
        uint32_t low       = 0U;
        memcpy(&low, &single, sizeof single);
        bits = low;
    } else {
        const double most = (instrument->config.value == INSTRUMENT_INT16) ? 32767.0 : 2147483647.0;
        bits              = (uint64_t)llround(fmax(-most, fmin(most, raw)));
    }
    return bits;
}

static double value_of(const instrument_t* const instrument, const uint64_t bits)
{
    double raw = 0.0;
    if (instrument->config.value == INSTRUMENT_DOUBLE) {
        memcpy(&raw, &bits, sizeof raw);
    } else if (instrument->config.value == INSTRUMENT_FLOAT) {
        const uint32_t low = (uint32_t)bits;
        float single       = 0.0F;
        memcpy(&single, &low, sizeof single);
        raw = (double)single;
    } else if (instrument->config.value == INSTRUMENT_INT16) {
        raw = (double)(int16_t)(uint16_t)bits;
    } else {
        raw = (double)(int32_t)(uint32_t)bits;
    }
    return (raw * instrument->config.scale) + instrument->config.offset;
}

// ---- The cycle ----

static void notify(const instrument_t* const instrument, const uint64_t now_ns, const bool is_sent,
                   const uint8_t* const octets, const size_t size)
{
    if (instrument->config.seen != NULL) {
        instrument->config.seen(instrument->config.context, now_ns, is_sent, octets, size);
    }
}

static void take_record(instrument_t* const instrument, const uint8_t* const record, const size_t size)
{
    const size_t octets = COMMAND_OCTETS + value_octets(instrument->config.value);
    const bool is_whole = size == instrument->config.port.octets_in;
    if (!is_whole ||
        (instrument->config.has_checksum &&
         (get_bits(instrument, &record[octets], CHECKSUM_OCTETS) != checksum_of(record, octets)))) {
        return;
    }
    instrument->is_enabled = record[0] != 0U;
    instrument->target     = value_of(
            instrument, get_bits(instrument, &record[COMMAND_OCTETS], value_octets(instrument->config.value)));
}

static void receive(instrument_t* const instrument, const uint64_t now_ns)
{
    uint8_t record[STREAM_PORT_MESSAGE_MAX];
    size_t size = 0U;
    stream_port_step(instrument->port);
    while (stream_port_receive(instrument->port, record, &size)) {
        notify(instrument, now_ns, false, record, size);
        take_record(instrument, record, size);
    }
}

static void move(instrument_t* const instrument, const double h_s)
{
    const double most = instrument->config.speed * h_s;
    if (instrument->is_enabled) {
        instrument->value += fmax(-most, fmin(most, instrument->target - instrument->value));
    }
}

static size_t write_record(const instrument_t* const instrument, uint8_t* const record)
{
    const size_t octets = value_octets(instrument->config.value);
    size_t size         = HEAD_OCTETS + octets;
    put_bits(instrument, instrument->count, 2U, record);
    record[2] = instrument->is_enabled ? 1U : 0U;
    put_bits(instrument, raw_of(instrument), octets, &record[HEAD_OCTETS]);
    if (instrument->config.has_checksum) {
        put_bits(instrument, checksum_of(record, size), CHECKSUM_OCTETS, &record[size]);
        size += CHECKSUM_OCTETS;
    }
    return size;
}

/// Send octets that differ from a record in length, checksum or frame. A queue only takes messages of one
/// size.
static void send_garbage(instrument_t* const instrument, const uint64_t now_ns)
{
    uint8_t garbage[STREAM_PORT_MESSAGE_MAX];
    const size_t size = instrument->config.port.octets_out;
    for (size_t i = 0U; i < size; i++) {
        instrument->noise = (instrument->noise * 1664525U) + 1013904223U;
        garbage[i]        = (uint8_t)(instrument->noise >> 24U);
    }
    notify(instrument, now_ns, true, garbage, size);
    stream_port_send_raw(instrument->port, garbage, size);
}

static void send_record(instrument_t* const instrument, const uint64_t now_ns)
{
    uint8_t record[STREAM_PORT_MESSAGE_MAX];
    const size_t size = write_record(instrument, record);
    notify(instrument, now_ns, true, record, size);
    stream_port_send(instrument->port, record, size);
}

void instrument_step(instrument_t* const instrument, const uint64_t now_ns, const uint64_t end_ns)
{
    receive(instrument, now_ns);
    move(instrument, (double)(end_ns - now_ns) / NS_PER_S);
    while (instrument->due_ns <= end_ns) {
        instrument->due_ns += instrument->config.period_ns;
        instrument->count++;
        if (instrument->is_silent || !stream_port_is_plugged(instrument->port)) {
            continue;
        }
        if (instrument->is_garbage) {
            send_garbage(instrument, end_ns);
        } else {
            send_record(instrument, end_ns);
        }
    }
}

// ---- Opening, faults ----

status_t instrument_open(const instrument_config_t* const config, instrument_t** const out_instrument,
                         char error[STREAM_PORT_ERROR_MAX])
{
    *out_instrument          = NULL;
    instrument_t* instrument = calloc(1U, sizeof *instrument);
    if (instrument == NULL) {
        (void)snprintf(error, STREAM_PORT_ERROR_MAX, "out of memory");
        return STATUS_EXHAUSTED;
    }
    const size_t more  = value_octets(config->value) + (config->has_checksum ? CHECKSUM_OCTETS : 0U);
    instrument->config = *config;
    instrument->config.port.octets_out = HEAD_OCTETS + more;
    instrument->config.port.octets_in  = COMMAND_OCTETS + more;
    instrument->due_ns                 = config->period_ns;
    const status_t status              = stream_port_open(&instrument->config.port, &instrument->port, error);
    if (status != STATUS_OK) {
        free(instrument);
        return status;
    }
    *out_instrument = instrument;
    return STATUS_OK;
}

void instrument_close(instrument_t* const instrument)
{
    if (instrument != NULL) {
        stream_port_close(instrument->port);
        free(instrument);
    }
}

void instrument_plug(instrument_t* const instrument, const bool is_plugged)
{
    stream_port_plug(instrument->port, is_plugged);
}

bool instrument_is_plugged(const instrument_t* const instrument)
{
    return stream_port_is_plugged(instrument->port);
}

void instrument_set_silent(instrument_t* const instrument, const bool is_silent)
{
    instrument->is_silent = is_silent;
}

void instrument_set_garbage(instrument_t* const instrument, const bool is_garbage)
{
    instrument->is_garbage = is_garbage;
}

double instrument_value(const instrument_t* const instrument)
{
    return instrument->value;
}

bool instrument_is_enabled(const instrument_t* const instrument)
{
    return instrument->is_enabled;
}

uint32_t instrument_lost(const instrument_t* const instrument)
{
    return stream_port_lost(instrument->port);
}
