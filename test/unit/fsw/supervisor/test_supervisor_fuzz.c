// SPDX-License-Identifier: Apache-2.0
// No packet of the ground or of a member makes an assertion of the supervisor fail, and the supervisor works
// afterwards.
#include "fsw/supervisor/supervisor.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <string.h>

#define ROUNDS 40000U

void setUp(void)
{
    fixture_open_up();
}

void tearDown(void)
{
    fixture_close();
}

static uint32_t random_state = 77U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static size_t fill(uint8_t* octets, size_t capacity)
{
    static const uint8_t likely[] = {0U, 0U, 0U, 1U, 1U, 2U, 3U, 4U, 5U, 6U, 16U, 17U, 0xFFU};
    const size_t size             = draw((uint32_t)capacity);
    for (size_t i = 0U; i < size; i++) {
        octets[i] = (draw(4U) == 0U) ? (uint8_t)draw(256U) : likely[draw(sizeof likely)];
    }
    return size;
}

static void send_request(void)
{
    static const uint16_t apids[]   = {1U, 1U, 1U, 2U, 16U, 17U, 18U, 99U, 2047U, 0U};
    static const uint8_t services[] = {3U, 5U, 8U, 17U, 20U, 129U, 129U, 130U, 130U, 131U, 131U, 200U};
    uint8_t data[64];
    const size_t size = fill(data, sizeof data);
    uint8_t service   = services[draw(sizeof services)];
    uint8_t subtype   = (uint8_t)draw(12U);
    if ((service == 131U) && (subtype == 5U)) {
        subtype = 8U; // The shutdown would end the test.
    }
    fixture.ack = (uint8_t)draw(16U);
    (void)fixture_tc(apids[draw(10U)], service, subtype, data, (service == 129U) ? (size % 3U) : size);
}

/// Send a nearly correct report of a member: states, events, link answers and verification of any kind.
static void send_report(unsigned member)
{
    static const uint8_t services[] = {1U, 1U, 3U, 5U, 129U, 129U, 130U, 130U, 130U, 131U};
    uint8_t data[64];
    const size_t size     = fill(data, sizeof data);
    const uint8_t service = services[draw(sizeof services)];
    fixture_report(member, service, (uint8_t)draw(12U), data,
                   (service == 129U) && (draw(2U) == 0U) ? 12U : size);
}

static void send_octets(unsigned member)
{
    uint8_t octets[64];
    const size_t size = fill(octets, sizeof octets);
    fixture_send(member, octets, size);
}

static void no_received_packet_makes_an_assertion_fail(void)
{
    for (unsigned round = 0U; round < ROUNDS; round++) {
        const unsigned member = draw(FIXTURE_MEMBERS);
        const uint32_t kind   = draw(10U);
        if (!fixture.members[member].is_running) {
            (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_TEST, 1U, NULL, 0U);
        } else if (kind < 5U) {
            send_request();
        } else if (kind < 9U) {
            send_report(member);
        } else {
            send_octets(member);
        }
        fixture.members[member].is_passive    = (draw(20U) == 0U);
        fixture.members[member].ignores_links = (draw(20U) == 0U);
        fixture_tick();
        fixture_forget();
    }
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        fixture.members[i].is_passive    = false;
        fixture.members[i].ignores_links = false;
    }
    fixture.ack = PUS_ACK_ALL;
    fixture_run(400U);
    fixture_forget();
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_TEST, 1U, NULL, 0U);
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("G 17.2"));
    fixture.is_stop_requested = true;
    fixture_run(1500U);
    TEST_ASSERT_TRUE(fixture.is_finished);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_received_packet_makes_an_assertion_fail);
    return UNITY_END();
}
