// SPDX-License-Identifier: Apache-2.0
/// Request sequences under test (ST[21]), and the requests that their tests send.
#ifndef TEST_UNIT_PUS_SEQUENCED_H
#define TEST_UNIT_PUS_SEQUENCED_H

#include "pus/st21_sequences.h"

#define SEQUENCES 4U
#define BLOCKS_HERE 1000U
#define OCTETS_MAX 20000U
#define TICKS ((int64_t)PUS_TIME_TICKS_PER_S)
#define MS 1000000ULL
/// The name of a sequence is a letter and a q; as it stands in a failure.
#define DETAIL(letter) (((uint32_t)(letter) << 24U) | ((uint32_t)'q' << 16U))

typedef struct {
    pus_sequences_t service;
    pus_sequences_config_t config;
    pus_chains_t chains;
    uint8_t data[60000];   ///< Application data of the next request,
    octet_writer_t writer; ///< as written since sequenced_begin.
    struct {               ///< The file /seq/abc.
        uint8_t octets[30000];
        uint32_t size;
        status_t open_status;
        status_t read_status;
        unsigned open; ///< Files open now.
    } file;
} sequenced_t;

extern sequenced_t sequenced;

/// A bench, and a service with nothing loaded and without persistence.
void sequenced_set_up(void);
/// Begin anew with room for so many sequences and blocks.
void sequenced_start(uint16_t count, uint16_t blocks);
void sequenced_step(uint64_t uptime_ns);

/// Begin application data with a name.
void sequenced_begin(char letter);
/// A request of `size` octets of data, and its delay [ticks].
void sequenced_add(uint16_t sequence, size_t size, int64_t delay);
void sequenced_request(uint8_t subtype);
/// The same, and expect that it ends well without a report of its own.
void sequenced_expect_done(uint8_t subtype);
/// A request whose application data is a name.
void sequenced_command(uint8_t subtype, char letter);
/// Load a sequence of requests first, first + 1 .. with a delay of 10 ms each.
void sequenced_load(char letter, uint16_t first, uint8_t count);

/// The file has what is added from begin to end.
void sequenced_begin_file(uint8_t count);
void sequenced_end_file(void);
/// A file of requests that fill a packet each: more than a request may report.
void sequenced_make_long_file(void);
/// Ask for a load from the file.
void sequenced_reference(char letter, uint8_t subtype);

#endif // TEST_UNIT_PUS_SEQUENCED_H
