// SPDX-License-Identifier: Apache-2.0
// No packet in any state makes an assertion fail, and the component works afterwards.
#include "fsw/framework/subsystem/subsystem_core.h"

#include "test/unit/fsw/framework/subsystem/subsystem_fixture.h"
#include "test/support/consistent_pool.h"
#include "unity.h"

#include <string.h>

#define ROUNDS 120000U

void setUp(void)
{
    fixture_open(NULL);
}

void tearDown(void)
{
    fixture_close();
}

static uint32_t random_state;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

/// Fill in application data that are nearly correct: small counts, existing identifiers, names of functions.
static size_t fill(uint8_t* octets, size_t capacity)
{
    static const uint8_t likely[] = {0U, 0U, 0U, 1U, 1U, 2U, 3U, 5U, 7U, 16U, 17U, 100U, 0xFFU};
    const size_t size             = draw((uint32_t)capacity);
    for (size_t i = 0U; i < size; i++) {
        octets[i] = (draw(4U) == 0U) ? (uint8_t)draw(256U) : likely[draw(sizeof likely)];
    }
    if ((size > 16U) && (draw(3U) == 0U)) {
        (void)memcpy(octets, (draw(2U) == 0U) ? "MOVE\0\0\0\0" : "WAIT\0\0\0\0", 8U);
        octets[8] = (uint8_t)draw(4U);
    }
    if ((size > 8U) && (draw(4U) == 0U)) {
        // A count of one, then the id of LIMIT.
        static const uint8_t id[5] = {1U, 0x02U, 0x09U, 0x00U, 0x01U};
        (void)memcpy(octets, id, sizeof id);
    }
    return size;
}

static void send_one(void)
{
    static const uint8_t services[] = {3U,  3U,   3U,   5U,   8U, 8U,   17U, 20U,
                                       20U, 129U, 130U, 130U, 1U, 131U, 200U};
    uint8_t data[96];
    const uint8_t service = services[draw(sizeof services)];
    const size_t size     = fill(data, sizeof data);
    fixture.ack           = (uint8_t)draw(16U);
    if ((service == 129U) && (draw(3U) > 0U)) {
        (void)fixture_command(service, (draw(3U) == 0U) ? 3U : 1U, data, (draw(3U) == 0U) ? 2U : 1U);
    } else {
        (void)fixture_command(service, (uint8_t)draw(40U), data, size);
    }
}

/// Send arbitrary octets, once as a request and once as a datagram of a link.
static void send_noise(void)
{
    uint8_t octets[64];
    const size_t size = 1U + draw(sizeof octets);
    for (size_t i = 0U; i < size; i++) {
        octets[i] = (uint8_t)draw(256U);
    }
    // Make the packet a request, because any other packet is only a heartbeat.
    octets[0] = (uint8_t)(0x18U | (octets[0] & 0x07U));
    fixture_forget_ends(); // The request may have any sequence count.
    fixture_accept(octets, size);
    subsystem_link_datagram(&fixture.subsystem, octets, size);
}

static status_t any_answer(const subsystem_function_t* function)
{
    static const status_t answers[] = {STATUS_OK, STATUS_BUSY, STATUS_BUSY, STATUS_FORBIDDEN, STATUS_IO};
    (void)function;
    return answers[draw(5U)];
}

static void no_received_packet_makes_an_assertion_fail(void)
{
    random_state           = 99U;
    fixture.in_perform     = any_answer;
    fixture.has_many_users = true;
    for (unsigned round = 0U; round < ROUNDS; round++) {
        if (draw(6U) == 0U) {
            send_noise();
        } else {
            send_one();
        }
        if (draw(4U) == 0U) {
            fixture_run(1U + draw(3U));
        }
        if (draw(10U) == 0U) {
            subsystem_function_done(&fixture.subsystem, 1U + draw(SUBSYSTEM_CALL_TOKENS), (uint16_t)draw(2U),
                                    0U);
        }
        fixture.is_port_closed = (draw(200U) == 0U) ? !fixture.is_port_closed : fixture.is_port_closed;
        fixture_forget();
    }
    fixture.is_port_closed = false;
    fixture.ack            = 0U;
    (void)fixture_state(STATE_OFFLINE); // The subsystem can go to OFFLINE from any state.
    fixture_run(30U);
    TEST_ASSERT_EQUAL(STATE_OFFLINE, subsystem_state(&fixture.subsystem));
    TEST_ASSERT_EQUAL(0U, fixture.subsystem.call_tokens.stats.taken);
    TEST_ASSERT_TRUE(pool_is_consistent(&fixture.subsystem.call_tokens));
    fixture.in_perform = NULL;
    fixture.ack        = PUS_ACK_ALL;
    fixture_bring(STATE_OPERATIONAL, FIXTURE_ALONE); // It can go to OPERATIONAL again.
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(no_received_packet_makes_an_assertion_fail);
    return UNITY_END();
}
