// SPDX-License-Identifier: Apache-2.0
// The archive reads the parts of a packet log while they are written, therefore in pieces: spool records
// (even kind) and lines (odd kind). It takes each complete record and keeps an incomplete one, so its buffer
// always has room for the next piece.
#define main packet_archive_main
#include "launcher/packet_archive_sqlite_main.c"
#undef main

#include "test/fuzz/fuzz.h"

#define LEAST_SPOOL 4U

static archive_t archive;

int LLVMFuzzerInitialize(int* const argc, char*** const argv)
{
    (void)argc;
    (void)argv;
    archive.directory = fuzz_directory("packet_archive");
    open_archive(&archive);
    FUZZ_CHECK(!archive.is_failed);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    static tail_t spool;
    static tail_t lines;
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    spool.held      = 0U;
    lines.held      = 0U;
    archive.doubled = 0U;
    FUZZ_CHECK(execute(&archive, "BEGIN"));
    while (fuzz_next(&input, &record)) {
        tail_t* const tail = ((record.kind % 2U) == 0U) ? &spool : &lines;
        const size_t room  = sizeof tail->buffer - tail->held;
        const size_t count = (record.size < CHUNK) ? record.size : CHUNK;
        FUZZ_CHECK(room >= CHUNK); // `fill` requires this.
        (void)memcpy(&tail->buffer[tail->held], record.octets, count);
        tail->held += count;
        ((record.kind % 2U) == 0U) ? take_spool(&archive, tail) : take_lines(&archive, tail);
    }
    FUZZ_CHECK(execute(&archive, "ROLLBACK"));
    return 0;
}

static void repair(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    if (((kind % 2U) != 0U) || (size < (LEAST_SPOOL + RECORD_HEADER))) {
        return;
    }
    const size_t length = size - LEAST_SPOOL;
    octets[0]           = 0U;
    octets[1]           = 0U;
    octets[2]           = (uint8_t)(length >> 8U);
    octets[3]           = (uint8_t)length;
    if ((fuzz_random(random) % 2U) == 0U) { // Numbers close together, so that some occur twice.
        (void)memset(&octets[LEAST_SPOOL], 0, 7U);
        octets[LEAST_SPOOL + 7U] &= 3U;
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, repair);
}
