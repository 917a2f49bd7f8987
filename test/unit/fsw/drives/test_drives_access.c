// SPDX-License-Identifier: Apache-2.0
// ST[02] by SDO: the test acts as the device and answers the frames of the client.
#include "fsw/drives/drives_access.h"

#include "test/unit/fsw/drives/two_nodes.h"
#include "unity.h"

#include <string.h>

static drives_t drives;
static pus_device_port_t port;
static pus_device_result_t result;
static canopen_sdo_client_t* client;
static uint8_t frame[SDO_FRAME_OCTETS];

void setUp(void)
{
    memset(&result, 0, sizeof result);
    two_nodes_run(&drives);
    client = &drives.buses[0].network.master.nodes[drives.devices[0].device.index].sdo;
    port   = drives_access_port(&drives);
}

void tearDown(void)
{
}

static pus_device_action_t command(const uint8_t kind, const uint16_t device, const uint8_t* const protocol,
                                   const char* const data)
{
    return (pus_device_action_t){.kind     = kind,
                                 .device   = device,
                                 .protocol = protocol,
                                 .data     = (const uint8_t*)data,
                                 .size     = (uint16_t)((data != NULL) ? strlen(data) : 0U)};
}

static status_t begin(const uint8_t slot, const pus_device_action_t* const action)
{
    return port.begin(port.context, slot, action, &result);
}

static status_t poll(const uint8_t slot)
{
    return port.poll(port.context, slot, &result);
}

/// Fetch the next frame of the client and answer it. first: 0x60 downloaded; 0x4F, 0x4B, 0x43 upload of 1, 2,
/// 4 octets; 0x80 abort.
static void answer(const uint8_t first, const char* const data)
{
    TEST_ASSERT_TRUE(canopen_sdo_client_request(client, 1U, frame));
    uint8_t octets[SDO_FRAME_OCTETS] = {first, frame[1], frame[2], frame[3]};
    memcpy(&octets[4], data, 4U);
    canopen_sdo_client_answer(client, octets, sizeof octets);
}

static void objects_are_written(void)
{
    static const uint8_t protocol[] = {0x60, 0x65, 0x01, 4};
    const pus_device_action_t write = command(PUS_DEVICE_COMMAND, FIRST_NODE, protocol, "abcd");
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &write));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &write));
    TEST_ASSERT_EQUAL(STATUS_BUSY, poll(0U));
    answer(0x60U, "\0\0\0");
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x23, 0x65, 0x60, 0x01, 'a', 'b', 'c', 'd'}), frame, 8U);
    TEST_ASSERT_EQUAL(STATUS_OK, poll(0U));
}

static void objects_are_read(void)
{
    static const uint8_t any[]   = {0x60, 0x41, 0x00, 0};
    static const uint8_t exact[] = {0x60, 0x41, 0x00, 2};
    static const uint8_t wrong[] = {0x60, 0x41, 0x00, 4};
    static const struct {
        const uint8_t* protocol;
        status_t status;
    } cases[] = {{any, STATUS_OK}, {exact, STATUS_OK}, {wrong, STATUS_IO}};
    for (size_t i = 0U; i < 3U; i++) {
        const pus_device_action_t read = command(PUS_DEVICE_ACQUIRE, FIRST_NODE, cases[i].protocol, NULL);
        TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &read));
        TEST_ASSERT_EQUAL(STATUS_OK, begin(3U, &read));
        answer(0x4BU, "xy\0"); // A value of two octets.
        TEST_ASSERT_EQUAL(cases[i].status, poll(3U));
        if (cases[i].status == STATUS_OK) {
            TEST_ASSERT_EQUAL_UINT16(2U, result.size);
            TEST_ASSERT_EQUAL_STRING_LEN("xy", result.data, 2U);
        } else {
            TEST_ASSERT_EQUAL_UINT16(DRIVES_ACCESS_WRONG, result.return_code);
        }
    }
}

static void registers_are_accessed_by_number(void)
{
    const uint8_t value[]          = {0x11, 0x22, 0x33, 0x44};
    const pus_device_action_t load = {.kind    = PUS_DEVICE_LOAD_REGISTER,
                                      .address = (FIRST_NODE << 24U) | (0x6065U << 8U) | 2U,
                                      .data    = value,
                                      .size    = 4U};
    pus_device_action_t dump       = load;
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &load));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &load));
    answer(0x60U, "\0\0\0");
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x23, 0x65, 0x60, 0x02, 0x44, 0x33, 0x22, 0x11}), frame,
                                 8U);
    TEST_ASSERT_EQUAL(STATUS_OK, poll(0U));
    dump.kind = PUS_DEVICE_DUMP_REGISTER;
    dump.size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &dump));
    answer(0x43U, "\x44\x33\x22\x11");
    TEST_ASSERT_EQUAL(STATUS_OK, poll(0U));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(value, result.data, 4U);
}

static void a_command_with_an_invalid_device_or_address_is_refused(void)
{
    static const uint8_t protocol[] = {0x60, 0x65, 0x01, 4};
    static const uint8_t none[]     = {0x60, 0x65, 0x01, 0};
    static const uint8_t large[]    = {0x60, 0x65, 0x01, SDO_OCTETS_MAX + 1U};
    const struct {
        pus_device_action_t action;
        status_t status;
    } cases[] = {
        {command(PUS_DEVICE_COMMAND, 0x13U, protocol, "abcd"), STATUS_NOT_FOUND},
        {command(PUS_DEVICE_COMMAND, 0x111U, protocol, "abcd"), STATUS_NOT_FOUND},
        {command(PUS_DEVICE_COMMAND, FIRST_NODE, protocol, "abc"), STATUS_OUT_OF_RANGE},
        {command(PUS_DEVICE_COMMAND, FIRST_NODE, none, ""), STATUS_OUT_OF_RANGE},
        {command(PUS_DEVICE_ACQUIRE, FIRST_NODE, large, NULL), STATUS_OUT_OF_RANGE},
        {command(PUS_DEVICE_LOGICAL_COMMAND, FIRST_NODE, NULL, "x"), STATUS_NOT_FOUND},
    };
    for (size_t i = 0U; i < (sizeof cases / sizeof cases[0]); i++) {
        TEST_ASSERT_EQUAL(cases[i].status, port.check(port.context, &cases[i].action));
    }
    const pus_device_action_t good     = command(PUS_DEVICE_COMMAND, FIRST_NODE, protocol, "abcd");
    drives.buses[0].network.is_running = false;
    TEST_ASSERT_EQUAL(STATUS_FORBIDDEN, port.check(port.context, &good));
    TEST_ASSERT_EQUAL(STATUS_IO, begin(0U, &good));
    TEST_ASSERT_EQUAL_UINT32(DRIVES_ACCESS_CLOSED, result.detail);
    TEST_ASSERT_EQUAL(STATUS_IO, begin(0U, &cases[0].action));
}

static void an_sdo_abort_of_the_device_is_reported(void)
{
    static const uint8_t protocol[] = {0x60, 0x65, 0x01, 0};
    const pus_device_action_t read  = command(PUS_DEVICE_ACQUIRE, FIRST_NODE, protocol, NULL);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &read));
    answer(0x80U, "\x00\x00\x02\x06");
    TEST_ASSERT_EQUAL(STATUS_IO, poll(0U));
    TEST_ASSERT_EQUAL_HEX16(0x0602U, result.return_code);
    TEST_ASSERT_EQUAL_HEX32(0x06020000U, result.detail);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &read));
    answer(0x20U, "\0\0\0"); // The response does not fit the request.
    TEST_ASSERT_EQUAL(STATUS_IO, poll(0U));
    TEST_ASSERT_EQUAL_HEX16(DRIVES_ACCESS_WRONG, result.return_code);
    canopen_sdo_client_reset(client);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &read));
    TEST_ASSERT_TRUE(canopen_sdo_client_request(client, 1U, frame));
    (void)canopen_sdo_client_request(client, 5000U, frame); // The device does not answer.
    TEST_ASSERT_EQUAL(STATUS_IO, poll(0U));
    TEST_ASSERT_EQUAL_HEX32(SDO_ABORT_TIMEOUT, result.detail);
}

static void a_node_has_one_transfer_at_a_time(void)
{
    static const uint8_t protocol[] = {0x60, 0x65, 0x01, 0};
    const pus_device_action_t first = command(PUS_DEVICE_ACQUIRE, FIRST_NODE, protocol, NULL);
    const pus_device_action_t other = command(PUS_DEVICE_ACQUIRE, SECOND_NODE, protocol, NULL);
    // A transfer that another user has started.
    TEST_ASSERT_EQUAL(STATUS_OK, canopen_sdo_client_upload(client, 1U, 0U));
    TEST_ASSERT_EQUAL(STATUS_FULL, begin(0U, &first));
    canopen_sdo_client_reset(client);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &first));
    TEST_ASSERT_EQUAL(STATUS_FULL, begin(1U, &first));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(2U, &other));
    answer(0x4FU, "x\0\0");
    // The result of the first transfer has not been read yet.
    TEST_ASSERT_EQUAL(STATUS_FULL, begin(1U, &first));
    TEST_ASSERT_EQUAL(STATUS_OK, poll(0U));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(1U, &first));
    port.abandon(port.context, 1U);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_sdo_client_result(client, NULL));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(1U, &first));
}

static void commissioning_ends_a_transfer(void)
{
    static const uint8_t protocol[] = {0x60, 0x65, 0x01, 0};
    const pus_device_action_t read  = command(PUS_DEVICE_ACQUIRE, FIRST_NODE, protocol, NULL);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &read));
    canopen_sdo_client_reset(client); // The network was stopped and runs again.
    TEST_ASSERT_EQUAL(STATUS_IO, poll(0U));
    TEST_ASSERT_EQUAL_HEX16(DRIVES_ACCESS_CLOSED, result.return_code);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &read));
    drives.buses[0].network.is_running = false;
    TEST_ASSERT_EQUAL(STATUS_IO, poll(0U));
    TEST_ASSERT_EQUAL_HEX16(DRIVES_ACCESS_CLOSED, result.return_code);
    drives.buses[0].network.is_running = true;
    canopen_sdo_client_reset(client);
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &read));
    drives.buses[0].network.is_running = false;
    port.abandon(port.context, 0U);
    // The client may already perform another transfer.
    TEST_ASSERT_EQUAL(STATUS_BUSY, canopen_sdo_client_result(client, NULL));
}

/// However a transfer ends, the device is free for the next one.
static void each_end_of_a_transfer_frees_its_device(void)
{
    static const uint8_t protocol[] = {0x60, 0x65, 0x01, 0};
    const pus_device_action_t read  = command(PUS_DEVICE_ACQUIRE, FIRST_NODE, protocol, NULL);
    static const uint8_t ends[]     = {0x4FU, 0x80U, 0x20U};
    for (size_t i = 0U; i < sizeof ends; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, begin(DRIVES_ACCESS_SLOTS - 1U, &read)); // The last slot can be used.
        answer(ends[i], "\0\0\0");
        (void)poll(DRIVES_ACCESS_SLOTS - 1U);
        TEST_ASSERT_EQUAL_UINT8(0U, drives.access.owners[0]);
        canopen_sdo_client_reset(client);
    }
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &read));
    drives.buses[0].network.is_running = false; // The access is abandoned while the network is stopped.
    port.abandon(port.context, 0U);
    canopen_sdo_client_reset(client);
    drives.buses[0].network.is_running = true;
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &read));
}

static void objects_have_at_most_the_octets_of_a_transfer(void)
{
    static const uint8_t most[]         = {0x60, 0x65, 0x01, SDO_OCTETS_MAX};
    static uint8_t data[SDO_OCTETS_MAX] = {7U};
    pus_device_action_t write           = command(PUS_DEVICE_COMMAND, FIRST_NODE, most, NULL);
    const pus_device_action_t read      = command(PUS_DEVICE_ACQUIRE, FIRST_NODE, most, NULL);
    write.data                          = data;
    write.size                          = sizeof data;
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &write));
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &read));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &write));
    TEST_ASSERT_TRUE(canopen_sdo_client_request(client, 1U, frame));
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x21, 0x65, 0x60, 0x01, SDO_OCTETS_MAX, 0, 0, 0}), frame,
                                 8U);
}

static void registers_exist_for_the_nodes_of_the_network(void)
{
    pus_device_action_t dump = {.kind = PUS_DEVICE_DUMP_REGISTER, .address = (0xFFU << 24U) | 0x606500U};
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, port.check(port.context, &dump));
    dump.address = (SECOND_NODE << 24U) | 0x606500U;
    TEST_ASSERT_EQUAL(STATUS_OK, port.check(port.context, &dump));
    TEST_ASSERT_EQUAL(STATUS_OK, begin(0U, &dump));
    TEST_ASSERT_EQUAL_UINT8(0U, drives.access.owners[0]);
    TEST_ASSERT_EQUAL_UINT8(1U, drives.access.owners[1]);
    TEST_ASSERT_EQUAL(STATUS_EMPTY, canopen_sdo_client_result(client, NULL));
    dump.kind = PUS_DEVICE_LOAD_REGISTER; // A register has four octets.
    dump.data = frame;
    dump.size = 3U;
    TEST_ASSERT_EQUAL(STATUS_OUT_OF_RANGE, port.check(port.context, &dump));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(objects_are_written);
    RUN_TEST(objects_are_read);
    RUN_TEST(registers_are_accessed_by_number);
    RUN_TEST(a_command_with_an_invalid_device_or_address_is_refused);
    RUN_TEST(an_sdo_abort_of_the_device_is_reported);
    RUN_TEST(a_node_has_one_transfer_at_a_time);
    RUN_TEST(commissioning_ends_a_transfer);
    RUN_TEST(each_end_of_a_transfer_frees_its_device);
    RUN_TEST(objects_have_at_most_the_octets_of_a_transfer);
    RUN_TEST(registers_exist_for_the_nodes_of_the_network);
    return UNITY_END();
}
