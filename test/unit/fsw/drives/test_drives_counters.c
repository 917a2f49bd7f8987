// SPDX-License-Identifier: Apache-2.0
// The field in which each counter of a subsystem with drives is published.
#include "fsw/drives/drives_counters.h"
#include "test/support/subsystem_double.h"
#include "test/unit/fsw/drives/two_nodes.h"

#include "unity.h"

static subsystem_descriptor_t descriptor;
static subsystem_t generic;
static drives_t drives;

void setUp(void)
{
    static const subsystem_callbacks_t no_callback = {.emit = NULL};
    double_init(&generic, &descriptor, &no_callback, &drives);
    two_nodes_run(&drives);
    drives.generic = &generic;
}

void tearDown(void)
{
}

/// Each source has a value of its own, so that the value of a field shows its source.
static void each_counter_is_published_under_its_name(void)
{
    static const char* const names[] = {
        "FRAMES_RECEIVED",   "FRAMES_REFUSED",   "EMERGENCIES",  "TRANSMIT_FULL",    "CHANNEL",
        "ERROR_FRAMES",      "BUS_OFF",          "BUS_RESTARTS", "NO_ACKNOWLEDGE",   "TRANSMIT_TIMEOUTS",
        "ARBITRATIONS_LOST", "RECEIVE_OVERRUNS", "BUS_LOST",     "TRANSMIT_REFUSED", "CONFLICTING_SYNCS"};
    enum {
        NAMES = sizeof names / sizeof names[0]
    };
    parameter_field_t fields[NAMES];
    uint32_t storage[NAMES];
    for (uint32_t i = 0U; i < NAMES; i++) {
        fields[i] = (parameter_field_t){names[i], VALUE_UINT32, 1U, i * (uint32_t)sizeof storage[0]};
    }
    const parameter_definition_t definition = {"COUNTERS", 1U, fields, NAMES, sizeof storage, sizeof storage};
    drives_counters_bind(&drives, &definition, storage);
    canopen_master_counters_t* const master = &drives.buses[0].network.master.counters;
    flow_can_t* const flow                  = &drives.buses[0].network.flows[0];
    flow->counters.received                 = 1U;
    master->unknown                         = 1U;
    master->malformed                       = 10U;
    master->remote                          = 100U;
    master->emergencies                     = 3U;
    flow->counters.full                     = 4U;
    drives.buses[0].network.channel         = 1U;
    flow->counters.errors                   = 6U;
    flow->errors.bus_offs                   = 7U;
    flow->errors.restarts                   = 8U;
    flow->errors.missing_acknowledges       = 9U;
    flow->errors.transmit_timeouts          = 10U;
    flow->errors.lost_arbitrations          = 11U;
    flow->counters.overruns                 = 12U;
    flow->counters.lost                     = 13U;
    flow->counters.refused                  = 14U;
    master->conflicting_syncs               = 15U;
    drives_counters_publish(&drives, 0U);
    static const uint32_t expected[NAMES] = {1U, 111U, 3U,  4U,  1U,  6U,  7U, 8U,
                                             9U, 10U,  11U, 12U, 13U, 14U, 15U};
    TEST_ASSERT_EQUAL_UINT32_ARRAY(expected, storage, NAMES);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(each_counter_is_published_under_its_name);
    return UNITY_END();
}
