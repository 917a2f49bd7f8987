// SPDX-License-Identifier: Apache-2.0
#include "test/unit/pus/parameters.h"

#include "unity.h"

#include <string.h>

dictionary_t dictionary;

static const struct {
    uint32_t id;
    uint16_t size;
} known[] = {
    {P_U8, 1U},    {P_U16, 2U},   {P_DOUBLE, 8U}, {P_STRUCT, 11U},  {P_SECRET, 2U},
    {P_FIXED, 4U}, {P_LIMIT, 1U}, {P_LOCKED, 1U}, {P_LARGE, 2000U}, {P_ODD, 1U},
};

#define KNOWN_COUNT ((uint32_t)(sizeof(known) / sizeof(known[0])))

static status_t find(void* const context, const uint32_t id, uint16_t* const out_handle,
                     uint16_t* const out_size)
{
    TEST_ASSERT_EQUAL_PTR(&dictionary, context);
    for (size_t i = 0U; i < KNOWN_COUNT; i++) {
        if (known[i].id == id) {
            *out_handle = (uint16_t)i;
            *out_size   = known[i].size;
            return (id == P_SECRET) ? STATUS_FORBIDDEN : STATUS_OK;
        }
    }
    if ((id >= P_MANY) && (id < (P_MANY + 256U))) {
        *out_handle = (uint16_t)(KNOWN_COUNT + (id - P_MANY));
        *out_size   = 1U;
        return STATUS_OK;
    }
    return STATUS_NOT_FOUND;
}

static void read(void* const context, const uint16_t handle, octet_writer_t* const writer)
{
    TEST_ASSERT_EQUAL_PTR(&dictionary, context);
    const uint16_t size = (handle < KNOWN_COUNT) ? known[handle].size : 1U;
    dictionary.reads++;
    for (uint16_t i = 0U; i < size; i++) {
        octet_write_u8(writer, (uint8_t)(i + dictionary.tick));
    }
}

static status_t write(void* const context, const uint16_t handle, const uint8_t* const octets,
                      const size_t size)
{
    TEST_ASSERT_EQUAL_PTR(&dictionary, context);
    const uint32_t id = (handle < KNOWN_COUNT) ? known[handle].id : (P_MANY + handle - KNOWN_COUNT);
    if (id == P_FIXED) {
        return STATUS_READ_ONLY;
    }
    if ((id == P_LIMIT) && (octets[0] > 9U)) {
        return STATUS_OUT_OF_RANGE;
    }
    if (id == P_LOCKED) {
        return (octets[0] == 0U) ? STATUS_BUSY : STATUS_FORBIDDEN;
    }
    if (id == P_ODD) {
        return STATUS_INVALID;
    }
    dictionary.writes++;
    dictionary.written_id   = id;
    dictionary.written_size = size;
    memcpy(dictionary.written, octets, size);
    return STATUS_OK;
}

pus_parameter_port_t dictionary_port(void)
{
    memset(&dictionary, 0, sizeof(dictionary));
    return (pus_parameter_port_t){.context = &dictionary, .find = find, .read = read, .write = write};
}

void put_id(uint8_t* const octets, const uint32_t id)
{
    octet_writer_t writer = octet_writer(octets, 4U);
    octet_write_u32(&writer, id);
}
