// SPDX-License-Identifier: Apache-2.0
// Arbitrary short texts are read as the address of an end node, or as a number of each type. The first octet
// selects which.
#include "base/number.h"
#include "base/text.h"
#include "base/value.h"
#include "fsw/framework/dataflow/endnode.h"
#include "test/fuzz/fuzz.h"

#include <stdlib.h>
#include <string.h>

static void check_address(const char* const words)
{
    osal_address_t address = {0U, 0U};
    if (flow_endnode_socket_address(words, &address) != STATUS_OK) {
        return;
    }
    char canonical[32]; // Reading and writing this text again gives the same text.
    text_t text = text_in(canonical, sizeof canonical);
    for (unsigned i = 0U; i < 4U; i++) {
        text_add_unsigned(&text, (address.ipv4 >> (24U - (8U * i))) & 0xFFU);
        text_add_character(&text, (i < 3U) ? '.' : ':');
    }
    text_add_unsigned(&text, address.port);
    osal_address_t again = {0U, 0U};
    FUZZ_CHECK(!text.cut && (flow_endnode_socket_address(canonical, &again) == STATUS_OK));
    FUZZ_CHECK((again.ipv4 == address.ipv4) && (again.port == address.port));
}

static void check_number(const value_type_t type, const char* const words)
{
    const char* rest = words;
    uint64_t memory  = 0U;
    status_t status  = STATUS_OK;
    while (status == STATUS_OK) {
        const char* const before = rest;
        status                   = number_read_value(&rest, type, &memory);
        FUZZ_CHECK((status == STATUS_OK) ? (rest > before) : (rest == before));
        FUZZ_CHECK((size_t)(rest - words) <= strlen(words));
        if ((status == STATUS_OK) && (type == VALUE_DOUBLE)) { // The C library reads the same value.
            double value = 0.0;
            (void)memcpy(&value, &memory, sizeof value);
            FUZZ_CHECK(value == strtod(before, NULL));
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    if (size < 1U) {
        return 0;
    }
    char* const words = malloc(size);
    FUZZ_CHECK(words != NULL);
    (void)memcpy(words, &data[1], size - 1U);
    words[size - 1U]      = '\0';
    const unsigned choice = data[0] % ((unsigned)VALUE_SCALARS + 1U);
    if (choice == (unsigned)VALUE_SCALARS) {
        check_address(words);
    } else {
        check_number((value_type_t)choice, words);
    }
    free(words);
    return 0;
}
