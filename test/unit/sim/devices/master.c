// SPDX-License-Identifier: Apache-2.0
#include "test/unit/sim/devices/master.h"

#include "unity.h"

#include <string.h>

static void hear(void* context, const osal_can_frame_t* frame)
{
    master_t* master = context;
    TEST_ASSERT_LESS_THAN_UINT(MASTER_HEARD_MAX, master->count);
    master->heard[master->count] = *frame;
    master->count++;
}

void master_open(master_t* master, bool classic)
{
    const bus_config_t config = {
        .nominal_bit_rate = 1000000U, .data_bit_rate = classic ? 0U : 5000000U, .seed = 1U};
    const bus_callbacks_t callbacks = {.on_frame = hear, .context = master};
    master->count                   = 0U;
    master->bus                     = bus_create(&config);
    TEST_ASSERT_NOT_NULL(master->bus);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_add_node(master->bus, &callbacks, &master->node));
}

void master_close(master_t* master)
{
    bus_destroy(master->bus);
    master->bus = NULL;
}

void master_wait(master_t* master, uint64_t ns)
{
    bus_run_until(master->bus, bus_now_ns(master->bus) + ns);
}

void master_send(master_t* master, uint32_t id, const void* data, uint8_t length)
{
    osal_can_frame_t frame = {.id = id, .length = length};
    if (length != 0U) {
        memcpy(frame.data, data, length);
    }
    TEST_ASSERT_EQUAL_INT(STATUS_OK, bus_submit(master->bus, master->node, &frame, 0U));
}

void master_nmt(master_t* master, uint8_t command, uint8_t node)
{
    const uint8_t data[] = {command, node};
    master_send(master, 0U, data, 2U);
    master_wait(master, 200U * MASTER_US);
}

void master_sync(master_t* master, uint64_t ns)
{
    master_send(master, 0x080U, NULL, 0U);
    master_wait(master, ns);
}

void master_forget(master_t* master)
{
    master->count = 0U;
}

unsigned master_heard(const master_t* master, uint32_t id)
{
    unsigned count = 0U;
    for (unsigned i = 0U; i < master->count; i++) {
        count += (master->heard[i].id == id) ? 1U : 0U;
    }
    return count;
}

const osal_can_frame_t* master_last(const master_t* master, uint32_t id)
{
    for (unsigned i = master->count; i > 0U; i--) {
        if (master->heard[i - 1U].id == id) {
            return &master->heard[i - 1U];
        }
    }
    return NULL;
}

bool master_request(master_t* master, uint8_t node, const uint8_t request[8], uint8_t answer[8])
{
    const unsigned before = master_heard(master, 0x580U + node);
    master_send(master, 0x600U + node, request, 8U);
    master_wait(master, 2U * MASTER_MS);
    if (master_heard(master, 0x580U + node) == before) {
        return false;
    }
    memcpy(answer, master_last(master, 0x580U + node)->data, 8U);
    return true;
}

static void put_multiplexer(uint8_t request[8], uint8_t command, uint16_t index, uint8_t subindex)
{
    memset(request, 0, 8U);
    request[0] = command;
    request[1] = (uint8_t)index;
    request[2] = (uint8_t)(index >> 8);
    request[3] = subindex;
}

uint32_t master_write(master_t* master, uint8_t node, uint16_t index, uint8_t subindex, uint32_t value,
                      uint8_t size)
{
    uint8_t request[8];
    uint8_t answer[8];
    put_multiplexer(request, (uint8_t)(0x23U | ((4U - size) << 2)), index, subindex);
    for (unsigned i = 0U; i < size; i++) {
        request[4U + i] = (uint8_t)(value >> (8U * i));
    }
    if (!master_request(master, node, request, answer)) {
        return UINT32_MAX;
    }
    TEST_ASSERT_EQUAL_MEMORY(&request[1], &answer[1], 3U);
    if (answer[0] == 0x80U) {
        return octets_u32(&answer[4]);
    }
    TEST_ASSERT_EQUAL_HEX8(0x60U, answer[0]);
    return 0U;
}

uint32_t master_read(master_t* master, uint8_t node, uint16_t index, uint8_t subindex, uint32_t* out_value)
{
    uint8_t request[8];
    uint8_t answer[8];
    put_multiplexer(request, 0x40U, index, subindex);
    if (!master_request(master, node, request, answer)) {
        return UINT32_MAX;
    }
    TEST_ASSERT_EQUAL_MEMORY(&request[1], &answer[1], 3U);
    if (answer[0] == 0x80U) {
        return octets_u32(&answer[4]);
    }
    *out_value = octets_u32(&answer[4]);
    return 0U;
}

uint16_t octets_u16(const uint8_t* octets)
{
    return (uint16_t)(octets[0] | (octets[1] << 8));
}

uint32_t octets_u32(const uint8_t* octets)
{
    return octets_u16(octets) | ((uint32_t)octets_u16(&octets[2]) << 16);
}
