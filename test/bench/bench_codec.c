// SPDX-License-Identifier: Apache-2.0
/// Checksum, octet codec and packets. Baselines: the checksum octet by octet; shifts without bounds; the
/// checksum of the packet.
#include "fsw/framework/base/crc.h"
#include "fsw/framework/base/octets.h"
#include "pus/packet.h"
#include "test/bench/measure.h"

#include <stdlib.h>

#define TEXT_OCTETS 1024U
#define WORDS 64U
#define PACKET_DATA 64U

static uint8_t text[TEXT_OCTETS];
static uint8_t packet[256];
static size_t packet_size;
static uint32_t words[WORDS];
static uint32_t octet_table[256]; ///< Effect of each octet on the checksum.
static volatile uint32_t sink;    // Keeps the compiler from dropping the work.

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

static void octets_there_and_back(void)
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

static void shifts_there_and_back(void)
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

static void packet_there_and_back(void)
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

int main(void)
{
    for (size_t i = 0U; i < sizeof text; i++) {
        text[i] = (uint8_t)(i * 7U);
    }
    fill_octet_table();
    measure_compare("crc16_1024_octets", crc_of_text, crc_octet_by_octet, 1.0, "ns", 1.0);
    measure_compare("octets_64_words_there_and_back", octets_there_and_back, shifts_there_and_back, 1.0, "ns",
                    1.0);
    packet_there_and_back();
    measure_compare("packet_encode_and_decode", packet_there_and_back, two_checksums_of_the_packet, 1.0, "ns",
                    1.0);
    return 0;
}
