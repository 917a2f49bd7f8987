// SPDX-License-Identifier: Apache-2.0
// The packet dump tool reads an arbitrary file in each of its formats, and prints a line for each packet to
// /dev/null. The first octet of the input selects format and style.
#include "pus/tool/pusdump_input.h"
#include "test/fuzz/fuzz.h"

#include <stdio.h>

int LLVMFuzzerInitialize(int* const argc, char*** const argv)
{
    (void)argc;
    (void)argv;
    FUZZ_CHECK(freopen("/dev/null", "w", stdout) != NULL);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    if (size == 0U) {
        return 0;
    }
    FILE* const stream       = fopen(fuzz_file(&data[1], size - 1U), "r");
    const dump_style_t style = {
        .as_json = ((data[0] & 4U) != 0U), .epoch_ns = 1000000000U, .has_epoch = ((data[0] & 8U) != 0U)};
    FUZZ_CHECK(stream != NULL);
    (void)dump_stream(stream, (dump_format_t)(data[0] & 3U), &style);
    FUZZ_CHECK(fclose(stream) == 0);
    return 0;
}
