// SPDX-License-Identifier: Apache-2.0
// The writer of the SQLite packet log, a process of its own, and the merge of all parts of a run's packet
// log.
//
//     packet-archive-sqlite follow FOLDER   take packets.spool into packets.db as it grows, until told to end
//     packet-archive-sqlite merge FOLDER    packets.ascii, .spool, .ring -> packets.db and packets.log
//
// The merge fails (exit code 1) if a record number is missing or occurs twice with other content.
#include "fsw/framework/base/octets.h"
#include "fsw/framework/base/text.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"
#include "osal/include/osal/file.h"
#include "osal/include/osal/process.h"
#include "pus/packet.h"

#include <sqlite3.h>
#include <string.h>

#define PATH_MAX_CHARACTERS 512U
#define RECORD_HEADER 17U
#define RECORD_MAX (RECORD_HEADER + PUS_PACKET_MAX)
#define LINE_MAX_CHARACTERS (96U + (2U * PUS_PACKET_MAX))
#define CHUNK 65536U
#define FOLLOW_PAUSE_NS 20000000ULL

typedef struct {
    const char* folder;
    sqlite3* database;
    sqlite3_stmt* insert;
    uint64_t doubled; ///< Records that were there already with other content.
} archive_t;

typedef struct { // A file that grows: what was read and not used yet.
    osal_file_t file;
    bool is_open;
    size_t held;
    uint8_t buffer[CHUNK + LINE_MAX_CHARACTERS];
} tail_t;

static int complain(const char* const what, const char* const detail)
{
    char line[PATH_MAX_CHARACTERS * 2U];
    text_t text = text_in(line, sizeof line);
    text_add(&text, "packet-archive-sqlite: ");
    text_add(&text, what);
    text_add(&text, detail);
    osal_console_complain(line);
    return 1;
}

static void path_of(const archive_t* const archive, const char* const name,
                    char out_path[PATH_MAX_CHARACTERS])
{
    text_t text = text_in(out_path, PATH_MAX_CHARACTERS);
    text_add(&text, archive->folder);
    text_add(&text, "/");
    text_add(&text, name);
}

static bool execute(archive_t* const archive, const char* const sql)
{
    return sqlite3_exec(archive->database, sql, NULL, NULL, NULL) == SQLITE_OK;
}

static int open_archive(archive_t* const archive)
{
    char path[PATH_MAX_CHARACTERS];
    path_of(archive, "packets.db", path);
    const bool is_ready =
        (sqlite3_open(path, &archive->database) == SQLITE_OK) &&
        (sqlite3_busy_timeout(archive->database, 10000) == SQLITE_OK) &&
        execute(archive,
                "CREATE TABLE IF NOT EXISTS packet(number INTEGER PRIMARY KEY, time_ns INTEGER NOT NULL,"
                " direction TEXT NOT NULL, apid INTEGER, service INTEGER, subtype INTEGER, seq INTEGER,"
                " user INTEGER, raw BLOB NOT NULL)") &&
        (sqlite3_prepare_v2(archive->database,
                            "INSERT INTO packet VALUES(?,?,?,?,?,?,?,?,?) ON CONFLICT(number) DO NOTHING", -1,
                            &archive->insert, NULL) == SQLITE_OK);
    return is_ready ? 0 : complain("cannot open ", path);
}

/// Header fields of a packet, as far as it has them; -1 stands for NULL.
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

/// True if the record that is there has the same packet.
static bool is_same(archive_t* const archive, const uint64_t number, const uint8_t* const packet,
                    const size_t size)
{
    sqlite3_stmt* query = NULL;
    bool same           = false;
    if (sqlite3_prepare_v2(archive->database, "SELECT raw FROM packet WHERE number=?", -1, &query, NULL) ==
        SQLITE_OK) {
        (void)sqlite3_bind_int64(query, 1, (sqlite3_int64)number);
        same = (sqlite3_step(query) == SQLITE_ROW) && ((size_t)sqlite3_column_bytes(query, 0) == size) &&
               ((size == 0U) || (memcmp(sqlite3_column_blob(query, 0), packet, size) == 0)); // Empty: null.
    }
    (void)sqlite3_finalize(query);
    return same;
}

static void insert(archive_t* const archive, const uint8_t* const record, const size_t size)
{
    octet_reader_t reader       = octet_reader(record, size);
    const uint64_t number       = octet_read_u64(&reader);
    const uint64_t time_ns      = octet_read_u64(&reader);
    const bool is_tc            = (octet_read_u8(&reader) == 0U);
    const size_t packet_size    = octet_reader_left(&reader);
    const uint8_t* const packet = &record[RECORD_HEADER];
    const header_t header       = header_of(packet, packet_size, is_tc);
    sqlite3_stmt* const row     = archive->insert;
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
    if (!is_new && !is_same(archive, number, packet, packet_size)) {
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
    size_t size = 0U;
    if (!tail->is_open ||
        (osal_file_read(&tail->file, &tail->buffer[tail->held], CHUNK, &size) != STATUS_OK)) {
        return false;
    }
    tail->held += size;
    return size > 0U;
}

static void drop(tail_t* const tail, const size_t size)
{
    tail->held -= size;
    (void)memmove(tail->buffer, &tail->buffer[size], tail->held);
}

/// Whole records at the front of the spool's tail.
static void take_spool(archive_t* const archive, tail_t* const tail)
{
    size_t used = 0U;
    for (;;) {
        octet_reader_t reader = octet_reader(&tail->buffer[used], tail->held - used);
        const uint32_t size   = octet_read_u32(&reader);
        if (reader.failed) {
            break;
        }
        if ((size < RECORD_HEADER) || (size > RECORD_MAX)) { // Before waiting for octets that never come.
            used =
                tail->held; // Out of step: nothing after it can be trusted; the merge tells what is missing.
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
    (*position)++; // The separator.
    return number;
}

/// "<number> <seconds>.<nanoseconds> TC|TM <hex>" as a record.
static void insert_line(archive_t* const archive, const uint8_t* const line, const size_t size)
{
    uint8_t record[RECORD_MAX];
    size_t position       = 0U;
    octet_writer_t writer = octet_writer(record, sizeof record);
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
    if (tail->held >
        LINE_MAX_CHARACTERS) { // No line is that long, and the buffer has room for one line only.
        drop(tail, tail->held);
    }
}

static void take_part(archive_t* const archive, const char* const name,
                      void (*const take)(archive_t* archive, tail_t* tail))
{
    static tail_t tail; // Large; one part at a time.
    (void)memset(&tail, 0, sizeof tail);
    (void)execute(archive, "BEGIN");
    while (fill(archive, &tail, name)) {
        take(archive, &tail);
    }
    (void)execute(archive, "COMMIT");
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
        (void)execute(archive, "BEGIN");
        while (fill(archive, &tail, "packets.spool")) {
            take_spool(archive, &tail);
        }
        (void)execute(archive, "COMMIT");
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

static int write_log(archive_t* const archive)
{
    char path[PATH_MAX_CHARACTERS];
    osal_file_t file  = {-1};
    sqlite3_stmt* row = NULL;
    path_of(archive, "packets.log", path);
    if ((osal_file_create(&file, path) != STATUS_OK) ||
        (sqlite3_prepare_v2(archive->database, "SELECT time_ns, direction, raw FROM packet ORDER BY number",
                            -1, &row, NULL) != SQLITE_OK)) {
        return complain("cannot write ", path);
    }
    status_t status = STATUS_OK;
    while ((status == STATUS_OK) && (sqlite3_step(row) == SQLITE_ROW)) {
        status = write_line(&file, row);
    }
    (void)sqlite3_finalize(row);
    osal_file_close(&file);
    return (status == STATUS_OK) ? 0 : complain("cannot write ", path);
}

/// Numbers run from 1 without a gap.
static int check_numbers(archive_t* const archive)
{
    sqlite3_stmt* row = NULL;
    int code          = 1;
    if ((sqlite3_prepare_v2(archive->database, "SELECT count(*), coalesce(max(number), 0) FROM packet", -1,
                            &row, NULL) == SQLITE_OK) &&
        (sqlite3_step(row) == SQLITE_ROW)) {
        const uint64_t count = (uint64_t)sqlite3_column_int64(row, 0);
        const uint64_t last  = (uint64_t)sqlite3_column_int64(row, 1);
        char numbers[64];
        text_t text = text_in(numbers, sizeof numbers);
        text_add_unsigned(&text, last - count);
        text_add(&text, " missing, ");
        text_add_unsigned(&text, archive->doubled);
        text_add(&text, " doubled");
        code = ((count == last) && (archive->doubled == 0U))
                   ? 0
                   : complain("records of the packet log: ", numbers);
    }
    (void)sqlite3_finalize(row);
    return code;
}

static int merge(archive_t* const archive)
{
    take_part(archive, "packets.spool", take_spool);
    take_part(archive, "packets.ascii", take_lines);
    take_part(archive, "packets.ring", take_lines);
    const int written = write_log(archive);
    const int checked = check_numbers(archive);
    return ((written == 0) && (checked == 0)) ? 0 : 1;
}

int main(const int argument_count, char* arguments[])
{
    const bool is_follow = (argument_count == 3) && (strcmp(arguments[1], "follow") == 0);
    const bool is_merge  = (argument_count == 3) && (strcmp(arguments[1], "merge") == 0);
    if (!is_follow && !is_merge) {
        (void)complain("usage: packet-archive-sqlite follow|merge FOLDER", "");
        return 2;
    }
    osal_process_catch_stop();
    osal_process_ignore_interrupt();
    archive_t archive = {.folder = arguments[2]};
    int code          = open_archive(&archive);
    if (code == 0) {
        code = is_follow ? follow(&archive) : merge(&archive);
    }
    (void)sqlite3_finalize(archive.insert);
    (void)sqlite3_close(archive.database);
    return code;
}
