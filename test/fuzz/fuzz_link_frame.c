// SPDX-License-Identifier: Apache-2.0
// A data frame of a real-time link that is accepted and encoded again has the same octets. A consumer accepts
// frames of its own link, epoch and layout only, and its sequence count never goes back (modulo 2^32). Each
// record is a frame.
#include "base/crc.h"
#include "fsw/framework/rtlink/link_channel.h"
#include "test/fuzz/fuzz.h"

#include <string.h>

#define LINK 3U
#define EPOCH 2U
#define PAYLOAD 16U

/// Check that an accepted frame is of the consumer's link and epoch, and that an old one does not change the
/// sequence count.
static void check_accepted(const rtlink_consumer_t* const consumer, const rtlink_counters_t* const before,
                           const fuzz_record_t* const record)
{
    rtlink_frame_header_t header = {0};
    const uint8_t* payload       = NULL;
    FUZZ_CHECK(rtlink_frame_decode(record->octets, record->size, PAYLOAD, true, &header, &payload) ==
               STATUS_OK);
    FUZZ_CHECK((header.link == LINK) && (header.epoch == EPOCH));
    const uint32_t ahead = consumer->counters.last_sequence - before->last_sequence;
    FUZZ_CHECK((before->frames == 0U) || (ahead <= (UINT32_MAX / 2U)));
}

static void check_frame(const fuzz_record_t* const record)
{
    rtlink_frame_header_t header;
    const uint8_t* payload = NULL;
    uint8_t again[LINK_FRAME_MAX];
    const bool with_crc       = ((record->kind & 1U) != 0U);
    const size_t payload_size = 1U + record->argument;
    if (rtlink_frame_decode(record->octets, record->size, payload_size, with_crc, &header, &payload) ==
        STATUS_OK) {
        const size_t size = rtlink_frame_encode(&header, payload, payload_size, with_crc, again);
        FUZZ_CHECK((size == record->size) && (memcmp(again, record->octets, size) == 0));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    static rtlink_consumer_t consumer;
    const rtlink_resolver_t resolver = {.context = NULL};
    const rtlink_terms_t terms       = {.layout_hash   = 1U,
                                        .layout_octets = PAYLOAD,
                                        .order         = (uint8_t)RTLINK_LITTLE_ENDIAN,
                                        .period_us     = 500U,
                                        .methods       = 1U << RTLINK_METHOD_UDP,
                                        .decimation    = 1U,
                                        .max_age_us    = 2000U};
    (void)memset(&consumer, 0, sizeof consumer);
    FUZZ_CHECK(rtlink_consumer_open(&consumer, &resolver, LINK, &terms, EPOCH) == STATUS_OK);
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    uint64_t now_ns = 0U;
    while (fuzz_next(&input, &record)) {
        check_frame(&record);
        const rtlink_counters_t before = consumer.counters;
        const status_t status          = rtlink_consumer_deliver(&consumer, record.octets, record.size);
        FUZZ_CHECK((status == STATUS_OK) || (status == STATUS_INVALID));
        FUZZ_CHECK((status == STATUS_OK) || (consumer.counters.refused == (before.refused + 1U)));
        if (status == STATUS_OK) {
            check_accepted(&consumer, &before, &record);
        }
        now_ns += (uint64_t)record.argument * 100000U;
        const status_t read = rtlink_consumer_read(&consumer, now_ns);
        FUZZ_CHECK((read == STATUS_OK) || (read == STATUS_EMPTY) || (read == STATUS_STALE));
    }
    rtlink_consumer_close(&consumer);
    return 0;
}

static void repair(const uint8_t kind, uint8_t* const octets, const size_t size, uint32_t* const random)
{
    static const uint8_t head[] = {0x52U, 0x54U, 1U}; // Magic number and version.
    if (size < (LINK_FRAME_HEADER_OCTETS + LINK_FRAME_CRC_OCTETS)) {
        return;
    }
    (void)memcpy(octets, head, sizeof head);
    octets[6] = 0U; // Flags.
    octets[7] = 0U;
    if ((fuzz_random(random) % 4U) != 0U) {
        static const uint8_t ids[] = {0U, LINK};
        (void)memcpy(&octets[4], ids, sizeof ids);
        (void)memset(&octets[8], 0, 4U);
        octets[11] = EPOCH;
    }
    if ((kind & 1U) != 0U) {
        const uint32_t crc = crc32_iso(octets, size - LINK_FRAME_CRC_OCTETS);
        for (size_t i = 0U; i < LINK_FRAME_CRC_OCTETS; i++) {
            octets[size - 1U - i] = (uint8_t)(crc >> (8U * i));
        }
    }
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, repair);
}
