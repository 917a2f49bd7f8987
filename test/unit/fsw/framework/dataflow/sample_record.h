// SPDX-License-Identifier: Apache-2.0
/// A record for tests of flows, and its octets in both byte orders.
#ifndef TEST_UNIT_DATAFLOW_SAMPLE_RECORD_H
#define TEST_UNIT_DATAFLOW_SAMPLE_RECORD_H

#include "fsw/framework/dataflow/record.h"

#include <stdbool.h>

typedef struct {
    uint16_t number;
    float rates[2];
    bool is_on;
} sample_t;

#define SAMPLE_OCTETS 11U

static const flow_record_field_t sample_fields[] = {RECORD_FIELD(sample_t, number, VALUE_UINT16, 1U),
                                                    RECORD_FIELD(sample_t, rates, VALUE_FLOAT, 2U),
                                                    RECORD_FIELD(sample_t, is_on, VALUE_BOOL, 1U)};
static const flow_record_layout_t sample_layout  = {sample_fields, 3U};
static const sample_t sample                     = {0x1234U, {1.0F, -2.0F}, true};
static const uint8_t sample_wire[FLOW_ORDERS][SAMPLE_OCTETS] = {
    [FLOW_ORDER_BIG]    = {0x12U, 0x34U, 0x3FU, 0x80U, 0U, 0U, 0xC0U, 0U, 0U, 0U, 1U},
    [FLOW_ORDER_LITTLE] = {0x34U, 0x12U, 0U, 0U, 0x80U, 0x3FU, 0U, 0U, 0U, 0xC0U, 1U}};

// A layout that is too large for any flow.
static const flow_record_field_t giant_fields[] = {{VALUE_UINT64, (RECORD_OCTETS_MAX / 8U) + 1U, 0U}};
static const flow_record_layout_t giant_layout  = {giant_fields, 1U};
static const uint64_t giant_record[(RECORD_OCTETS_MAX / 8U) + 1U];

static inline bool is_sample(const sample_t* seen)
{
    return (seen->number == sample.number) && (seen->rates[0] == sample.rates[0]) &&
           (seen->rates[1] == sample.rates[1]) && (seen->is_on == sample.is_on);
}

#endif // TEST_UNIT_DATAFLOW_SAMPLE_RECORD_H
