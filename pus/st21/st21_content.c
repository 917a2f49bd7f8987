// SPDX-License-Identifier: Apache-2.0
#include "pus/st21/st21_content.h"

#include "base/assertion.h"
#include "pus/core/stored_request.h"

#include <string.h>

// The key of a record consists of this bit, slot << 16, and the number of the part.
#define KEY_PART 0x01000000U
#define SLOT_SHIFT 16U
#define PART_MASK 0xFFFFU
#define LENGTH_OFFSET 4U // Offset of the length field in a packet [octets].

void pus_sequences_init(sequences_t* const self, const pus_sequences_config_t* const config)
{
    FSW_ASSERT((self != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->release.send != NULL) && (config->sequences != NULL) && (config->chains != NULL));
    FSW_ASSERT((config->sequence_count >= 1U) && (config->sequence_count <= PUS_SEQUENCE_COUNT_MAX));
    (void)memset(self, 0, sizeof *self);
    self->config = *config;
    pus_sorted_index_init(&self->due, config->nodes);
    for (uint16_t i = 0U; i < config->sequence_count; i++) {
        config->sequences[i] = (sequence_t){0};
    }
}

bool sequences_is_loaded(const sequence_t* const sequence)
{
    return sequence->in_use && (sequence->content.size == sequence->expected);
}

uint16_t sequences_find(const sequences_t* const self, const uint64_t id)
{
    for (uint16_t i = 0U; i < self->config.sequence_count; i++) {
        if (sequences_is_loaded(&self->config.sequences[i]) && (self->config.sequences[i].id == id)) {
            return i;
        }
    }
    return NO_SEQUENCE;
}

/// Find a slot for a new sequence: a free slot, or one with a sequence that was not restored completely.
/// NO_SEQUENCE if there is none.
static uint16_t find_slot(const sequences_t* const self)
{
    for (uint16_t i = 0U; i < self->config.sequence_count; i++) {
        if (!sequences_is_loaded(&self->config.sequences[i])) {
            return i;
        }
    }
    return NO_SEQUENCE;
}

uint32_t sequences_detail(const uint64_t id)
{
    return (uint32_t)(id >> 32U);
}

// ---- Content: N, N x {request, delay} ----

pus_block_chain_reader_t sequences_entries(const sequence_t* const sequence, uint8_t* const out_count)
{
    pus_block_chain_reader_t reader = pus_block_chain_reader(&sequence->content);
    *out_count                      = 0U;
    (void)pus_block_chain_read(&reader, out_count, 1U);
    return reader;
}

size_t sequences_read_entry(pus_block_chain_reader_t* const reader, uint8_t* const out_octets,
                            int64_t* const out_delay)
{
    uint8_t delay[PUS_RELATIVE_TIME_SIZE];
    if (pus_block_chain_read(reader, out_octets, PUS_PRIMARY_HEADER_SIZE) < PUS_PRIMARY_HEADER_SIZE) {
        return 0U;
    }
    const size_t rest = (size_t)octets_u16_at(&out_octets[LENGTH_OFFSET]) + 1U;
    const size_t size = PUS_PRIMARY_HEADER_SIZE + rest;
    if ((size > PUS_SEQUENCE_REQUEST_MAX) ||
        (pus_block_chain_read(reader, &out_octets[PUS_PRIMARY_HEADER_SIZE], rest) < rest) ||
        (pus_block_chain_read(reader, delay, sizeof delay) < sizeof delay)) {
        return 0U;
    }
    octet_reader_t octets = octet_reader(delay, sizeof delay);
    *out_delay            = pus_relative_time_read(&octets);
    return size;
}

/// Check the content of a sequence. PUS_FAILURE_NONE, or the first failure with its octet offset.
static pus_failure_t check(sequences_t* const self, const sequence_t* const sequence)
{
    uint8_t count                   = 0U;
    pus_block_chain_reader_t reader = sequences_entries(sequence, &count);
    if (count == 0U) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    for (uint8_t i = 0U; i < count; i++) {
        const uint32_t offset = sequence->content.size - reader.left;
        int64_t delay         = 0;
        pus_tc_t tc;
        pus_failure_t failure;
        const size_t size = sequences_read_entry(&reader, self->octets, &delay);
        if ((size == 0U) || (pus_stored_request_decode(self->octets, size, &tc, &failure) != STATUS_OK)) {
            return pus_failure(PUS_FAILURE_EMBEDDED, offset);
        }
        if (delay < 0) {
            return pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset + (uint32_t)size);
        }
    }
    return (reader.left == 0U) ? pus_no_failure()
                               : pus_failure(PUS_FAILURE_OUT_OF_RANGE, sequence->content.size - reader.left);
}

// ---- Persistent records ----

/// Returns the number of records of a content. Each record has the identifier and the size of the whole
/// content, and a part of the content.
static uint32_t parts_of(const uint32_t size)
{
    return (size + (PUS_SEQUENCE_PIECE - 1U)) / PUS_SEQUENCE_PIECE;
}

static status_t erase_parts(const sequences_t* const self, const uint16_t slot, const uint32_t count)
{
    const pus_persistence_t* const port = self->config.persistence;
    status_t result                     = STATUS_OK;
    for (uint32_t part = 0U; (port != NULL) && (part < count); part++) {
        const uint32_t key    = KEY_PART | ((uint32_t)slot << SLOT_SHIFT) | part;
        const status_t status = port->erase(port->context, PUS_SERVICE_SEQUENCES, key);
        result                = (status == STATUS_IO) ? status : result;
    }
    return result;
}

static status_t put_parts(sequences_t* const self, const uint16_t slot)
{
    const pus_persistence_t* const port = self->config.persistence;
    const sequence_t* const sequence    = &self->config.sequences[slot];
    const uint32_t count                = parts_of(sequence->content.size);
    pus_block_chain_reader_t reader     = pus_block_chain_reader(&sequence->content);
    for (uint32_t part = 0U; (port != NULL) && (part < count); part++) {
        octet_writer_t writer = octet_writer(self->octets, PUS_SEQUENCE_RECORD_HEAD);
        octet_write_u64(&writer, sequence->id);
        octet_write_u32(&writer, sequence->content.size);
        const size_t size =
            pus_block_chain_read(&reader, &self->octets[PUS_SEQUENCE_RECORD_HEAD], PUS_SEQUENCE_PIECE);
        const status_t status =
            port->put(port->context, PUS_SERVICE_SEQUENCES, KEY_PART | ((uint32_t)slot << SLOT_SHIFT) | part,
                      self->octets, PUS_SEQUENCE_RECORD_HEAD + size);
        if (status != STATUS_OK) {
            // If the erasure also fails, a restart discards the incomplete sequence.
            (void)erase_parts(self, slot, part);
            return status;
        }
    }
    return STATUS_OK;
}

static void clear(sequences_t* const self, sequence_t* const sequence)
{
    pus_block_chain_free(self->config.chains, &sequence->content);
    *sequence = (sequence_t){0};
}

status_t sequences_unload(sequences_t* const self, const uint16_t slot)
{
    sequence_t* const sequence = &self->config.sequences[slot];
    const status_t status      = erase_parts(self, slot, parts_of(sequence->content.size));
    if (status == STATUS_OK) {
        clear(self, sequence);
    }
    return status;
}

/// Part of the content of a sequence, in a record.
typedef struct {
    uint64_t id;
    uint32_t expected; // Size of the whole content [octets].
    uint32_t part;
    const uint8_t* octets;
    size_t size;
} part_t;

/// True if the part continues the sequence, or begins it.
static bool is_next(const sequence_t* const sequence, const part_t* const part)
{
    const uint32_t so_far = sequence->content.size;
    const bool is_same    = (sequence->id == part->id) && (sequence->expected == part->expected);
    return (part->part == parts_of(so_far)) && ((so_far + part->size) <= part->expected) &&
           ((so_far == 0U) || is_same);
}

static status_t restore_part(sequences_t* const self, sequence_t* const sequence, const part_t* const part)
{
    if (sequences_is_loaded(sequence) || (sequences_find(self, part->id) != NO_SEQUENCE)) {
        return STATUS_EXISTS;
    }
    if (!is_next(sequence, part)) {
        return STATUS_INVALID;
    }
    const status_t status =
        pus_block_chain_append(self->config.chains, &sequence->content, part->octets, part->size);
    if (status != STATUS_OK) {
        return status;
    }
    sequence->in_use   = true;
    sequence->id       = part->id;
    sequence->expected = part->expected;
    if (sequences_is_loaded(sequence) && (check(self, sequence).code != (uint16_t)PUS_FAILURE_NONE)) {
        clear(self, sequence);
        return STATUS_INVALID;
    }
    return STATUS_OK;
}

status_t pus_sequences_restore(sequences_t* const self, const uint32_t key, const uint8_t* const octets,
                               const size_t size)
{
    FSW_ASSERT((self != NULL) && (octets != NULL));
    octet_reader_t reader = octet_reader(octets, size);
    const uint32_t slot   = (key & ~KEY_PART) >> SLOT_SHIFT;
    part_t part           = {.part = key & PART_MASK};
    part.id               = octet_read_u64(&reader);
    part.expected         = octet_read_u32(&reader);
    part.size             = octet_reader_left(&reader);
    part.octets           = octet_read_octets(&reader, part.size);
    if (((key & KEY_PART) == 0U) || reader.failed || (part.size == 0U)) {
        return STATUS_INVALID;
    }
    if ((slot >= self->config.sequence_count) || (part.expected > self->config.octets_max)) {
        return STATUS_EXHAUSTED;
    }
    return restore_part(self, &self->config.sequences[slot], &part);
}

// ---- Loading ----

/// True if an id is 1..8 printable characters, padded with NUL.
static bool is_name(const uint64_t id)
{
    bool is_good  = (id >> 56U) != 0U;
    bool is_ended = false;
    for (unsigned shift = 64U; shift > 0U; shift -= 8U) {
        const uint64_t letter = (id >> (shift - 8U)) & 0xFFU;
        is_good               = is_good &&
                  ((letter == 0U) || (!is_ended && (letter >= (uint64_t)' ') && (letter <= (uint64_t)'~')));
        is_ended = is_ended || (letter == 0U);
    }
    return is_good;
}

/// Find an empty slot for a new sequence. PUS_DONE, PUS_REFUSED.
static pus_reply_t begin(sequences_t* const self, const uint64_t id, const size_t size,
                         uint16_t* const out_slot)
{
    if (!is_name(id)) {
        return pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    }
    if (sequences_find(self, id) != NO_SEQUENCE) {
        return pus_refused(PUS_FAILURE_EXISTS, sequences_detail(id));
    }
    if (size > self->config.octets_max) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, self->config.octets_max);
    }
    *out_slot = find_slot(self);
    if (*out_slot == NO_SEQUENCE) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, self->config.sequence_count);
    }
    clear(self, &self->config.sequences[*out_slot]);
    self->config.sequences[*out_slot].id = id;
    return pus_done();
}

static pus_reply_t append(sequences_t* const self, const uint16_t slot, const uint8_t* const octets,
                          const size_t size)
{
    return (pus_block_chain_append(self->config.chains, &self->config.sequences[slot].content, octets,
                                   size) == STATUS_OK)
               ? pus_done()
               : pus_refused(PUS_FAILURE_TABLE_FULL, self->config.chains->pool.block_count);
}

/// End loading. If `reply` is PUS_DONE, the content is complete: check it and store the sequence. Otherwise
/// discard the content.
static pus_reply_t end(sequences_t* const self, const uint16_t slot, const size_t offset,
                       const pus_reply_t reply)
{
    sequence_t* const sequence = &self->config.sequences[slot];
    pus_reply_t result         = reply;
    if (result.kind == PUS_DONE) {
        const pus_failure_t failure = check(self, sequence);
        if (failure.code != (uint16_t)PUS_FAILURE_NONE) {
            result = pus_refused(failure.code, failure.detail + (uint32_t)offset);
        }
    }
    if (result.kind == PUS_DONE) {
        const status_t status = put_parts(self, slot);
        result = (status == STATUS_OK) ? pus_done() : pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
    if (result.kind == PUS_DONE) {
        sequence->in_use   = true;
        sequence->expected = sequence->content.size;
        self->counters.loaded++;
    } else {
        clear(self, sequence);
    }
    return result;
}

pus_reply_t sequences_load(sequences_t* const self, const uint64_t id, const uint8_t* const octets,
                           const size_t size, const size_t offset, uint16_t* const out_slot)
{
    const pus_reply_t reply = begin(self, id, size, out_slot);
    return (reply.kind == PUS_DONE) ? end(self, *out_slot, offset, append(self, *out_slot, octets, size))
                                    : reply;
}

static pus_reply_t reply_of_open(const status_t status)
{
    switch (status) {
    case STATUS_NOT_FOUND:
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, 0U);
    case STATUS_FORBIDDEN:
        return pus_refused(PUS_FAILURE_STATE, 0U);
    case STATUS_INVALID:
        return pus_refused(PUS_FAILURE_OUT_OF_RANGE, 0U);
    case STATUS_EXHAUSTED:
        return pus_refused(PUS_FAILURE_TABLE_FULL, 0U);
    default:
        return pus_failed(PUS_FAILURE_IO, (uint32_t)status);
    }
}

/// Read a file of `size` octets, and append the octets to the content.
static pus_reply_t read_file(sequences_t* const self, const uint16_t slot, const uint32_t file,
                             const uint32_t size)
{
    const pus_file_port_t* const port = self->config.files;
    pus_reply_t reply                 = pus_done();
    uint32_t done                     = 0U;
    while ((reply.kind == PUS_DONE) && (done < size)) {
        const uint32_t piece  = ((size - done) < PUS_SEQUENCE_PIECE) ? (size - done) : PUS_SEQUENCE_PIECE;
        const status_t status = port->read(port->context, file, done, self->octets, piece);
        reply                 = (status == STATUS_OK) ? append(self, slot, self->octets, piece)
                                                      : pus_failed(PUS_FAILURE_IO, (uint32_t)status);
        done += piece;
    }
    return reply;
}

pus_reply_t sequences_load_file(sequences_t* const self, const uint64_t id, const pus_file_name_t* const name,
                                uint16_t* const out_slot)
{
    const pus_file_port_t* const port = self->config.files;
    uint32_t file                     = 0U;
    uint32_t size                     = 0U;
    const status_t status = (port != NULL) ? port->open(port->context, name, &file, &size) : STATUS_NOT_FOUND;
    if (status != STATUS_OK) {
        return reply_of_open(status);
    }
    pus_reply_t reply = begin(self, id, size, out_slot);
    if (reply.kind == PUS_DONE) {
        reply = end(self, *out_slot, 0U, read_file(self, *out_slot, file, size));
    }
    (void)port->close(port->context, file); // No data was written, so the status does not matter.
    return reply;
}
