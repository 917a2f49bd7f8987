// SPDX-License-Identifier: Apache-2.0
/// Time of the checksum, the octet codec and packets. Baselines: the checksum octet by octet; shifts without
/// checks of bounds; the checksum of the packet. If the library spacepackets is built
/// (test/bench/peers/spacepackets), it encodes and decodes the same three packets as another baseline, and
/// must give the same octets.
#include "base/crc.h"
#include "base/octets.h"
#include "pus/core/packet.h"
#include "test/bench/measure.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TEXT_OCTETS 1024U
#define WORDS 64U
#define PACKET_DATA 64U
#define REPORT_DATA 66U  ///< TM[3,25]: structure and 64 octets of values.
#define REQUEST_DATA 20U ///< TC[8,1]: function, number of arguments, one of 8 octets with its id.
#define TIME_NS 2086000000123456789ULL
#define PEER "build/peers/spacepackets/target/release/libcodec_spacepackets.so"

static uint8_t text[TEXT_OCTETS];
static uint8_t packet[256];
static size_t packet_size;
static uint32_t words[WORDS];
static uint32_t octet_table[256]; ///< Effect of each octet on the checksum.
static volatile uint32_t sink;    // Keeps the compiler from removing the work.

static void crc_of_text(void)
{
    sink = crc16_ccitt(text, sizeof text);
}

static void fill_octet_table(void)
{
    for (uint32_t octet = 0U; octet < 256U; octet++) {
        uint32_t crc = octet << 8U;
        for (unsigned bit = 0U; bit < 8U; bit++) {
            crc = ((crc << 1U) ^ (((crc & 0x8000U) != 0U) ? 0x1021U : 0U)) & 0xFFFFU;
        }
        octet_table[octet] = crc;
    }
}

static void crc_octet_by_octet(void)
{
    uint32_t crc = 0xFFFFU;
    for (size_t i = 0U; i < sizeof text; i++) {
        crc = ((crc << 8U) & 0xFFFFU) ^ octet_table[(crc >> 8U) ^ text[i]];
    }
    sink = crc;
}

static void octets_round_trip(void)
{
    octet_writer_t writer = octet_writer(text, sizeof text);
    for (size_t i = 0U; i < WORDS; i++) {
        octet_write_u32(&writer, words[i]);
    }
    octet_reader_t reader = octet_reader(text, writer.position);
    uint32_t sum          = 0U;
    for (size_t i = 0U; i < WORDS; i++) {
        sum += octet_read_u32(&reader);
    }
    sink = sum;
}

static void shifts_round_trip(void)
{
    for (size_t i = 0U; i < WORDS; i++) {
        text[(4U * i) + 0U] = (uint8_t)(words[i] >> 24U);
        text[(4U * i) + 1U] = (uint8_t)((words[i] >> 16U) & 0xFFU);
        text[(4U * i) + 2U] = (uint8_t)((words[i] >> 8U) & 0xFFU);
        text[(4U * i) + 3U] = (uint8_t)(words[i] & 0xFFU);
    }
    uint32_t sum = 0U;
    for (size_t i = 0U; i < WORDS; i++) {
        const uint8_t* const next = &text[4U * i];
        sum += ((uint32_t)next[0] << 24U) | ((uint32_t)next[1] << 16U) | ((uint32_t)next[2] << 8U) | next[3];
    }
    sink = sum;
}

static void packet_round_trip(void)
{
    const pus_tc_t tc = {
        .apid = 16U, .service = 8U, .subtype = 1U, .source = 1U, .data = text, .size = PACKET_DATA};
    pus_tc_t back;
    pus_failure_t failure;
    if ((pus_tc_encode(&tc, packet, sizeof packet, &packet_size) != STATUS_OK) ||
        (pus_tc_decode(packet, packet_size, &back, &failure) != STATUS_OK)) {
        abort();
    }
    sink = back.apid;
}

static void two_checksums_of_the_packet(void)
{
    sink = (uint32_t)crc16_ccitt(packet, packet_size) ^ crc16_ccitt(packet, packet_size);
}

static void encode_and_decode_report(void)
{
    const pus_tm_t tm = {.apid        = 16U,
                         .sequence    = 7U,
                         .service     = 3U,
                         .subtype     = 25U,
                         .counter     = 9U,
                         .destination = 1U,
                         .time_ns     = TIME_NS,
                         .data        = text,
                         .size        = REPORT_DATA};
    pus_tm_t back;
    pus_failure_t failure;
    if ((pus_tm_encode(&tm, packet, sizeof packet, &packet_size) != STATUS_OK) ||
        (pus_tm_decode(packet, packet_size, &back, &failure) != STATUS_OK) || (back.size != REPORT_DATA)) {
        abort();
    }
    sink = (uint32_t)back.apid + back.sequence + back.service + back.subtype + back.counter +
           back.destination + (uint32_t)back.time_ns;
}

static size_t encode_request(uint8_t service, uint8_t subtype, const uint8_t* data, size_t size,
                             uint8_t* octets, size_t capacity)
{
    const pus_tc_t tc = {.apid     = 16U,
                         .sequence = 7U,
                         .ack      = PUS_ACK_ALL,
                         .service  = service,
                         .subtype  = subtype,
                         .source   = 1U,
                         .data     = data,
                         .size     = size};
    size_t written    = 0U;
    if (pus_tc_encode(&tc, octets, capacity, &written) != STATUS_OK) {
        abort();
    }
    return written;
}

static pus_tc_t decode_request(const uint8_t* octets, size_t size)
{
    pus_tc_t tc;
    pus_failure_t failure;
    if (pus_tc_decode(octets, size, &tc, &failure) != STATUS_OK) {
        abort();
    }
    sink = (uint32_t)tc.apid + tc.sequence + tc.ack + tc.service + tc.subtype + tc.source;
    return tc;
}

static void encode_and_decode_request(void)
{
    packet_size = encode_request(8U, 1U, text, REQUEST_DATA, packet, sizeof packet);
    if (decode_request(packet, packet_size).size != REQUEST_DATA) {
        abort();
    }
}

/// TC[11,4]: sub-schedule, number of activities, group, release time, request.
static void encode_and_decode_schedule(void)
{
    uint8_t list[sizeof packet];
    octet_writer_t writer = octet_writer(list, sizeof list);
    octet_write_u16(&writer, 3U);
    octet_write_u8(&writer, 1U);
    octet_write_u16(&writer, 5U);
    pus_time_write(&writer, TIME_NS);
    const size_t begin = writer.position;
    const size_t size  = encode_request(8U, 1U, text, REQUEST_DATA, &list[begin], sizeof list - begin);
    packet_size        = encode_request(11U, 4U, list, begin + size, packet, sizeof packet);

    const pus_tc_t outer  = decode_request(packet, packet_size);
    octet_reader_t reader = octet_reader(outer.data, outer.size);
    const uint32_t ids = (uint32_t)octet_read_u16(&reader) + octet_read_u8(&reader) + octet_read_u16(&reader);
    uint64_t time_ns   = 0U;
    if (pus_time_read(&reader, &time_ns) != STATUS_OK) {
        abort();
    }
    const size_t left    = octet_reader_left(&reader);
    const pus_tc_t inner = decode_request(octet_read_octets(&reader, left), left);
    if (inner.size != REQUEST_DATA) {
        abort();
    }
    sink = ids + (uint32_t)time_ns;
}

// Types of the functions of the peer's library, which documents them.
typedef size_t tm_codec_t(const uint8_t* data, size_t size, uint64_t time_ns, uint8_t* octets,
                          size_t capacity);
typedef size_t tc_codec_t(const uint8_t* data, size_t size, uint8_t* octets, size_t capacity);

static struct {
    tm_codec_t* tm;
    tc_codec_t* tc;
    tm_codec_t* schedule;
    uint8_t packet[256];
    size_t size;
} peer;

static void report_by_peer(void)
{
    peer.size = peer.tm(text, REPORT_DATA, TIME_NS, peer.packet, sizeof peer.packet);
}

static void request_by_peer(void)
{
    peer.size = peer.tc(text, REQUEST_DATA, peer.packet, sizeof peer.packet);
}

static void schedule_by_peer(void)
{
    peer.size = peer.schedule(text, REQUEST_DATA, TIME_NS, peer.packet, sizeof peer.packet);
}

static bool load_peer(void)
{
    void* const library = dlopen(PEER, RTLD_NOW);
    if (library == NULL) {
        return false;
    }
    *(void**)(void*)&peer.tm       = dlsym(library, "spacepackets_tm");
    *(void**)(void*)&peer.tc       = dlsym(library, "spacepackets_tc");
    *(void**)(void*)&peer.schedule = dlsym(library, "spacepackets_schedule");
    return (peer.tm != NULL) && (peer.tc != NULL) && (peer.schedule != NULL);
}

static void compare_with_peer(const char* name, void (*ours)(void), void (*theirs)(void))
{
    if (peer.schedule == NULL) {
        (void)printf("SKIPPED %s spacepackets is not built\n", name);
        return;
    }
    ours();
    theirs();
    if ((packet_size != peer.size) || (memcmp(packet, peer.packet, packet_size) != 0)) {
        (void)fprintf(stderr, "bench_codec: %s: the packets differ\n", name);
        exit(1);
    }
    measure_compare(name, ours, theirs, 1.0, "ns", 1.0);
}

static void compare_packets(void)
{
    if (!load_peer()) {
        peer.schedule = NULL;
    }
    compare_with_peer("packet_tm_3_25_by_spacepackets", encode_and_decode_report, report_by_peer);
    compare_with_peer("packet_tc_8_1_by_spacepackets", encode_and_decode_request, request_by_peer);
    compare_with_peer("packet_tc_11_4_by_spacepackets", encode_and_decode_schedule, schedule_by_peer);
}

int main(void)
{
    for (size_t i = 0U; i < sizeof text; i++) {
        text[i] = (uint8_t)(i * 7U);
    }
    fill_octet_table();
    measure_compare("crc16_1024_octets", crc_of_text, crc_octet_by_octet, 1.0, "ns", 1.0);
    measure_compare("octets_64_words_round_trip", octets_round_trip, shifts_round_trip, 1.0, "ns", 1.0);
    packet_round_trip();
    measure_compare("packet_encode_and_decode", packet_round_trip, two_checksums_of_the_packet, 1.0, "ns",
                    1.0);
    compare_packets();
    return 0;
}
