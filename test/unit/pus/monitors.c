// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/monitors.h"

#include "unity.h"

#include <string.h>

monitors_t monitors;

static pus_pmon_t pmons[MONITORS_PMONS];
static uint16_t order[MONITORS_PMONS];
static uint16_t places[MONITORS_PMONS];
static pus_due_t due[MONITORS_PMONS];
static pus_fmon_t fmons[MONITORS_FMONS];
static uint16_t touched[MONITORS_FMONS];
static pus_fmon_member_t members[MONITORS_FMONS * MONITORS_MEMBERS];
static pus_check_transition_t transitions[MONITORS_TRANSITIONS];
static uint8_t octets[PUS_TC_DATA_MAX];

static bool is_known(void* const context, const uint16_t event_id)
{
    TEST_ASSERT_EQUAL_PTR(&monitors, context);
    return event_id != EVENT_UNKNOWN;
}

static bool can_fill(void* const context, const uint16_t event_id, const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&monitors, context);
    TEST_ASSERT_TRUE((size == 4U) || (size == 16U));
    return event_id != EVENT_OTHER;
}

static void raise_event(void* const context, const uint16_t event_id, const uint8_t* const auxiliary,
                        const size_t size, const uint64_t now_ns)
{
    TEST_ASSERT_EQUAL_PTR(&monitors, context);
    TEST_ASSERT_TRUE(size <= sizeof(monitors.events.auxiliary));
    (void)now_ns;
    monitors.events.count++;
    monitors.events.id   = event_id;
    monitors.events.size = size;
    memcpy(monitors.events.auxiliary, auxiliary, size);
}

static void start(const pus_parameter_port_t* const port)
{
    const pus_monitoring_config_t config = {
        .process    = &bench.process,
        .parameters = *port,
        .events = {.context = &monitors, .is_known = is_known, .can_fill = can_fill, .raise = raise_event},
        .persistence         = records_port(),
        .pmons               = pmons,
        .pmon_order          = order,
        .pmon_places         = places,
        .due                 = due,
        .fmons               = fmons,
        .touched             = touched,
        .members             = members,
        .transitions         = transitions,
        .pmon_capacity       = MONITORS_PMONS,
        .fmon_capacity       = MONITORS_FMONS,
        .transition_capacity = MONITORS_TRANSITIONS,
        .fmon_members        = MONITORS_MEMBERS,
        .reporting_delay     = MONITORS_DELAY,
    };
    memset(&monitors, 0, sizeof(monitors));
    memset(pmons, 0xA5, sizeof(pmons));
    memset(members, 0xA5, sizeof(members));
    bench_start();
    pus_monitoring_init(&monitors.service, &config);
    bench_serve(pus_monitoring_service(&monitors.service));
    pus_dispatcher_persist(&bench.dispatcher, records_port());
}

void monitors_start(void)
{
    const pus_parameter_port_t port = scalars_port();
    records_start();
    start(&port);
}

static status_t restore(void* const self, const uint32_t key, const uint8_t* const record, const size_t size)
{
    return pus_monitoring_restore(self, key, record, size);
}

void monitors_restart(void)
{
    const pus_parameter_port_t port = monitors.service.config.parameters;
    records_cut();
    start(&port);
    (void)records_replay(PUS_SERVICE_MONITORING, restore, &monitors.service);
}

void monitors_step(const unsigned cycles)
{
    bench_clear();
    for (unsigned i = 0U; i < cycles; i++) {
        monitors.cycle++;
        pus_dispatcher_step(&bench.dispatcher, TEST_NOW_NS + monitors.cycle, monitors.cycle);
    }
}

void data_begin(const unsigned count)
{
    monitors.data = octet_writer(octets, sizeof octets);
    octet_write_u8(&monitors.data, (uint8_t)count);
}

status_t data_send(const uint8_t subtype)
{
    bench_clear();
    TEST_ASSERT_FALSE(monitors.data.failed);
    return bench_request(subtype, octets, monitors.data.position);
}

status_t send_ids(const uint8_t subtype, const unsigned count, const uint16_t first)
{
    data_begin(count);
    for (unsigned i = 0U; i < count; i++) {
        octet_write_u16(&monitors.data, (uint16_t)(first + i));
    }
    return data_send(subtype);
}

status_t send_empty(const uint8_t subtype)
{
    bench_clear();
    return bench_request(subtype, NULL, 0U);
}

void data_scalar(const uint32_t parameter, const uint64_t bits)
{
    pus_scalar_write(&monitors.data, pus_scalar_type(parameter), bits);
}

void data_pmon(const uint16_t id, const uint32_t parameter, const uint32_t interval,
               const uint16_t repetition, const uint8_t check_type)
{
    octet_write_u16(&monitors.data, id);
    octet_write_u32(&monitors.data, parameter);
    octet_write_u32(&monitors.data, 0U); // No validity condition.
    octet_write_u16(&monitors.data, 0U);
    octet_write_u32(&monitors.data, interval);
    octet_write_u16(&monitors.data, repetition);
    octet_write_u8(&monitors.data, check_type);
}

void data_expected(const uint32_t parameter, const uint64_t mask, const uint64_t expected,
                   const uint16_t event)
{
    data_scalar(parameter, mask);
    data_scalar(parameter, expected);
    octet_write_u16(&monitors.data, event);
}

void data_limits(const uint32_t parameter, const uint64_t low, const uint16_t low_event, const uint64_t high,
                 const uint16_t high_event)
{
    data_scalar(parameter, low);
    octet_write_u16(&monitors.data, low_event);
    data_scalar(parameter, high);
    octet_write_u16(&monitors.data, high_event);
}

void data_limit(const uint16_t id, const uint32_t parameter, const uint64_t low, const uint64_t high)
{
    data_pmon(id, parameter, 1U, 1U, PUS_CHECK_LIMIT);
    data_limits(parameter, low, EVENT_LOW, high, EVENT_HIGH);
}

void limit_added(const uint16_t id, const uint32_t parameter)
{
    data_begin(1U);
    data_limit(id, parameter, 10U, 20U);
    TEST_ASSERT_EQUAL(STATUS_OK, data_send(5U));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
    TEST_ASSERT_EQUAL(STATUS_OK, send_ids(1U, 1U, id));
    EXPECT_MESSAGES(1, 1, 1, 3, 1, 7);
}

transition_t transition_at(const size_t report, const uint16_t index)
{
    octet_reader_t reader = bench_data(report);
    transition_t found    = {0};
    TEST_ASSERT_TRUE(index < octet_read_u16(&reader));
    for (uint16_t i = 0U; i <= index; i++) {
        found.pmon_id      = octet_read_u16(&reader);
        found.parameter_id = octet_read_u32(&reader);
        found.check_type   = octet_read_u8(&reader);
        found.value        = octet_read_u16(&reader);
        found.limit        = octet_read_u16(&reader);
        found.previous     = octet_read_u8(&reader);
        found.current      = octet_read_u8(&reader);
        TEST_ASSERT_EQUAL(STATUS_OK, pus_time_read(&reader, &found.time_ns));
    }
    TEST_ASSERT_FALSE(reader.failed);
    return found;
}

uint8_t status_of(const uint16_t id)
{
    for (uint16_t i = 0U; i < monitors.service.pmon_count; i++) {
        const pus_pmon_t* const pmon = &pmons[order[i]];
        if (pmon->id == id) {
            return pmon->status;
        }
    }
    TEST_FAIL_MESSAGE("no such PMON");
    return 0U;
}
