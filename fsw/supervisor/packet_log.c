// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/packet_log.h"

#include "base/assertion.h"
#include "base/capacities.h"
#include "base/octets.h"
#include "base/text.h"
#include "osal/include/osal/clock.h"
#include "pus/core/tailoring.h"

#include <stddef.h>
#include <string.h>

#define LENGTH_OCTETS 4U
#define RECORD_HEADER 17U
#define RECORD_MAX (RECORD_HEADER + PUS_PACKET_MAX)
#define RECORD_SHORT (RECORD_HEADER + PUS_TC_MIN) ///< Record of the shortest packet.
#define LINE_MAX_CHARACTERS (64U + (2U * PUS_PACKET_MAX))
#define DIRECTION_TC 0U
#define DIRECTION_TM 1U
#define DIRECTION_GAP 2U

#define PAUSE_FIRST_NS 1000000000ULL ///< Pause before the file is opened again; each failure doubles it.
#define PAUSE_LAST_NS 32000000000ULL ///< Longest pause.
#define HEALTHY_NS 60000000000ULL    ///< After this time without a failure the first pause applies again.
#define LOOK_NS 1000000000ULL        ///< Time between two checks that the file still has its name.
#define SLOW_NS 1000000000ULL        ///< If a write takes longer, the ring replaces the file.

CAPACITY_CHECK(ring_holds_what_a_mission_may_ask_for,
               PACKET_LOG_RING_OCTETS >= (CAPACITY_RING_RECORDS * (LENGTH_OCTETS + RECORD_SHORT)));
CAPACITY_CHECK(a_line_fits_after_a_gap, PACKET_LOG_PIECE > (2U * LINE_MAX_CHARACTERS));

// ---- Records ----

/// Encode the header of a record; the packet follows it.
static void encode_header(uint8_t out_header[RECORD_HEADER], const uint64_t number, const uint64_t time_ns,
                          const uint8_t direction)
{
    octets_put_u64(out_header, number);
    octets_put_u64(&out_header[sizeof number], time_ns);
    out_header[RECORD_HEADER - 1U] = direction;
}

/// Add the line of a record in the format ASCII.
static void add_line(text_t* const text, const uint8_t* const record, const size_t size)
{
    octet_reader_t reader   = octet_reader(record, size);
    const uint64_t number   = octet_read_u64(&reader);
    const uint64_t time_ns  = octet_read_u64(&reader);
    const uint8_t direction = octet_read_u8(&reader);
    text_add_unsigned(text, number);
    text_add_character(text, ' ');
    if (direction == DIRECTION_GAP) {
        text_add_unsigned(text, time_ns); // In a gap record: number of the last record.
        text_add(text, " GAP");
    } else {
        text_add_seconds(text, time_ns);
        text_add(text, (direction == DIRECTION_TC) ? " TC " : " TM ");
        text_add_octets(text, &record[RECORD_HEADER], size - RECORD_HEADER);
    }
    text_add_character(text, '\n');
    FSW_ASSERT(!text->cut);
}

// ---- Files ----

static void path_of(const packet_log_t* const log, const packet_log_strategy_t strategy,
                    char out_path[PACKET_LOG_PATH + 32U])
{
    static const char* const names[PACKET_LOG_STRATEGIES] = {"packets.ascii", "packets.spool", "",
                                                             "packets.ring"};
    text_t text                                           = text_in(out_path, PACKET_LOG_PATH + 32U);
    text_add(&text, log->directory);
    text_add(&text, "/");
    text_add(&text, names[strategy]);
    FSW_ASSERT(!text.cut); // The length of the directory's name was checked when the log was opened.
}

/// Open the file of a strategy, to continue after its last complete record.
static status_t open_file(const packet_log_t* const log, osal_file_t* const file, packet_log_job_t* const job)
{
    char path[PACKET_LOG_PATH + 32U];
    uint64_t size = 0U;
    path_of(log, job->strategy, path);
    status_t status = osal_file_append(file, path);
    if (status != STATUS_OK) {
        return status;
    }
    status = osal_file_size(file, &size);
    if ((status == STATUS_OK) && job->is_cut && (size > job->size)) {
        size   = job->size;
        status = osal_file_resize(file, size);
    }
    if (status != STATUS_OK) {
        osal_file_close(file);
        return STATUS_IO;
    }
    job->size   = size;
    job->is_cut = false;
    return STATUS_OK;
}

/// Write the whole piece. If that fails, cut off the part that was written.
static status_t write_piece(packet_log_t* const log)
{
    packet_log_job_t* const job = &log->job;
    const uint64_t start_ns     = osal_clock_monotonic_ns();
    const status_t status       = osal_file_write(&log->file, log->piece, job->octets);
    job->took_ns                = osal_clock_monotonic_ns() - start_ns;
    if (status == STATUS_OK) {
        job->size += job->octets;
    } else {
        job->is_cut = (osal_file_resize(&log->file, job->size) != STATUS_OK);
    }
    return status;
}

/// Perform the job, which may wait for the disk. The writer calls this function; without a writer, the
/// supervisor's loop does.
static void do_job(packet_log_t* const log)
{
    packet_log_job_t* const job = &log->job;
    if (job->kind == PACKET_LOG_OPEN) {
        job->status = open_file(log, &log->file, job);
        return;
    }
    if (job->kind == PACKET_LOG_WRITE) {
        job->status = write_piece(log);
    } else { // Check that the file was not removed: further writes would be lost.
        job->status = osal_file_is_named(&log->file) ? STATUS_OK : STATUS_NOT_FOUND;
    }
    if (job->status != STATUS_OK) {
        osal_file_close(&log->file);
    }
}

static void close_file(packet_log_t* const log)
{
    if (log->is_open) {
        osal_file_close(&log->file);
        log->is_open = false;
    }
}

// ---- Ring ----

/// Returns the number of the oldest record in the ring; if it is empty, that of the next record.
static uint64_t oldest_number(const packet_log_t* const log)
{
    uint8_t number[8];
    size_t size           = 0U;
    const status_t status = message_ring_peek(&log->ring, number, sizeof number, &size);
    return (status == STATUS_OK) ? octets_u64_at(number) : log->next_number;
}

static void drop_oldest(packet_log_t* const log)
{
    uint8_t oldest[RECORD_MAX];
    size_t size           = 0U;
    const status_t status = message_ring_take(&log->ring, oldest, sizeof oldest, &size);
    FSW_ASSERT(status == STATUS_OK);
}

/// Let the ring replace the file from now on; the waiting records may still be written to the file.
static void switch_to_ring(packet_log_t* const log)
{
    log->strategy     = PACKET_LOG_RING;
    log->first_number = oldest_number(log);
    log->file_first   = log->first_number;
}

/// React to a failure of the file: use the ring, and open the file again after a pause.
static void fall_back(packet_log_t* const log)
{
    const bool was_healthy =
        (log->strategy == log->wanted) && ((log->now_ns - log->resumed_ns) >= HEALTHY_NS);
    log->pause_ns = was_healthy ? PAUSE_FIRST_NS : (log->pause_ns * 2U);
    log->pause_ns = (log->pause_ns < PAUSE_FIRST_NS) ? PAUSE_FIRST_NS : log->pause_ns;
    log->pause_ns = (log->pause_ns > PAUSE_LAST_NS) ? PAUSE_LAST_NS : log->pause_ns;
    log->retry_ns = log->now_ns + log->pause_ns;
    log->is_open  = false;
    switch_to_ring(log);
}

// ---- Pieces ----

/// Add a record to the piece in the format of the strategy's file. The caller has checked the room.
static void add_record(packet_log_t* const log, const uint8_t* const record, const size_t size)
{
    packet_log_job_t* const job = &log->job;
    const size_t room           = sizeof log->piece - job->octets;
    if (job->strategy == PACKET_LOG_SQLITE) {
        octet_writer_t writer = octet_writer((uint8_t*)&log->piece[job->octets], room);
        octet_write_u32(&writer, (uint32_t)size);
        octet_write_octets(&writer, record, size);
        FSW_ASSERT(!writer.failed);
        job->octets += writer.position;
    } else {
        text_t text = text_in(&log->piece[job->octets], room);
        add_line(&text, record, size);
        job->octets += text.length;
    }
}

/// Make a piece of the oldest records in the ring, as many as have room. If records were lost, a gap record
/// precedes them.
static void make_piece(packet_log_t* const log)
{
    uint8_t record[RECORD_MAX];
    packet_log_job_t* const job = &log->job;
    job->octets                 = 0U;
    job->first_number           = oldest_number(log);
    job->last_number            = job->first_number - 1U;
    if (job->last_number > log->written_number) {
        encode_header(record, log->written_number + 1U, job->last_number, DIRECTION_GAP);
        add_record(log, record, RECORD_HEADER);
    }
    size_t offset = 0U;
    while ((offset < log->ring.used) && ((job->octets + LINE_MAX_CHARACTERS) <= sizeof log->piece)) {
        size_t size = 0U;
        offset      = message_ring_look(&log->ring, offset, record, sizeof record, &size);
        add_record(log, record, size);
        job->last_number = octets_u64_at(record);
    }
    job->is_rest = (offset >= log->ring.used);
}

/// Remove the records of a written piece from the ring. The ring may already have dropped some of them;
/// these are then not lost.
static void take_piece(packet_log_t* const log)
{
    const uint64_t oldest = oldest_number(log);
    const uint64_t behind = log->job.last_number + 1U;
    const uint64_t saved  = ((oldest < behind) ? oldest : behind) - log->job.first_number;
    // make_room counted the dropped records as failures.
    log->failures -= (log->wanted == PACKET_LOG_RING) ? 0U : (uint32_t)saved;
    while (oldest_number(log) < behind) {
        drop_oldest(log);
    }
    log->written_number = log->job.last_number;
}

// ---- Jobs ----

static void finish_write(packet_log_t* const log)
{
    const packet_log_job_t* const job = &log->job;
    log->slowest_ns                   = (job->took_ns > log->slowest_ns) ? job->took_ns : log->slowest_ns;
    if (job->status == STATUS_OK) {
        take_piece(log);
        // The file replaces the ring again when it has taken all waiting records quickly enough.
        const bool is_quick = ((log->now_ns - job->since_ns) < SLOW_NS);
        if (job->is_rest && is_quick && (log->strategy != log->wanted)) {
            log->strategy     = log->wanted;
            log->first_number = log->file_first;
            log->resumed_ns   = log->now_ns;
            log->looked_ns    = log->now_ns;
        }
    }
}

static void finish_job(packet_log_t* const log)
{
    const packet_log_job_t job = log->job;
    log->job.kind              = PACKET_LOG_NO_JOB;
    log->is_open               = (job.status == STATUS_OK);
    log->size                  = job.size;
    log->is_cut[job.strategy]  = job.is_cut;
    log->whole[job.strategy]   = job.size;
    if (job.kind == PACKET_LOG_WRITE) {
        finish_write(log);
    }
    if ((log->wanted == PACKET_LOG_RING) && (job.strategy != PACKET_LOG_RING)) {
        // The ring was selected during the job.
        close_file(log);
    } else if (job.status != STATUS_OK) {
        fall_back(log);
    } else if (job.kind == PACKET_LOG_OPEN) {
        log->file_first = oldest_number(log);
    } else {
        // The file stays in use.
    }
}

/// True while the writer performs the job; finishes a completed job. If the job takes too long, the ring
/// replaces the file.
static bool is_busy(packet_log_t* const log)
{
    if (log->job.kind == PACKET_LOG_NO_JOB) {
        return false;
    }
    // Job, piece and file belong to the writer while is_busy is set, otherwise to the supervisor's loop.
    if (!__atomic_load_n(&log->is_busy, __ATOMIC_ACQUIRE)) {
        finish_job(log);
        return false;
    }
    if (((log->now_ns - log->job.since_ns) >= SLOW_NS) && (log->strategy != PACKET_LOG_RING)) {
        switch_to_ring(log);
    }
    return true;
}

static void start_job(packet_log_t* const log, const packet_log_job_kind_t kind,
                      const packet_log_strategy_t strategy)
{
    log->job.kind     = kind;
    log->job.strategy = strategy;
    log->job.since_ns = log->now_ns;
    log->job.size     = (kind == PACKET_LOG_OPEN) ? log->whole[strategy] : log->size;
    log->job.is_cut   = log->is_cut[strategy];
    if (kind == PACKET_LOG_WRITE) {
        make_piece(log);
    }
    if (log->has_writer) {
        __atomic_store_n(&log->is_busy, true, __ATOMIC_RELEASE);
        osal_event_signal(&log->ordered);
    } else {
        do_job(log);
        finish_job(log);
    }
}

/// The task of the writer: performs each job that the supervisor's loop has prepared.
static void run_writer(void* const context)
{
    packet_log_t* const log = (packet_log_t*)context;
    status_t status         = STATUS_OK;
    while ((status == STATUS_OK) && !__atomic_load_n(&log->is_over, __ATOMIC_ACQUIRE)) {
        const bool has_job = __atomic_load_n(&log->is_busy, __ATOMIC_ACQUIRE);
        if (has_job) {
            do_job(log);
            __atomic_store_n(&log->is_busy, false, __ATOMIC_RELEASE);
            osal_event_signal(&log->done);
        }
        status = osal_event_wait(&log->ordered, UINT32_MAX);
    }
}

/// Wait for the running job, then end the writer.
static void end_writer(packet_log_t* const log)
{
    status_t status = STATUS_OK;
    while (is_busy(log) && (status == STATUS_OK)) {
        status = osal_event_wait(&log->done, UINT32_MAX);
    }
    __atomic_store_n(&log->is_over, true, __ATOMIC_RELEASE);
    osal_event_signal(&log->ordered);
    osal_task_join(&log->writer);
    log->has_writer = false;
}

/// Choose the next job of the file.
static packet_log_job_kind_t next_job(const packet_log_t* const log)
{
    if (log->wanted == PACKET_LOG_RING) {
        return PACKET_LOG_NO_JOB;
    }
    if (!log->is_open) {
        return (log->now_ns >= log->retry_ns) ? PACKET_LOG_OPEN : PACKET_LOG_NO_JOB;
    }
    if ((log->ring.blocks > 0U) || (log->strategy != log->wanted)) {
        return PACKET_LOG_WRITE;
    }
    return (log->now_ns >= (log->looked_ns + LOOK_NS)) ? PACKET_LOG_LOOK : PACKET_LOG_NO_JOB;
}

/// Start the jobs that are due. Without a writer, all waiting records are written; only one piece in each
/// step while the ring still replaces the file.
static void write_waiting(packet_log_t* const log)
{
    bool goes_on = !is_busy(log);
    while (goes_on) {
        const packet_log_job_kind_t kind = next_job(log);
        const bool is_last =
            (kind == PACKET_LOG_NO_JOB) || ((kind == PACKET_LOG_WRITE) && (log->strategy != log->wanted));
        log->looked_ns = (kind == PACKET_LOG_LOOK) ? log->now_ns : log->looked_ns;
        if (kind != PACKET_LOG_NO_JOB) {
            start_job(log, kind, log->wanted);
        }
        goes_on = !is_last && !is_busy(log);
    }
}

void supervisor_packet_log_step(packet_log_t* const log, const uint64_t now_ns)
{
    FSW_ASSERT(log != NULL);
    log->now_ns = now_ns;
    write_waiting(log);
}

/// Write all waiting records in one step. Only without a writer.
static void flush(packet_log_t* const log)
{
    while (log->is_open && (log->ring.blocks > 0U)) {
        start_job(log, PACKET_LOG_WRITE, log->wanted);
    }
}

// ---- New records ----

static bool has_room(const packet_log_t* const log, const size_t size)
{
    const bool is_in_force = (log->strategy == PACKET_LOG_RING);
    return (message_ring_room(&log->ring) >= size) &&
           (!is_in_force || (log->ring.blocks < log->ring_records));
}

static void make_room(packet_log_t* const log, const size_t size)
{
    const bool is_full = !has_room(log, size) && (log->strategy != PACKET_LOG_RING);
    if (is_full && log->has_writer) {
        switch_to_ring(log);
    } else if (is_full) {
        flush(log);
    } else {
        // There is room, or the loop below removes the oldest records.
    }
    while (!has_room(log, size)) {
        drop_oldest(log);
        // If the ring was selected, dropping old records is not a failure.
        log->failures += (log->wanted == PACKET_LOG_RING) ? 0U : 1U;
    }
}

void supervisor_packet_log_append(packet_log_t* const log, const uint64_t time_ns, const bool is_tc,
                                  const uint8_t* const packet, const size_t size)
{
    FSW_ASSERT((log != NULL) && (packet != NULL) && (size <= PUS_PACKET_MAX));
    uint8_t header[RECORD_HEADER];
    encode_header(header, log->next_number, time_ns, (uint8_t)(is_tc ? DIRECTION_TC : DIRECTION_TM));
    log->now_ns = time_ns;
    make_room(log, RECORD_HEADER + size);
    const status_t status = message_ring_put_parts(&log->ring, header, RECORD_HEADER, packet, size);
    FSW_ASSERT(status == STATUS_OK);
    log->next_number++;
}

// ---- Selection ----

/// Open the file of a strategy and use it from now on. After a failure the old file stays in use.
static status_t select_file(packet_log_t* const log, const packet_log_strategy_t strategy)
{
    osal_file_t file     = {-1};
    packet_log_job_t job = {
        .strategy = strategy, .size = log->whole[strategy], .is_cut = log->is_cut[strategy]};
    const status_t status = open_file(log, &file, &job);
    if (status == STATUS_OK) {
        close_file(log);
        log->file             = file;
        log->is_open          = true;
        log->size             = job.size;
        log->is_cut[strategy] = false;
        log->whole[strategy]  = job.size;
        log->wanted           = strategy;
        log->strategy         = strategy;
        log->first_number     = oldest_number(log);
        log->resumed_ns       = log->now_ns;
        log->looked_ns        = log->now_ns;
    }
    return status;
}

status_t supervisor_packet_log_select(packet_log_t* const log, const packet_log_strategy_t strategy)
{
    FSW_ASSERT(log != NULL);
    if (((unsigned)strategy >= (unsigned)PACKET_LOG_STRATEGIES) || (strategy == PACKET_LOG_POSTGRESQL)) {
        return STATUS_UNSUPPORTED;
    }
    const bool is_waiting = is_busy(log);
    if (is_waiting && (strategy != PACKET_LOG_RING)) {
        return STATUS_BUSY;
    }
    if (!log->has_writer) {
        flush(log);
    }
    if (strategy != PACKET_LOG_RING) {
        return select_file(log, strategy);
    }
    if (!is_waiting) {
        close_file(log);
    }
    log->wanted = PACKET_LOG_RING;
    switch_to_ring(log);
    return STATUS_OK;
}

status_t supervisor_packet_log_open(packet_log_t* const log, const char* const directory,
                                    const packet_log_strategy_t strategy, const packet_log_past_t* const past,
                                    const uint32_t ring_records)
{
    FSW_ASSERT((log != NULL) && (directory != NULL) && (past != NULL) && (past->next_number >= 1U) &&
               (past->written_number < past->next_number) && (ring_records >= 1U));
    (void)memset(log, 0, offsetof(packet_log_t, piece));
    log->strategy       = PACKET_LOG_RING;
    log->wanted         = PACKET_LOG_RING;
    log->next_number    = past->next_number;
    log->written_number = past->written_number;
    log->ring_records   = ring_records;
    for (unsigned i = 0U; i < (unsigned)PACKET_LOG_STRATEGIES; i++) {
        log->is_cut[i] = (past->ring != NULL);
        // The size of an earlier file is unknown until it is opened.
        log->whole[i] = (past->ring != NULL) ? past->sizes[i] : UINT64_MAX;
    }
    message_ring_init(&log->ring, log->ring_storage, sizeof log->ring_storage);
    if (past->ring_octets > 0U) {
        message_ring_refill(&log->ring, past->ring, past->ring_octets);
    }
    log->first_number = oldest_number(log);
    text_t text       = text_in(log->directory, sizeof log->directory);
    text_add(&text, directory);
    const status_t status = text.cut ? STATUS_NOT_FOUND : supervisor_packet_log_select(log, strategy);
    if (text.cut || (status == STATUS_OK) || (status == STATUS_UNSUPPORTED)) {
        return status;
    }
    log->wanted = strategy;
    fall_back(log);
    return STATUS_OK;
}

status_t supervisor_packet_log_start_writer(packet_log_t* const log)
{
    FSW_ASSERT((log != NULL) && !log->has_writer);
    osal_event_create(&log->ordered);
    osal_event_create(&log->done);
    const status_t status = osal_task_start(&log->writer, run_writer, log, 0);
    log->has_writer       = (status == STATUS_OK);
    return status;
}

void supervisor_packet_log_abandon(packet_log_t* const log)
{
    FSW_ASSERT((log != NULL) && !log->has_writer);
    close_file(log);
}

/// Select a strategy and write all waiting records to its file, if possible.
static void write_rest(packet_log_t* const log, const packet_log_strategy_t strategy)
{
    log->wanted = strategy;
    if (!log->is_open && (log->ring.blocks > 0U)) {
        start_job(log, PACKET_LOG_OPEN, strategy);
    }
    flush(log);
}

void supervisor_packet_log_close(packet_log_t* const log)
{
    FSW_ASSERT(log != NULL);
    if (log->has_writer) {
        end_writer(log);
    }
    if (log->wanted != PACKET_LOG_RING) {
        write_rest(log, log->wanted);
    }
    if (log->strategy == PACKET_LOG_RING) {
        write_rest(log, PACKET_LOG_RING);
    }
    close_file(log);
    log->failures += log->ring.blocks;
}
