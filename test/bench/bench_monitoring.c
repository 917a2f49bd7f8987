// SPDX-License-Identifier: Apache-2.0
/// Time of a cycle with 1000 parameter monitors of ST[12] [us]: first all monitors are due, then none. If all
/// are due ten times a second, 1000 us are one percent of a processor. The baseline reads the same values
/// through the same port and compares them with two bounds.
#include "pus/st12/st12_monitoring.h"
#include "test/bench/measure.h"

#include <stdlib.h>

#define MONITORS 1000U
#define TRANSITIONS 100U
#define NEVER 0x7FFFFFFFU // Interval of the monitors that are not due [cycles].
#define NS_PER_US 1000.0
#define SETTINGS_KEY 0x20000U // Key of the record with the settings of ST[12].

static pus_app_process_t process;
static pus_monitoring_t monitoring;
static pus_pmon_t pmons[MONITORS];
static uint16_t order[MONITORS];
static uint16_t positions[MONITORS];
static pus_due_t due[MONITORS];
static pus_fmon_t fmons[1];
static uint16_t touched[1];
static pus_fmon_member_t members[1];
static pus_check_transition_t transitions[TRANSITIONS];
static uint32_t values[MONITORS];
static uint32_t cycle;
static volatile unsigned sink; // Keeps the compiler from removing the work.

static status_t find(void* const context, const uint32_t id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    (void)context;
    *out_handle = (uint16_t)(id & 0xFFFFU);
    *out_size   = (uint16_t)sizeof values[0];
    return STATUS_OK;
}

static void read_value(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    (void)context;
    octet_write_u32(writer, values[handle]);
}

static bool is_known(void* const context, const uint16_t event_id)
{
    (void)context;
    (void)event_id;
    return true;
}

static void raise_nothing(void* const context, const uint16_t event_id, const uint8_t* const auxiliary,
                          const size_t size, const uint64_t now_ns)
{
    (void)context;
    (void)event_id;
    (void)auxiliary;
    (void)size;
    (void)now_ns;
}

static status_t drop(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    (void)packet;
    (void)size;
    return STATUS_OK;
}

static void step(void)
{
    cycle++;
    pus_monitoring_step(&monitoring, cycle, cycle);
}

static void compare_plainly(void)
{
    unsigned within = 0U;
    for (uint16_t i = 0U; i < MONITORS; i++) {
        uint8_t octets[sizeof values[0]];
        octet_writer_t writer = octet_writer(octets, sizeof octets);
        read_value(NULL, i, &writer);
        const uint32_t value = octets_u32_at(octets);
        within += ((value >= 10U) && (value <= 20U)) ? 1U : 0U;
    }
    sink = within;
}

/// Restore enabled monitors of UINT32 values from 10 to 20, each with this interval [cycles], and check once.
static void restore_monitors(const uint32_t interval)
{
    static const uint8_t enabled[] = {1, 0, 0, 0, 0, 10};
    const pus_port_t port          = {.send = drop};
    pus_app_process_init(&process, 16U, 0U, &port);
    pus_monitoring_init(&monitoring, &(const pus_monitoring_config_t){
                                         .process        = &process,
                                         .parameters     = {.find = find, .read = read_value},
                                         .events         = {.is_known = is_known, .raise = raise_nothing},
                                         .pmons          = pmons,
                                         .pmon_order     = order,
                                         .pmon_positions = positions,
                                         .due            = due,
                                         .fmons          = fmons,
                                         .touched        = touched,
                                         .members        = members,
                                         .transitions    = transitions,
                                         .pmon_capacity  = MONITORS,
                                         .fmon_capacity  = 1U,
                                         .transition_capacity = TRANSITIONS,
                                         .fmon_members        = 1U,
                                     });
    for (uint16_t i = 0U; i < MONITORS; i++) {
        uint8_t record[64];
        octet_writer_t writer = octet_writer(record, sizeof record);
        values[i]             = 15U;
        octet_write_u16(&writer, i);
        octet_write_u32(&writer, (16U << 21U) | ((uint32_t)VALUE_UINT32 << 16U) | i);
        octet_write_u32(&writer, 0U); // No validity condition.
        octet_write_u16(&writer, 0U);
        octet_write_u32(&writer, interval);
        octet_write_u8(&writer, 1U);
        octet_write_u16(&writer, 1U);
        octet_write_u8(&writer, PUS_CHECK_LIMIT);
        octet_write_u32(&writer, 10U);
        octet_write_u16(&writer, 0U);
        octet_write_u32(&writer, 20U);
        octet_write_u16(&writer, 0U);
        if (pus_monitoring_restore(&monitoring, i, record, writer.position) != STATUS_OK) {
            abort();
        }
    }
    if (pus_monitoring_restore(&monitoring, SETTINGS_KEY, enabled, sizeof enabled) != STATUS_OK) {
        abort();
    }
    step();
}

int main(void)
{
    restore_monitors(1U);
    measure_compare("monitoring_1000_due", step, compare_plainly, 1.0, "us", NS_PER_US);
    restore_monitors(NEVER);
    measure_compare("monitoring_1000_idle", step, compare_plainly, 1.0, "us", NS_PER_US);
    // The monitors that are not due were checked only when they were restored.
    return (monitoring.counters.checks == MONITORS) ? 0 : 1;
}
