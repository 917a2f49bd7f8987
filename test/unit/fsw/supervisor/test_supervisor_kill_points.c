// SPDX-License-Identifier: Apache-2.0
// The supervisor dies at every point of one busy step: before and after each frame, each write to the packet
// log, to the journal and to a packet store, each command to a process and each query to the platform. The
// next supervisor continues, and each effect must have occurred once.
#define _GNU_SOURCE
#include "fsw/supervisor/supervisor.h"
#include "fsw/supervisor/undo.h"
#include "test/support/recorded_media.h"
#include "test/support/repetitions.h"
#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "test/unit/fsw/supervisor/releases.h"
#include "unity.h"

#include <errno.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

#define RECORDS 256U
#define STORE_OCTETS 131072U
#define RING "RING\0\0\0\0"
#define RESTARTED "G 5.2 0014" ///< Report of the event SUPERVISOR_RESTARTED.
#define MS 1000000ULL
#define APIDS 32U

// ---- Points ----

static jmp_buf killed;
static bool is_armed;
static unsigned points;   // Number of points so far.
static unsigned deadline; // The supervisor dies at this point; 0: it does not die.

static void point(void)
{
    if (is_armed) {
        points++;
        if (points == deadline) {
            is_armed = false;
            longjmp(killed, 1);
        }
    }
}

// ---- Effects of the supervisor on files, members and processes ----

static bool is_disk_full; // Writes to the packet log fail.

ssize_t write(int descriptor, const void* octets, size_t size)
{
    point();
    if (is_disk_full && (descriptor == fixture.supervisor.log.file.descriptor)) {
        errno = ENOSPC;
        return -1;
    }
    const ssize_t written = syscall(SYS_write, descriptor, octets, size);
    point();
    return written;
}

int ftruncate(int descriptor, off_t size)
{
    point();
    const int result = (int)syscall(SYS_ftruncate, descriptor, size);
    point();
    return result;
}

static message_carrier_t carrier;

static status_t mortal_send(void* context, uint16_t to, const uint8_t* frame, size_t size)
{
    (void)context;
    point();
    const status_t status = carrier.send(carrier.context, to, frame, size);
    point();
    return status;
}

static supervisor_platform_t platform;

static status_t mortal_start(void* context, uint16_t apid, uint32_t link_floor, uint64_t boot_ns)
{
    point();
    const status_t status = platform.is_running(context, apid)
                                ? STATUS_EXISTS
                                : platform.start(context, apid, link_floor, boot_ns);
    point();
    return status;
}

static status_t mortal_stop(void* context, uint16_t apid)
{
    point();
    const status_t status = platform.is_running(context, apid) ? platform.stop(context, apid) : STATUS_OK;
    point();
    return status;
}

static bool mortal_is_running(void* context, uint16_t apid)
{
    point();
    return platform.is_running(context, apid);
}

// ---- Media ----

static uint8_t store_octets[STORE_OCTETS];
// Size of the store with media; the address is the context of its medium. The media of the other stores have
// another context, and accept no octets.
static uint64_t store_size;

static status_t read_store(void* context, uint64_t offset, uint8_t* octets, size_t size)
{
    if ((offset + size) > *(const uint64_t*)context) {
        return STATUS_TRUNCATED;
    }
    (void)memcpy(octets, &store_octets[offset], size);
    return STATUS_OK;
}

static status_t write_store(void* context, uint64_t offset, const uint8_t* octets, size_t size)
{
    uint64_t* const end = context;
    if ((end != &store_size) || ((offset + size) > sizeof store_octets)) {
        return STATUS_FULL;
    }
    (void)memcpy(&store_octets[offset], octets, size);
    *end = ((offset + size) > *end) ? (offset + size) : *end;
    return STATUS_OK;
}

static status_t sync_store(void* context)
{
    (void)context;
    return STATUS_OK;
}

static status_t size_of_store(void* context, uint64_t* out_size)
{
    *out_size = *(const uint64_t*)context;
    return STATUS_OK;
}

static status_t resize_store(void* context, uint64_t size)
{
    *(uint64_t*)context = (context == &store_size) ? size : 0U;
    return STATUS_OK;
}

static medium_t inner[3]; // Journal, journal, store.

static medium_t* inner_of(void* context)
{
    return context;
}

static status_t mortal_read(void* context, uint64_t offset, uint8_t* octets, size_t size)
{
    return inner_of(context)->read(inner_of(context)->context, offset, octets, size);
}

static status_t mortal_write(void* context, uint64_t offset, const uint8_t* octets, size_t size)
{
    point();
    const status_t status = inner_of(context)->write(inner_of(context)->context, offset, octets, size);
    point();
    return status;
}

static status_t mortal_sync(void* context)
{
    point();
    return inner_of(context)->sync(inner_of(context)->context);
}

static status_t mortal_size(void* context, uint64_t* out_size)
{
    return inner_of(context)->size(inner_of(context)->context, out_size);
}

static status_t mortal_resize(void* context, uint64_t size)
{
    point();
    const status_t status = inner_of(context)->resize(inner_of(context)->context, size);
    point();
    return status;
}

// ---- Lives ----

static checkpoint_t checkpoint;
static journal_t journal;
static journal_slot_t slots[JOURNAL_SLOTS(RECORDS)];
static medium_t store_media[SPACECRAFT_STORES];
static supervisor_config_t configuration;

static void open_media(void)
{
    static undo_medium_t wrappers[3];
    medium_t media[3];
    for (unsigned i = 0U; i < 3U; i++) {
        const medium_t mortal = {&inner[i],   mortal_read, mortal_write,
                                 mortal_sync, mortal_size, mortal_resize};
        media[i]              = supervisor_undo_open(&wrappers[i], &checkpoint, (uint8_t)i, &mortal);
    }
    static uint64_t none; // Size of the other stores, and context of their media.
    store_media[0] = media[2];
    for (unsigned i = 1U; i < SPACECRAFT_STORES; i++) {
        store_media[i] = (medium_t){&none, read_store, write_store, sync_store, size_of_store, resize_store};
    }
    const journal_configuration_t config = {.media    = {media[0], media[1]},
                                            .limit    = MEDIUM_MAX,
                                            .slack    = 512U, // So small that the journal is compacted.
                                            .slots    = slots,
                                            .capacity = RECORDS};
    TEST_ASSERT_EQUAL(STATUS_OK, journal_open(&journal, &config));
}

static void configure(supervisor_config_t* config)
{
    platform                    = config->platform;
    config->platform.start      = mortal_start;
    config->platform.stop       = mortal_stop;
    config->platform.is_running = mortal_is_running;
    config->checkpoint          = &checkpoint;
    config->journal             = &journal;
    config->store_media         = store_media;
    configuration               = *config;
}

static void note_arrival(void* context, const uint8_t* frame, size_t size)
{
    (void)context;
    TEST_ASSERT_TRUE(supervisor_checkpoint_add(&checkpoint, &checkpoint.arrivals, frame, size, NULL, 0U));
}

static void watch_arrivals(void)
{
    message_watch(&fixture.endpoint, (message_arrival_t){NULL, note_arrival});
}

/// Open the next supervisor, which has none of its predecessor's memory.
static void open_successor(void)
{
    static message_slot_t inbox[sizeof fixture.inbox / sizeof fixture.inbox[0]];
    osal_file_close(&fixture.supervisor.log.file); // The system closes the file of a dead process.
    (void)memset(&fixture.supervisor, 0, sizeof fixture.supervisor);
    message_open(&fixture.endpoint, SUPERVISOR_APID, 1U, carrier, inbox, sizeof inbox / sizeof inbox[0]);
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&fixture.endpoint, fixture.members[i].apid));
    }
    open_media();
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_init(&fixture.supervisor, &configuration));
    watch_arrivals();
    fixture.now_ns += 5U * FIXTURE_TICK_NS;
}

/// Make one step that ends at the point `at`. Returns false if the step has fewer points.
static bool dies(unsigned at)
{
    fixture.endpoint.carrier.send = mortal_send;
    points                        = 0U;
    deadline                      = at;
    if (setjmp(killed) == 0) {
        is_armed = true;
        (void)supervisor_step(&fixture.supervisor, fixture.now_ns);
        is_armed                 = false;
        fixture.endpoint.carrier = carrier;
        return false;
    }
    open_successor();
    return true;
}

void setUp(void)
{
    static const image_t empty[2];
    recorded_clear(empty);
    (void)memset(&checkpoint, 0, sizeof checkpoint);
    store_size = 0U;
    inner[0]   = recorded_medium(0U);
    inner[1]   = recorded_medium(1U);
    inner[2]   = (medium_t){&store_size, read_store, write_store, sync_store, size_of_store, resize_store};
    fixture_configure = configure;
    open_media();
    fixture_open_up();
    carrier = fixture.endpoint.carrier;
    watch_arrivals();
    // A circular store of 64 KiB with all diagnostic reports of ARM.
    REQUEST(PUS_SERVICE_STORAGE, 20U, "\1" RING "\0\1\0\0\0\0");
    REQUEST(PUS_SERVICE_STORAGE, 3U, RING "\1\0\20\1\3\1\32");
    REQUEST(PUS_SERVICE_STORAGE, 31U, RING "\1\0\20\0");
    REQUEST(PUS_SERVICE_STORAGE, 1U, "\1" RING);
    schedule_enable(PUS_SERVICE_TIME_SCHEDULE);
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
}

void tearDown(void)
{
    fixture_close();
    fixture_configure = NULL;
}

// ---- Expected effects ----

static const char* text; // Text of all lines since the step.

static uint8_t seen[16384];       // Records of the log, by their number.
static int32_t last_count[APIDS]; // Sequence count of the last report.

static void see(uint64_t number, const char* hex)
{
    unsigned head[4];
    TEST_ASSERT_TRUE((number >= 1U) && (number < sizeof seen));
    TEST_ASSERT_EQUAL_MESSAGE(0U, seen[number], "a record is duplicated");
    seen[number] = 1U;
    TEST_ASSERT_EQUAL(4, sscanf(hex, "%2x%2x%2x%2x", &head[0], &head[1], &head[2], &head[3]));
    const unsigned apid  = head[1];
    const int32_t count  = (int32_t)(((head[2] & 0x3FU) << 8U) | head[3]);
    const bool is_report = (head[0] & 0x10U) == 0U;
    TEST_ASSERT_TRUE(apid < APIDS);
    if (is_report && (apid != HAND)) { // HAND counts from the beginning after its restart.
        if (last_count[apid] >= 0) {
            TEST_ASSERT_EQUAL_MESSAGE(last_count[apid] + 1, count,
                                      "a sequence count is missing or duplicated");
        }
        last_count[apid] = count;
    }
}

/// Expect that the log has each record number once, and that the sequence counts of each component have no
/// gap. The earlier records are in the ASCII file, the others in the spool.
static void expect_complete_log(void)
{
    // Selecting another log writes out all records of this one.
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_packet_log_select(&fixture.supervisor.log, PACKET_LOG_RING));
    (void)memset(seen, 0, sizeof seen);
    for (unsigned i = 0U; i < APIDS; i++) {
        last_count[i] = -1;
    }
    for (const char* line = fixture_log_file("packets.ascii"); line[0] != '\0';
         line             = strchr(line, '\n') + 1) {
        see(strtoul(line, NULL, 10), strstr(line, " T") + 4);
    }
    static char content[1048576];
    char path[160];
    size_t size = 0U;
    (void)snprintf(path, sizeof path, "%s/packets.spool", fixture_directory());
    if (osal_file_load(path, content, sizeof content, &size) != STATUS_OK) {
        size = 0U;
    }
    octet_reader_t reader = octet_reader((const uint8_t*)content, size);
    while (octet_reader_left(&reader) > 0U) {
        const uint32_t length = octet_read_u32(&reader);
        const uint64_t number = octet_read_u64(&reader);
        (void)octet_read_u64(&reader);
        (void)octet_read_u8(&reader);
        const uint8_t* const packet = octet_read_octets(&reader, length - 17U);
        char hex[9];
        TEST_ASSERT_NOT_NULL(packet);
        (void)snprintf(hex, sizeof hex, "%02x%02x%02x%02x", packet[0], packet[1], packet[2], packet[3]);
        see(number, hex);
    }
    for (uint64_t number = 1U; number < fixture.supervisor.log.next_number; number++) {
        TEST_ASSERT_EQUAL_MESSAGE(1U, seen[number], "a record is missing");
    }
}

/// Expect that the components that did not die received every frame once, in both directions.
static void expect_frames_once(void)
{
    for (unsigned i = FIXTURE_GROUND; i <= FIXTURE_ARM; i++) {
        const message_endpoint_t* const member = &fixture.members[i].endpoint;
        const message_channel_t* const up      = &member->slots[0].channel;
        const message_channel_t* const down    = &fixture.endpoint.slots[i].channel;
        TEST_ASSERT_EQUAL(0U, member->counters.lost);
        TEST_ASSERT_TRUE(member->counters.stale <= 2U); // Each death may cause one repeated frame.
        TEST_ASSERT_EQUAL(down->position.sent, member->counters.received);
        TEST_ASSERT_EQUAL(up->position.sent, down->position.taken);
    }
    TEST_ASSERT_EQUAL(0U, fixture.endpoint.counters.lost);
}

static const char* numbered(const char* format, uint16_t number)
{
    static char line[32];
    (void)snprintf(line, sizeof line, format, number);
    return line;
}

static void expect_end(uint16_t number)
{
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, numbered("G 1.1 #%u\n", number)));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, numbered("G 1.7 #%u\n", number)));
    TEST_ASSERT_EQUAL(0U, fixture_count_lines(text, numbered("G 1.8 #%u ", number)));
}

// ---- Tests ----

static struct { // Sequence counts of the requests.
    uint16_t pings[6];
    uint16_t stop;
    uint16_t log;
    uint16_t link;
    uint16_t insert;
} busy;

/// Work for one step: requests to a subsystem and to the supervisor, reports, a process that dies, one that
/// is stopped, a release of the schedule, a new activity, a link, another packet log.
static void make_busy(void)
{
    const uint8_t sqlite = PACKET_LOG_SQLITE;
    const uint8_t lone[] = {0U, LONE};
    release_at(fixture.now_ns + (5U * MS), ARM, 77U);
    fixture.now_ns += FIXTURE_TICK_NS;
    fixture_forget();
    fixture.ack                              = PUS_ACK_ALL;
    fixture.members[FIXTURE_HAND].is_running = false; // The process of HAND dies.
    for (unsigned i = 0U; i < 6U; i++) {
        busy.pings[i] = fixture_tc((i < 4U) ? ARM : SUPERVISOR_APID, PUS_SERVICE_TEST, 1U, NULL, 0U);
    }
    busy.stop = fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_STOP_PROCESS, lone, sizeof lone);
    busy.log  = fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, 3U, &sqlite, 1U);
    busy.link = fixture_request_link(LINK_ARM_STATE);
    request_begin();
    octet_write_octets(&request_data, (const uint8_t*)"\1\1\1", 3U); // Sub-schedule 1, one activity, group 1.
    pus_time_write(&request_data, ((uint64_t)fixture.supervisor.mission->epoch_s * 1000000000U) +
                                      fixture.now_ns + (100000U * MS));
    request_within(ARM, 78U);
    busy.insert = fixture_tc(SUPERVISOR_APID, PUS_SERVICE_TIME_SCHEDULE, 4U, request_data.octets,
                             request_data.position);
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_INFORMATIVE, NOTE);
    fixture_report(FIXTURE_ARM, PUS_SERVICE_HOUSEKEEPING, 26U, "ab", 2U);
}

static void expect_one_stored_packet(void)
{
    pus_packet_store_t* const store = &fixture.supervisor.spacecraft.storage.service.stores[0].log;
    pus_stored_packet_t packet;
    uint64_t cursor = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, pus_packet_store_next(store, &cursor, &packet));
    TEST_ASSERT_EQUAL(STATUS_EMPTY, pus_packet_store_next(store, &cursor, &packet));
}

static void expect_all_once(void)
{
    text = fixture_look();
    for (unsigned i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, numbered("G/16 1.7 #%u\n", busy.pings[i])));
    }
    expect_end(busy.pings[4]);
    expect_end(busy.pings[5]);
    expect_end(busy.stop);
    expect_end(busy.log);
    expect_end(busy.insert);
    // Four requests of the ground, and the request that the schedule has released.
    TEST_ASSERT_EQUAL(5U, fixture_count_lines(text, "16 TC 17.1 from 1\n"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, numbered("G 1.1 #%u\n", busy.link)));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, numbered("G 1.8 #%u ", busy.link))); // HAND has died.
    TEST_ASSERT_EQUAL(2U, fixture_count_lines(text, "G 17.2"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "G 131.4")); // The change of the log.
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "G/16 5.1 0004"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "G/16 3.26 6162"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "G 5.4 00010011")); // PROCESS_LOST.
    TEST_ASSERT_EQUAL(1U, fixture.starts);
    TEST_ASSERT_EQUAL(1U, fixture.stops);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.spacecraft.schedules.time.schedule.count);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.supervisor.subsystem));
    expect_one_stored_packet();
    expect_complete_log();
    expect_frames_once();
}

static void begin_again(void)
{
    tearDown();
    setUp();
}

static void a_supervisor_killed_at_any_point_performs_each_request_once(void)
{
    unsigned at   = 0U;
    bool has_died = true;
    while (has_died) {
        at++;
        make_busy();
        has_died = dies(at);
        fixture_run(120U);
        expect_all_once();
        TEST_ASSERT_EQUAL(has_died ? 1U : 0U, fixture_count_lines(text, RESTARTED "000000020000"));
        begin_again();
    }
    TEST_ASSERT_TRUE_MESSAGE(at > 90U, "fewer points than expected");
}

/// The next supervisor also dies in its first step; a sample of all pairs of points.
static void each_request_is_performed_once_wherever_two_supervisors_die(void)
{
    const unsigned apart = 90U / REPETITIONS(10U);
    for (unsigned first = 1U; first < 100U; first += apart) {
        for (unsigned second = 1U; second < 100U; second += 7U) {
            make_busy();
            TEST_ASSERT_TRUE(dies(first));
            (void)dies(second);
            fixture_run(120U);
            expect_all_once();
            begin_again();
        }
    }
}

/// The report of a failure of the log is raised after the commit of the step, so it is part of the next one.
static void the_failure_of_the_log_repeats_no_sequence_number_wherever_the_supervisor_dies(void)
{
    unsigned at   = 0U;
    bool has_died = true;
    while (has_died) {
        at++;
        fixture.now_ns += FIXTURE_TICK_NS;
        fixture_forget();
        fixture.ack         = PUS_ACK_ALL;
        const uint16_t ping = fixture_tc(ARM, PUS_SERVICE_TEST, 1U, NULL, 0U);
        is_disk_full        = true;
        has_died            = dies(at);
        is_disk_full        = false;
        fixture_run(120U);
        text = fixture_look();
        TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, numbered("G/16 1.7 #%u\n", ping)));
        TEST_ASSERT_EQUAL(has_died ? 1U : 0U, fixture_count_lines(text, RESTARTED "000000020000"));
        TEST_ASSERT_EQUAL(fixture_count_lines(text, "G 5.4 0008"), fixture_count_lines(text, "G 131.4 0003"));
        TEST_ASSERT_TRUE(has_died || (fixture_count_lines(text, "G 5.4 0008") == 1U));
        expect_complete_log();
        expect_frames_once();
        begin_again();
    }
    TEST_ASSERT_TRUE_MESSAGE(at > 10U, "fewer points than expected");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_supervisor_killed_at_any_point_performs_each_request_once);
    RUN_TEST(each_request_is_performed_once_wherever_two_supervisors_die);
    RUN_TEST(the_failure_of_the_log_repeats_no_sequence_number_wherever_the_supervisor_dies);
    return UNITY_END();
}
