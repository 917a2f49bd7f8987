// SPDX-License-Identifier: Apache-2.0
#include "pus/st21/st21_sequences.h"

#include "base/assertion.h"
#include "base/crc.h"
#include "generated/pus/st21_request_formats.h"
#include "pus/st21/st21_content.h"

enum {
    STATUS_REPORT   = 7,
    CHECKSUM_REPORT = 10,
    CONTENT_REPORT  = 12,
    ABORTED_REPORT  = 14
};

#define NS_PER_S 1000000000ULL

// ---- Execution ----

static uint64_t ns_of(const int64_t delay)
{
    const uint64_t ticks = (uint64_t)delay;
    return ((ticks / PUS_TIME_TICKS_PER_S) * NS_PER_S) +
           (((ticks % PUS_TIME_TICKS_PER_S) * NS_PER_S) / PUS_TIME_TICKS_PER_S);
}

/// Make a sequence due at this uptime, after the sequences that are already due at the same time.
static void set_due(sequences_t* const self, const uint16_t slot, const uint64_t uptime_ns)
{
    pus_sorted_index_insert(&self->due, slot, uptime_ns, self->serial);
    self->serial++;
}

static void activate_slot(sequences_t* const self, const uint16_t slot)
{
    sequence_t* const sequence = &self->config.sequences[slot];
    sequence->next             = sequences_entries(sequence, &sequence->left);
    sequence->is_active        = true;
    sequence->is_late          = true; // The first delay starts in the next step.
    set_due(self, slot, self->uptime_ns);
    self->counters.activated++;
}

static void deactivate(sequences_t* const self, const uint16_t slot)
{
    pus_sorted_index_remove(&self->due, slot);
    self->config.sequences[slot].is_active = false;
}

/// Release the next request of a due sequence, or end the sequence after its last one. False: the port
/// refuses the request.
static bool run(sequences_t* const self, const uint16_t slot)
{
    sequence_t* const sequence = &self->config.sequences[slot];
    if (sequence->left == 0U) {
        deactivate(self, slot);
        self->counters.completed++;
        return true;
    }
    pus_block_chain_reader_t next = sequence->next;
    int64_t delay                 = 0;
    const size_t size             = sequences_read_entry(&next, self->octets, &delay);
    if (self->config.release.send(self->config.release.context, self->octets, size) != STATUS_OK) {
        sequence->is_late = true;
        self->counters.deferred++;
        return false;
    }
    const uint64_t start = sequence->is_late ? self->uptime_ns : self->config.nodes[slot].tag;
    sequence->next       = next;
    sequence->is_late    = false;
    sequence->left--;
    self->counters.released++;
    pus_sorted_index_remove(&self->due, slot);
    set_due(self, slot, start + ns_of(delay));
    return true;
}

uint64_t pus_sequences_next_ns(const sequences_t* const self)
{
    FSW_ASSERT(self != NULL);
    const uint16_t slot = pus_sorted_index_first(&self->due);
    return (slot != NO_SEQUENCE) ? self->config.nodes[slot].tag : UINT64_MAX;
}

bool pus_sequences_is_waiting(const sequences_t* const self)
{
    FSW_ASSERT(self != NULL);
    return self->report.is_active;
}

// ---- Requests ----

static pus_reply_t refuse(sequences_t* const self, const uint16_t code, const uint64_t id)
{
    self->counters.refused++;
    return pus_refused(code, sequences_detail(id));
}

/// Count a load that was refused or failed.
static pus_reply_t count(sequences_t* const self, const pus_reply_t reply)
{
    self->counters.refused += (reply.kind != PUS_DONE) ? 1U : 0U;
    return reply;
}

static pus_reply_t load(void* const object, pus_request_t* const request)
{
    sequences_t* const self      = object;
    octet_reader_t* const reader = &request->reader;
    const uint64_t id            = octet_read_u64(reader);
    const size_t offset          = reader->position;
    const size_t size            = octet_reader_left(reader);
    uint16_t slot                = NO_SEQUENCE;
    return count(self, sequences_load(self, id, octet_read_octets(reader, size), size, offset, &slot));
}

static pus_reply_t load_file(sequences_t* const self, octet_reader_t* const reader, uint16_t* const out_slot)
{
    const uint64_t id    = octet_read_u64(reader);
    pus_file_name_t name = {0};
    name.path_size       = octet_read_u16(reader);
    name.path            = octet_read_octets(reader, name.path_size);
    name.name_size       = octet_read_u16(reader);
    name.name            = octet_read_octets(reader, name.name_size);
    return count(self, sequences_load_file(self, id, &name, out_slot));
}

static pus_reply_t load_by_reference(void* const object, pus_request_t* const request)
{
    uint16_t slot = NO_SEQUENCE;
    return load_file(object, &request->reader, &slot);
}

static pus_reply_t load_and_activate(void* const object, pus_request_t* const request)
{
    uint16_t slot           = NO_SEQUENCE;
    const pus_reply_t reply = load_file(object, &request->reader, &slot);
    if (reply.kind == PUS_DONE) {
        activate_slot(object, slot);
    }
    return reply;
}

static pus_reply_t unload(void* const object, pus_request_t* const request)
{
    sequences_t* const self = object;
    const uint64_t id       = octet_read_u64(&request->reader);
    const uint16_t slot     = sequences_find(self, id);
    if (slot == NO_SEQUENCE) {
        return refuse(self, PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (self->config.sequences[slot].is_active || (self->report.is_active && (self->reported == slot))) {
        return refuse(self, PUS_FAILURE_STATE, id);
    }
    const status_t status = sequences_unload(self, slot);
    return (status == STATUS_OK) ? pus_done() : pus_failed(PUS_FAILURE_IO, (uint32_t)status);
}

static pus_reply_t activate(void* const object, pus_request_t* const request)
{
    sequences_t* const self = object;
    const uint64_t id       = octet_read_u64(&request->reader);
    const uint16_t slot     = sequences_find(self, id);
    if (slot == NO_SEQUENCE) {
        return refuse(self, PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (self->config.sequences[slot].is_active) {
        return refuse(self, PUS_FAILURE_STATE, id);
    }
    activate_slot(self, slot);
    return pus_done();
}

static pus_reply_t abort_one(void* const object, pus_request_t* const request)
{
    sequences_t* const self = object;
    const uint64_t id       = octet_read_u64(&request->reader);
    const uint16_t slot     = sequences_find(self, id);
    if (slot == NO_SEQUENCE) {
        return refuse(self, PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (!self->config.sequences[slot].is_active) {
        return refuse(self, PUS_FAILURE_STATE, id);
    }
    deactivate(self, slot);
    self->counters.aborted++;
    return pus_done();
}

static pus_reply_t abort_all(void* const object, pus_request_t* const request)
{
    sequences_t* const self = object;
    pus_request_perform(request);
    octet_writer_t writer = pus_list_begin(request, ABORTED_REPORT);
    uint16_t aborted      = 0U;
    for (uint16_t i = 0U; i < self->config.sequence_count; i++) {
        if (self->config.sequences[i].is_active) {
            deactivate(self, i);
            octet_write_u64(&writer, self->config.sequences[i].id);
            aborted++;
        }
    }
    self->counters.aborted += aborted;
    return pus_list_end(request, &writer, aborted);
}

// ---- Reports ----

// The list of all sequences, at most 255 entries of 9 octets, fits into one packet of 4096 octets. In a build
// with a smaller PUS_PACKET_MAX pus_list_end refuses a list that is too long.
static pus_reply_t report_status(void* const object, pus_request_t* const request)
{
    const sequences_t* const self = object;
    pus_request_perform(request);
    octet_writer_t writer = pus_list_begin(request, STATUS_REPORT);
    uint16_t listed       = 0U;
    for (uint16_t i = 0U; i < self->config.sequence_count; i++) {
        const sequence_t* const sequence = &self->config.sequences[i];
        if (sequences_is_loaded(sequence)) {
            octet_write_u64(&writer, sequence->id);
            octet_write_u8(&writer, sequence->is_active ? 1U : 0U);
            listed++;
        }
    }
    return pus_list_end(request, &writer, listed);
}

static pus_reply_t report_checksum(void* const object, pus_request_t* const request)
{
    sequences_t* const self = object;
    const uint64_t id       = octet_read_u64(&request->reader);
    const uint16_t slot     = sequences_find(self, id);
    if (slot == NO_SEQUENCE) {
        return refuse(self, PUS_FAILURE_UNKNOWN_ID, id);
    }
    pus_block_chain_reader_t reader = pus_block_chain_reader(&self->config.sequences[slot].content);
    uint16_t crc                    = CRC16_START;
    while (reader.left > 0U) {
        const size_t size = pus_block_chain_read(&reader, self->octets, sizeof self->octets);
        crc               = crc16_ccitt_more(crc, self->octets, size);
    }
    pus_request_perform(request);
    octet_writer_t writer = pus_answer_begin(request, CHECKSUM_REPORT);
    octet_write_u64(&writer, id);
    octet_write_u16(&writer, crc);
    (void)pus_tm_post(request->process, &writer); // The process counts lost reports.
    return pus_done();
}

/// Write the entry at the offset of the cursor in the content. False: no entry is left.
static bool write_entry(void* const object, pus_report_cursor_t* const cursor, octet_writer_t* const writer)
{
    sequences_t* const self          = object;
    const sequence_t* const sequence = &self->config.sequences[self->reported];
    pus_block_chain_reader_t reader  = pus_block_chain_reader(&sequence->content);
    int64_t delay                    = 0;
    pus_block_chain_skip(&reader, (size_t)cursor->first);
    if (reader.left == 0U) {
        return false;
    }
    pus_block_chain_reader_t ahead = reader;
    const size_t size = sequences_read_entry(&ahead, self->octets, &delay) + PUS_RELATIVE_TIME_SIZE;
    (void)pus_block_chain_read(&reader, self->octets, size);
    octet_write_octets(writer, self->octets, size);
    cursor->first += size;
    return true;
}

static pus_reply_t report_content(void* const object, pus_request_t* const request)
{
    static const pus_report_cursor_t first = {.first = 1U}; // Offset of the first entry, after the count.
    sequences_t* const self                = object;
    const pus_report_entries_t entries     = {.self = self, .write = write_entry};
    uint8_t front[sizeof(uint64_t)];
    const uint64_t id   = octet_read_u64(&request->reader);
    const uint16_t slot = sequences_find(self, id);
    if (slot == NO_SEQUENCE) {
        return refuse(self, PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (self->report.is_active) {
        return refuse(self, PUS_FAILURE_STATE, id);
    }
    octets_put_u64(front, id);
    self->reported = slot;
    return pus_long_report_begin(&self->report, request, CONTENT_REPORT, &entries, &first, front,
                                 sizeof front);
}

void pus_sequences_step(sequences_t* const self, const uint64_t now_ns, const uint64_t uptime_ns)
{
    FSW_ASSERT(self != NULL);
    bool is_taken   = true;
    self->uptime_ns = uptime_ns;
    for (unsigned i = 0U;
         (i < PUS_SEQUENCE_RELEASES) && is_taken && (pus_sequences_next_ns(self) <= uptime_ns); i++) {
        is_taken = run(self, pus_sorted_index_first(&self->due));
    }
    if (self->report.is_active) {
        const pus_report_entries_t entries = {.self = self, .write = write_entry};
        pus_long_report_go_on(&self->report, self->config.process, &entries, now_ns);
    }
}

pus_service_t pus_sequences_service(sequences_t* const self)
{
    static const pus_subtype_t subtypes[] = {PUS_REQUEST(21, 1, load),
                                             PUS_REQUEST(21, 2, load_by_reference),
                                             PUS_REQUEST(21, 3, unload),
                                             PUS_REQUEST(21, 4, activate),
                                             PUS_REQUEST(21, 5, abort_one),
                                             PUS_REQUEST(21, 6, report_status),
                                             PUS_REQUEST(21, 8, load_and_activate),
                                             PUS_REQUEST(21, 9, report_checksum),
                                             PUS_REQUEST(21, 11, report_content),
                                             PUS_REQUEST(21, 13, abort_all)};
    return pus_service_of(PUS_SERVICE_SEQUENCES, subtypes, sizeof subtypes / sizeof subtypes[0], self);
}
