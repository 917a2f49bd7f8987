// SPDX-License-Identifier: Apache-2.0
// Proves: reading one record from a medium of any content accesses nothing outside the buffer or beyond the
//     end of the medium. Only a record of an existing kind is accepted, with the sequence number and chain
//     that its position requires and with a correct checksum; then the position advances to the end of the
//     record. Otherwise the position does not change. A record that was written is read with the same octets.
// Bounds: media of 0..44 octets of any content, records of 0..8 octets, any position up to the end.
// Replaced: crc32_iso returns any value, the same in every call (test/proof/base/proof_crc32.c proves the
//     function); the medium is an array whose reads may fail.
// Sources: fsw/framework/journal/journal_record.c
// Options: --unwind 46
// Reduced: fsw/framework/journal/journal.h
//   - #define JOURNAL_RECORD_MAX 8192U
//   + #define JOURNAL_RECORD_MAX 8U
// Quick: yes
// Fault: fsw/framework/journal/journal_record.c
//   - return is_kind && (record->size <= JOURNAL_RECORD_MAX);
//   + return is_kind;
// Fault: fsw/framework/journal/journal_record.c
//   - (octets_u32_at(&buffer[CHAIN]) == position->chain);
//   + (octets_u32_at(&buffer[CHAIN]) >= position->chain);
// Fault: fsw/framework/journal/journal_record.c
//   - if (octets_u32_at(&buffer[end]) != crc) {
//   + if (octets_u32_at(&buffer[end]) < crc) {
#include "base/crc.h"
#include "base/octets.h"
#include "fsw/framework/journal/journal_record.h"
#include "test/proof/proof.h"

#define MEDIUM 44U
#define RECORD 8U

static uint8_t disk[MEDIUM];
static size_t end;
static uint32_t checksum;
static const uint8_t* summed; // The octets of the last checksum.
static size_t summed_size;

uint32_t crc32_iso(const uint8_t* const octets, const size_t size)
{
    PROVE(__CPROVER_r_ok(octets, size), "the checksum reads inside the buffer");
    summed      = octets;
    summed_size = size;
    return checksum;
}

static status_t read_disk(void* const context, const uint64_t offset, uint8_t* const octets,
                          const size_t size)
{
    (void)context;
    PROVE(__CPROVER_w_ok(octets, size), "what is read fits the buffer");
    if (nondet_bool()) {
        return STATUS_IO;
    }
    if ((offset > end) || (size > (end - offset))) {
        return STATUS_TRUNCATED;
    }
    for (size_t i = 0U; i < size; i++) {
        octets[i] = disk[offset + i];
    }
    return STATUS_OK;
}

static status_t write_disk(void* const context, const uint64_t offset, const uint8_t* const octets,
                           const size_t size)
{
    (void)context;
    PROVE(__CPROVER_r_ok(octets, size), "what is written is inside the buffer");
    ASSUME((offset + size) <= MEDIUM);
    for (size_t i = 0U; i < size; i++) {
        disk[offset + i] = octets[i];
    }
    end = (end < (offset + size)) ? (size_t)(offset + size) : end;
    return STATUS_OK;
}

static const medium_t medium = {.read = read_disk, .write = write_disk};
static uint8_t buffer[JOURNAL_RECORD_SIZE(JOURNAL_RECORD_MAX)];

static void prove_any_content(void)
{
    journal_position_t position;
    journal_record_t record;
    ASSUME(position.offset <= MEDIUM);
    const journal_position_t before = position;
    const status_t status           = journal_read_record(&medium, &position, &record, buffer);
    if (status == STATUS_OK) {
        const uint8_t* const octets = &disk[before.offset];
        PROVE((record.kind == JOURNAL_PUT) || (record.kind == JOURNAL_ERASE) ||
                  (record.kind == JOURNAL_COMMIT) || (record.kind == JOURNAL_MARK),
              "the kind exists");
        PROVE(octets_u32_at(&octets[4]) == before.sequence, "a record is the next in sequence");
        PROVE(octets_u32_at(&octets[12]) == before.chain, "a record has the chain of the record before it");
        PROVE(octets_u32_at(&octets[JOURNAL_OCTETS_AT + record.size]) == checksum, "the checksum is right");
        PROVE((summed == buffer) && (summed_size == (JOURNAL_OCTETS_AT + (size_t)record.size)),
              "the checksum is that of all octets of the record");
        PROVE((octets_u16_at(&octets[2]) == record.size) && (octets[0] == record.kind) &&
                  (octets[1] == record.table) && (octets_u32_at(&octets[8]) == record.key),
              "the record has the fields of the medium");
        PROVE((position.offset == (before.offset + JOURNAL_RECORD_SIZE((size_t)record.size))) &&
                  (position.offset <= end),
              "the position is the end of the record, inside the medium");
        PROVE((position.sequence == (before.sequence + 1U)) && (position.chain == checksum),
              "sequence and chain of the position advance");
    } else {
        PROVE((status == STATUS_EMPTY) || (status == STATUS_IO), "the status is one of the contract");
        PROVE((position.offset == before.offset) && (position.sequence == before.sequence) &&
                  (position.chain == before.chain),
              "the position does not change");
    }
}

static void prove_written(void)
{
    journal_position_t position   = journal_first_position(nondet_u32());
    journal_position_t again      = position;
    const journal_record_t record = {
        .kind = JOURNAL_PUT, .table = nondet_u8(), .size = nondet_u16(), .key = nondet_u32()};
    ASSUME(record.size <= RECORD);
    const size_t at     = any_size(RECORD - 1U);
    const uint8_t octet = buffer[JOURNAL_OCTETS_AT + at];
    if (journal_write_record(&medium, &position, &record, buffer) == STATUS_OK) {
        PROVE((summed == buffer) && (summed_size == (JOURNAL_OCTETS_AT + (size_t)record.size)),
              "the checksum that is written is that of all octets of the record");
        journal_record_t got;
        buffer[JOURNAL_OCTETS_AT + at] = nondet_u8();
        const status_t status          = journal_read_record(&medium, &again, &got, buffer);
        PROVE((status == STATUS_OK) || (status == STATUS_IO), "what is written is read again");
        PROVE(IMPLIES(status == STATUS_OK, (got.table == record.table) && (got.size == record.size) &&
                                               (got.key == record.key) && (again.offset == position.offset)),
              "the record is the same");
        PROVE(IMPLIES((status == STATUS_OK) && (at < record.size), buffer[JOURNAL_OCTETS_AT + at] == octet),
              "its octets are the same");
    }
}

void proof(void)
{
    for (size_t i = 0U; i < MEDIUM; i++) {
        disk[i] = nondet_u8();
    }
    for (size_t i = 0U; i < RECORD; i++) {
        buffer[JOURNAL_OCTETS_AT + i] = nondet_u8();
    }
    end      = any_size(MEDIUM);
    checksum = nondet_u32();
    if (nondet_bool()) {
        prove_any_content();
    } else {
        prove_written();
    }
}
