// SPDX-License-Identifier: Apache-2.0
// The program that writes the SQLite packet log, and merges all parts of a run's packet log.
//
//     packet-archive-sqlite follow DIRECTORY   insert packets.spool into packets.db as it grows, until ended
//     packet-archive-sqlite merge DIRECTORY [RECORDS]
//                                           packets.ascii, .spool, .ring -> packets.db and packets.log
//
// The merge fails (exit code 1) if a record number up to RECORDS is missing (the program prints the missing
// numbers) or occurs twice with different content. packets.log is complete or absent. If the disk has no room
// for both files, packets.db is removed: it can be created again from the parts.
#include "base/octets.h"
#include "base/text.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/process.h"
#include "pus/core/packet.h"

#include <sqlite3.h>
#include <string.h>

#define PATH_MAX_CHARACTERS 512U
#define RECORD_HEADER 17U
#define RECORD_MAX (RECORD_HEADER + PUS_PACKET_MAX)
#define LINE_MAX_CHARACTERS (96U + (2U * PUS_PACKET_MAX))
#define CHUNK 65536U
#define DIRECTION_GAP 2U
#define RANGES_REPORTED 8U ///< Maximum number of ranges of missing records that are printed.
#define FOLLOW_PAUSE_NS 20000000ULL

typedef struct {
    const char* directory;
    sqlite3* database;
    sqlite3_stmt* insert;
    uint64_t expected; ///< Number of the last record; 0: the last existing one.
    uint64_t doubled;  ///< Records with different content whose number already existed.
    uint64_t gaps;     ///< Records that the log itself reports as lost.
    bool is_failed;    ///< The database accepts no more records.
} archive_t;

/// A growing file. An incomplete record at its end is read again later, because the writer may still complete
/// it, or cut it off after a failure.
typedef struct {
    osal_file_t file;
    bool is_open;
    uint64_t position; ///< Position of the buffer in the file.
    size_t held;       ///< Octets in the buffer.
    size_t partial;    ///< Octets of `held` that belong to an incomplete record, from the read before.
    uint8_t buffer[CHUNK + LINE_MAX_CHARACTERS];
} tail_t;

static int report_error(const char* const what, const char* const detail)
{
    char line[PATH_MAX_CHARACTERS * 2U];
    (void)text_join(line, sizeof line, (const char* const[]){"packet-archive-sqlite: ", what, detail, NULL});
    osal_console_print_error(line);
    return 1;
}

static void path_of(const archive_t* const archive, const char* const name,
                    char out_path[PATH_MAX_CHARACTERS])
{
    (void)text_join(out_path, PATH_MAX_CHARACTERS,
                    (const char* const[]){archive->directory, "/", name, NULL});
}

static bool execute(archive_t* const archive, const char* const sql)
{
    return sqlite3_exec(archive->database, sql, NULL, NULL, NULL) == SQLITE_OK;
}

static bool open_database(archive_t* const archive, const char* const path)
{
    return (sqlite3_open(path, &archive->database) == SQLITE_OK) &&
           (sqlite3_busy_timeout(archive->database, 10000) == SQLITE_OK) &&
           execute(archive,
                   "CREATE TABLE IF NOT EXISTS packet(number INTEGER PRIMARY KEY, time_ns INTEGER NOT NULL,"
                   " direction TEXT NOT NULL, apid INTEGER, service INTEGER, subtype INTEGER, seq INTEGER,"
                   " user INTEGER, raw BLOB NOT NULL)") &&
           (sqlite3_prepare_v2(archive->database,
                               "INSERT INTO packet VALUES(?,?,?,?,?,?,?,?,?) ON CONFLICT(number) DO NOTHING",
                               -1, &archive->insert, NULL) == SQLITE_OK);
}

static void close_database(archive_t* const archive)
{
    (void)sqlite3_finalize(archive->insert);
    (void)sqlite3_close(archive->database);
    archive->insert   = NULL;
    archive->database = NULL;
}

static void open_archive(archive_t* const archive)
{
    char path[PATH_MAX_CHARACTERS];
    path_of(archive, "packets.db", path);
    archive->is_failed = !open_database(archive, path);
    if (archive->is_failed) {
        char detail[PATH_MAX_CHARACTERS + 128U];
        (void)text_join(detail, sizeof detail,
                        (const char* const[]){path, ": ", sqlite3_errmsg(archive->database), NULL});
        (void)report_error("cannot open ", detail);
    }
}

/// Header fields of a packet; -1, stored as NULL, for a field that the packet does not have.
typedef struct {
    int apid;
    int service;
    int subtype;
    int sequence;
    int user;
} header_t;

static header_t header_of(const uint8_t* const packet, const size_t size, const bool is_tc)
{
    header_t header = {-1, -1, -1, -1, -1};
    if (size >= PUS_PRIMARY_HEADER_SIZE) {
        header.apid     = (int)(((unsigned)(packet[0] & 0x07U) << 8U) | packet[1]);
        header.sequence = (int)(((unsigned)(packet[2] & 0x3FU) << 8U) | packet[3]);
    }
    const size_t user_offset = is_tc ? 9U : 11U;
    if (size >= (user_offset + 2U)) {
        header.service = packet[7];
        header.subtype = packet[8];
        header.user    = (int)(((unsigned)packet[user_offset] << 8U) | packet[user_offset + 1U]);
    }
    return header;
}

static void bind_optional(sqlite3_stmt* const statement, const int column, const int value)
{
    if (value < 0) {
        (void)sqlite3_bind_null(statement, column);
    } else {
        (void)sqlite3_bind_int(statement, column, value);
    }
}

/// True if the existing record has the same packet.
static bool is_same(archive_t* const archive, const uint64_t number, const uint8_t* const packet,
                    const size_t size)
{
    sqlite3_stmt* query = NULL;
    bool same           = false;
    if (sqlite3_prepare_v2(archive->database, "SELECT raw FROM packet WHERE number=?", -1, &query, NULL) ==
        SQLITE_OK) {
        (void)sqlite3_bind_int64(query, 1, (sqlite3_int64)number);
        // An empty value has a null pointer, which memcmp does not allow.
        same = (sqlite3_step(query) == SQLITE_ROW) && ((size_t)sqlite3_column_bytes(query, 0) == size) &&
               ((size == 0U) || (memcmp(sqlite3_column_blob(query, 0), packet, size) == 0));
    }
    (void)sqlite3_finalize(query);
    return same;
}

static void insert(archive_t* const archive, const uint8_t* const record, const size_t size)
{
    octet_reader_t reader       = octet_reader(record, size);
    const uint64_t number       = octet_read_u64(&reader);
    const uint64_t time_ns      = octet_read_u64(&reader);
    const uint8_t direction     = octet_read_u8(&reader);
    const bool is_tc            = (direction == 0U);
    const size_t packet_size    = octet_reader_left(&reader);
    const uint8_t* const packet = &record[RECORD_HEADER];
    const header_t header       = header_of(packet, packet_size, is_tc);
    sqlite3_stmt* const row     = archive->insert;
    // In a gap record `number` is the first missing number, and `time_ns` is the last missing number.
    if (direction == DIRECTION_GAP) {
        archive->gaps += (time_ns >= number) ? ((time_ns - number) + 1U) : 0U;
        return;
    }
    (void)sqlite3_bind_int64(row, 1, (sqlite3_int64)number);
    (void)sqlite3_bind_int64(row, 2, (sqlite3_int64)time_ns);
    (void)sqlite3_bind_text(row, 3, is_tc ? "TC" : "TM", 2, SQLITE_STATIC);
    bind_optional(row, 4, header.apid);
    bind_optional(row, 5, header.service);
    bind_optional(row, 6, header.subtype);
    bind_optional(row, 7, header.sequence);
    bind_optional(row, 8, header.user);
    (void)sqlite3_bind_blob(row, 9, packet, (int)packet_size, SQLITE_STATIC);
    const bool is_done = (sqlite3_step(row) == SQLITE_DONE);
    const bool is_new  = is_done && (sqlite3_changes(archive->database) > 0);
    (void)sqlite3_reset(row);
    archive->is_failed = archive->is_failed || !is_done;
    if (is_done && !is_new && !is_same(archive, number, packet, packet_size)) {
        archive->doubled++;
    }
}

// ---- Reading parts ----

static bool fill(archive_t* const archive, tail_t* const tail, const char* const name)
{
    if (!tail->is_open) {
        char path[PATH_MAX_CHARACTERS];
        path_of(archive, name, path);
        tail->is_open = (osal_file_open_read(&tail->file, path) == STATUS_OK);
    }
    uint64_t size = 0U;
    if (!tail->is_open || (osal_file_size(&tail->file, &size) != STATUS_OK) || (size <= tail->position)) {
        return false;
    }
    const uint64_t rest = size - tail->position;
    tail->held          = (rest < sizeof tail->buffer) ? (size_t)rest : sizeof tail->buffer;
    return (tail->held != tail->partial) &&
           (osal_file_read_at(&tail->file, tail->position, tail->buffer, tail->held) == STATUS_OK);
}

static void drop(tail_t* const tail, const size_t size)
{
    tail->held -= size;
    tail->partial = tail->held;
    tail->position += size;
}

/// Insert the complete records at the front of the spool's buffer.
static void take_spool(archive_t* const archive, tail_t* const tail)
{
    size_t used = 0U;
    for (;;) {
        octet_reader_t reader = octet_reader(&tail->buffer[used], tail->held - used);
        const uint32_t size   = octet_read_u32(&reader);
        if (reader.failed) {
            break;
        }
        // A wrong size could make the program wait for octets that are never written.
        if ((size < RECORD_HEADER) || (size > RECORD_MAX)) {
            // The framing is lost, and the rest is unreliable; the merge reports the missing records.
            used = tail->held;
            break;
        }
        if (octet_reader_left(&reader) < size) {
            break;
        }
        insert(archive, &tail->buffer[used + 4U], size);
        used += 4U + size;
    }
    drop(tail, used);
}

static int digit_of(const uint8_t character)
{
    if ((character >= (uint8_t)'0') && (character <= (uint8_t)'9')) {
        return character - '0';
    }
    return ((character >= (uint8_t)'a') && (character <= (uint8_t)'f')) ? (character - 'a' + 10) : -1;
}

static uint64_t read_number(const uint8_t* const line, const size_t size, size_t* const position)
{
    uint64_t number = 0U;
    while ((*position < size) && (line[*position] >= (uint8_t)'0') && (line[*position] <= (uint8_t)'9')) {
        number = (number * 10U) + (uint64_t)(line[*position] - (uint8_t)'0');
        (*position)++;
    }
    (*position)++; // Skip the separator.
    return number;
}

/// Insert a line "<first> <last> GAP".
static void insert_gap(archive_t* const archive, const uint8_t* const line, const size_t size)
{
    uint8_t record[RECORD_HEADER];
    size_t position       = 0U;
    octet_writer_t writer = octet_writer(record, sizeof record);
    octet_write_u64(&writer, read_number(line, size, &position));
    octet_write_u64(&writer, read_number(line, size, &position));
    octet_write_u8(&writer, DIRECTION_GAP);
    insert(archive, record, sizeof record);
}

/// Insert a line "<number> <seconds>.<nanoseconds> TC|TM <hex>" as a record.
static void insert_line(archive_t* const archive, const uint8_t* const line, const size_t size)
{
    static const uint8_t gap[] = {(uint8_t)' ', (uint8_t)'G', (uint8_t)'A', (uint8_t)'P'};
    uint8_t record[RECORD_MAX];
    size_t position       = 0U;
    octet_writer_t writer = octet_writer(record, sizeof record);
    if ((size > sizeof gap) && (memcmp(&line[size - sizeof gap], gap, sizeof gap) == 0)) {
        insert_gap(archive, line, size);
        return;
    }
    octet_write_u64(&writer, read_number(line, size, &position));
    const uint64_t seconds = read_number(line, size, &position);
    octet_write_u64(&writer, (seconds * 1000000000U) + read_number(line, size, &position));
    if ((position + 3U) >= size) {
        return;
    }
    octet_write_u8(&writer, (uint8_t)((line[position + 1U] == (uint8_t)'C') ? 0U : 1U));
    for (size_t i = position + 3U; (i + 1U) < size; i += 2U) {
        const int high = digit_of(line[i]);
        const int low  = digit_of(line[i + 1U]);
        if ((high < 0) || (low < 0)) {
            return;
        }
        octet_write_u8(&writer, (uint8_t)((high * 16) + low));
    }
    if (!writer.failed) {
        insert(archive, record, writer.position);
    }
}

static void take_lines(archive_t* const archive, tail_t* const tail)
{
    size_t used = 0U;
    for (size_t i = 0U; i < tail->held; i++) {
        if (tail->buffer[i] == (uint8_t)'\n') {
            insert_line(archive, &tail->buffer[used], i - used);
            used = i + 1U;
        }
    }
    drop(tail, used);
    if (tail->held > LINE_MAX_CHARACTERS) { // No valid line is longer than LINE_MAX_CHARACTERS.
        drop(tail, tail->held);
    }
}

static void take_part(archive_t* const archive, const char* const name,
                      void (*const take)(archive_t* archive, tail_t* tail))
{
    static tail_t tail; // Static, because it is large; only one part is read at a time.
    (void)memset(&tail, 0, sizeof tail);
    (void)execute(archive, "BEGIN");
    while (fill(archive, &tail, name)) {
        take(archive, &tail);
    }
    archive->is_failed = !execute(archive, "COMMIT") || archive->is_failed;
    if (tail.is_open) {
        osal_file_close(&tail.file);
    }
}

// ---- Commands ----

static int follow(archive_t* const archive)
{
    static tail_t tail;
    osal_clock_t clock;
    osal_clock_open_real(&clock, osal_clock_monotonic_ns());
    while (osal_process_stop_count() == 0U) {
        const bool was_failed = archive->is_failed;
        (void)execute(archive, "BEGIN");
        while (!archive->is_failed && fill(archive, &tail, "packets.spool")) {
            take_spool(archive, &tail);
        }
        archive->is_failed = !execute(archive, "COMMIT") || archive->is_failed;
        if (archive->is_failed && !was_failed) {
            (void)report_error(
                "cannot write packets.db (is the disk full?); the merge at the end reads all records from ",
                "packets.spool");
        }
        if (osal_clock_wait(&clock, osal_clock_now_ns(&clock) + FOLLOW_PAUSE_NS, NULL, 0U) != STATUS_OK) {
            break;
        }
    }
    return 0;
}

static status_t write_line(osal_file_t* const file, sqlite3_stmt* const row)
{
    static char line[LINE_MAX_CHARACTERS];
    text_t text = text_in(line, sizeof line);
    text_add_seconds(&text, (uint64_t)sqlite3_column_int64(row, 0));
    text_add(&text, " ");
    text_add(&text, (const char*)sqlite3_column_text(row, 1));
    text_add(&text, " ");
    text_add_octets(&text, (const uint8_t*)sqlite3_column_blob(row, 2), (size_t)sqlite3_column_bytes(row, 2));
    text_add_character(&text, '\n');
    return osal_file_write(file, line, text.length);
}

/// Write packets.log. The file has another name until it is complete.
static bool write_log(archive_t* const archive)
{
    char part[PATH_MAX_CHARACTERS];
    char path[PATH_MAX_CHARACTERS];
    osal_file_t file  = {-1};
    sqlite3_stmt* row = NULL;
    path_of(archive, "packets.log.part", part);
    path_of(archive, "packets.log", path);
    status_t status = osal_file_create(&file, part);
    if ((status == STATUS_OK) &&
        (sqlite3_prepare_v2(archive->database, "SELECT time_ns, direction, raw FROM packet ORDER BY number",
                            -1, &row, NULL) != SQLITE_OK)) {
        status = STATUS_IO;
    }
    while ((status == STATUS_OK) && (sqlite3_step(row) == SQLITE_ROW)) {
        status = write_line(&file, row);
    }
    (void)sqlite3_finalize(row);
    osal_file_close(&file);
    status = (status == STATUS_OK) ? osal_file_rename(part, path) : status;
    if (status != STATUS_OK) {
        (void)osal_file_remove(part);
    }
    return status == STATUS_OK;
}

/// Write " first-last" for each of the first missing ranges. Returns the number of missing records.
static uint64_t find_missing(archive_t* const archive, text_t* const out_ranges)
{
    sqlite3_stmt* row = NULL;
    uint64_t next     = 1U;
    uint64_t missing  = 0U;
    unsigned ranges   = 0U;
    bool is_more = (sqlite3_prepare_v2(archive->database, "SELECT number FROM packet ORDER BY number", -1,
                                       &row, NULL) == SQLITE_OK);
    while (is_more) {
        is_more               = (sqlite3_step(row) == SQLITE_ROW);
        const uint64_t number = is_more ? (uint64_t)sqlite3_column_int64(row, 0) : (archive->expected + 1U);
        if (number > next) {
            missing += number - next;
            if (ranges < RANGES_REPORTED) {
                text_add(out_ranges, (ranges == 0U) ? ": " : " ");
                text_add_unsigned(out_ranges, next);
                text_add(out_ranges, "-");
                text_add_unsigned(out_ranges, number - 1U);
            }
            ranges++;
        }
        next = number + 1U;
    }
    text_add(out_ranges, (ranges > RANGES_REPORTED) ? " and more" : "");
    (void)sqlite3_finalize(row);
    return missing;
}

/// Check that the numbers run from 1 to the last one without a gap.
static bool check_numbers(archive_t* const archive)
{
    char ranges[512];
    char numbers[768];
    text_t missing       = text_in(ranges, sizeof ranges);
    text_t text          = text_in(numbers, sizeof numbers);
    const uint64_t count = find_missing(archive, &missing);
    text_add_unsigned(&text, count);
    text_add(&text, " missing, ");
    text_add_unsigned(&text, archive->doubled);
    text_add(&text, " doubled");
    text_add(&text, ranges);
    if (archive->gaps > 0U) {
        text_add(&text, "; known in flight: ");
        text_add_unsigned(&text, archive->gaps);
    }
    const bool is_whole = (count == 0U) && (archive->doubled == 0U);
    if (!is_whole) {
        (void)report_error("records of the packet log: ", numbers);
    }
    return is_whole;
}

static void take_parts(archive_t* const archive)
{
    archive->doubled = 0U;
    archive->gaps    = 0U;
    take_part(archive, "packets.spool", take_spool);
    take_part(archive, "packets.ascii", take_lines);
    take_part(archive, "packets.ring", take_lines);
}

/// Merge in memory, without packets.db, so that packets.log can use the disk space of packets.db.
static bool merge_in_memory(archive_t* const archive)
{
    static const char* const names[] = {"packets.db", "packets.db-journal"};
    char path[PATH_MAX_CHARACTERS];
    close_database(archive);
    for (size_t i = 0U; i < (sizeof names / sizeof names[0]); i++) {
        path_of(archive, names[i], path);
        (void)osal_file_remove(path);
    }
    (void)report_error("cannot write packets.db (is the disk full?): it is made again from the parts by ",
                       "packet-archive-sqlite merge");
    archive->is_failed = !open_database(archive, ":memory:");
    if (!archive->is_failed) {
        take_parts(archive);
    }
    return !archive->is_failed && write_log(archive);
}

static int merge(archive_t* const archive)
{
    if (!archive->is_failed) {
        take_parts(archive);
    }
    const bool is_stored  = !archive->is_failed && write_log(archive);
    const bool is_written = is_stored || merge_in_memory(archive);
    const bool is_whole   = !archive->is_failed && check_numbers(archive);
    if (!is_written) {
        (void)report_error("cannot write packets.log: the packets are in packets.ascii, .spool and .ring of ",
                           archive->directory);
    }
    return (is_stored && is_whole) ? 0 : 1;
}

/// Returns the number in a text; 0 if there is none.
static uint64_t number_of(const char* const words)
{
    size_t position = 0U;
    return read_number((const uint8_t*)words, strlen(words), &position);
}

int main(const int argument_count, char* arguments[])
{
    static const char usage[] = "usage: packet-archive-sqlite follow DIRECTORY, or merge DIRECTORY [RECORDS]";
    if (osal_console_introduce(argument_count, arguments, "packet-archive-sqlite", usage)) {
        return 0;
    }
    const bool is_follow = (argument_count == 3) && (strcmp(arguments[1], "follow") == 0);
    const bool is_merge =
        ((argument_count == 3) || (argument_count == 4)) && (strcmp(arguments[1], "merge") == 0);
    if (!is_follow && !is_merge) {
        (void)report_error(usage, "");
        return 2;
    }
    osal_process_catch_stop();
    osal_process_ignore_interrupt();
    archive_t archive = {.directory = arguments[2],
                         .expected  = (argument_count == 4) ? number_of(arguments[3]) : 0U};
    open_archive(&archive);
    const int code = is_follow ? follow(&archive) : merge(&archive);
    close_database(&archive);
    return code;
}
