// SPDX-License-Identifier: Apache-2.0
// The live port over TCP: every line and its answer or refusal, the record, the pace, the hand while no lines
// arrive, frames and rows; too many clients, a slow client, and a line without end.
#include "sim/app/live.h"
#include "test/support/clients.h"
#include "test/unit/sim/fixtures/rokviss.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define STEP_NS 500000U
#define TURNS 4000U ///< Calls of live_take in which an answer must arrive.

static live_t* live;
static hand_t* hand;
static faults_t faults;
static fault_world_t targets;
static plant_truth_t truth;
static char directory[64];
static uint64_t now_ns;
static osal_socket_t client = OSAL_SOCKET_CLOSED;
static char heard[4096];

static const char* in_directory(const char* const name)
{
    static char path[128];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static const char* content(const char* const name)
{
    static char text[4096];
    FILE* const file = fopen(in_directory(name), "r");
    TEST_ASSERT_NOT_NULL_MESSAGE(file, name);
    text[fread(text, 1U, sizeof text - 1U, file)] = '\0';
    (void)fclose(file);
    return text;
}

static void open_port(const bool has_hand, const bool is_paced)
{
    const live_config_t config = {.directory = directory,
                                  .hand      = has_hand ? hand : NULL,
                                  .faults    = &faults,
                                  .targets   = &targets,
                                  .world     = &rokviss()->world,
                                  .truth     = &truth,
                                  .is_paced  = is_paced};
    TEST_ASSERT_EQUAL_INT(STATUS_OK, live_open(&config, &live));
}

static void join(osal_socket_t* const sock)
{
    const osal_address_t port = {.ipv4 = OSAL_IPV4_LOOPBACK, .port = (uint16_t)atoi(content("live.port"))};
    *sock                     = (osal_socket_t)OSAL_SOCKET_CLOSED;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, connect_tcp(sock, port));
}

/// One step of the simulator.
static void step(void)
{
    hand_step(hand, now_ns);
    now_ns += STEP_NS;
    truth.time_ns = now_ns;
    live_take(live, now_ns);
    live_report(live);
}

/// Returns the octets up to the next line end; serves the port until it has arrived, or fails.
static const char* hear(osal_socket_t* const sock)
{
    size_t size = 0U;
    for (unsigned turn = 0U; turn < TURNS; turn++) {
        size_t got            = 0U;
        const status_t status = osal_stream_receive(sock, (uint8_t*)&heard[size], 1U, &got);
        size += (status == STATUS_OK) ? got : 0U;
        heard[size] = '\0';
        if ((size > 0U) && (heard[size - 1U] == '\n')) {
            return heard;
        }
        if (status != STATUS_OK) {
            TEST_ASSERT_EQUAL_INT_MESSAGE(STATUS_EMPTY, status, heard);
            live_take(live, now_ns);
            live_report(live);
        }
    }
    TEST_FAIL_MESSAGE("no line arrives");
    return heard;
}

static void say(osal_socket_t* const sock, const char* const text)
{
    size_t sent = 0U;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, osal_stream_send(sock, (const uint8_t*)text, strlen(text), &sent));
    TEST_ASSERT_EQUAL_UINT(strlen(text), sent);
}

static const char* ask(const char* const line)
{
    say(&client, line);
    return hear(&client);
}

static void refuses(const char* const line, const char* const words)
{
    const char* const answer = ask(line);
    TEST_ASSERT_EQUAL_STRING_LEN("refused live:", answer, strlen("refused live:"));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(answer, words), answer);
}

static void accepts(const char* const line, const char* const words)
{
    const char* const answer = ask(line);
    TEST_ASSERT_EQUAL_STRING_LEN("ok ", answer, strlen("ok "));
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(answer, words), answer);
}

void setUp(void)
{
    char error[SCENARIO_ERROR_MAX];
    (void)snprintf(directory, sizeof directory, "/tmp/hirosco-live-XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(directory));
    memset(&targets, 0, sizeof targets);
    memset(&faults, 0, sizeof faults);
    memset(&truth, 0, sizeof truth);
    targets.channel[0][0].name = "robot";
    now_ns                     = 0U;
    TEST_ASSERT_EQUAL_INT(STATUS_OK, hand_load(&rokviss()->hand, NULL, NULL, &hand, error));
}

void tearDown(void)
{
    osal_socket_close(&client);
    TEST_ASSERT_EQUAL_INT(STATUS_OK, live_close(live));
    live = NULL;
    hand_destroy(hand);
    hand = NULL;
    (void)unlink(in_directory("live.port"));
    (void)unlink(in_directory("live.scn"));
    (void)unlink(in_directory("operator.log"));
    (void)rmdir(directory);
}

static void a_directory_that_cannot_be_written_is_an_error(void)
{
    const live_config_t config = {.directory = "/tmp/hirosco-no-directory", .targets = &targets};
    TEST_ASSERT_EQUAL_INT(STATUS_IO, live_open(&config, &live));
    TEST_ASSERT_NULL(live);
}

static void the_pace_is_set_and_reported(void)
{
    open_port(true, true);
    join(&client);
    accepts("time\n", "ok 0.000000000 speed 1\n");
    accepts("pause\n", " paused speed 1\n");
    TEST_ASSERT_TRUE(live_is_held(live, now_ns));
    accepts("step 0.001\n", "ok 0.000000000 speed 1\n");
    TEST_ASSERT_FALSE(live_is_held(live, now_ns + 999999U));
    TEST_ASSERT_TRUE(live_is_held(live, now_ns + 1000000U));
    accepts("speed 0.5\n", " speed 0.5\n");
    accepts("speed 0\n", " speed 0\n");
    TEST_ASSERT_EQUAL_DOUBLE(0.0, live_speed(live));
    accepts("resume\n", "ok 0.000000000 speed 0\n");
    TEST_ASSERT_FALSE(live_is_held(live, now_ns));
    refuses("pause now\n", "expected");
    refuses("speed\n", "speed <factor>");
    refuses("speed 101\n", "0.1");
    refuses("step\n", "step <s>");
    refuses("step 0\n", "time [s]");
    TEST_ASSERT_EQUAL_DOUBLE(0.0, live_speed(live));
    TEST_ASSERT_EQUAL_STRING("", content("live.scn"));
}

static void without_a_common_clock_the_pace_is_refused(void)
{
    open_port(true, false);
    join(&client);
    refuses("pause\n", "TIME=real");
}

static void a_line_of_the_hand_is_recorded_and_marked_once(void)
{
    FILE* const log = fopen(in_directory("operator.log"), "w");
    TEST_ASSERT_NOT_NULL(log);
    (void)fclose(log);
    open_port(true, true);
    join(&client);
    accepts("name desk\n", "ok ");
    step();
    accepts("hand aim 0.1 0 0.5\n", " speed 1 hand desk\n");
    accepts("hand aim 0.2 0 0.5\n", " hand desk\n");
    accepts("hand rest\n", "speed 1\n");
    TEST_ASSERT_EQUAL_STRING("0.000500000 hand aim 0.1 0 0.5 # desk\n0.000500000 hand aim 0.2 0 0.5 # desk\n"
                             "0.000500000 hand rest # desk\n",
                             content("live.scn"));
    const char* const marks = content("operator.log");
    TEST_ASSERT_NOT_NULL(strstr(marks, "\"words\": [\"hand\", \"aim\", \"0.1\", \"0\", \"0.5\"]"));
    TEST_ASSERT_NULL(strstr(marks, "\"0.2\""));
    TEST_ASSERT_NOT_NULL(strstr(marks, "live hand rest (desk)"));
}

static void a_hand_without_lines_holds_and_lets_go(void)
{
    open_port(true, true);
    join(&client);
    accepts("hand aim 0.1 0 0.1\n", " hand live\n");
    while (now_ns < LIVE_HOLD_NS) {
        step();
    }
    step();
    TEST_ASSERT_EQUAL_STRING("hold", hand_intent(hand)->verb);
    accepts("time\n", " speed 1\n");
    while (now_ns <= LIVE_LET_GO_NS) {
        step();
    }
    step();
    TEST_ASSERT_EQUAL_STRING("let_go", hand_intent(hand)->verb);
    TEST_ASSERT_NOT_NULL(strstr(content("live.scn"), "0.500000000 hand hold # no line for 0.5 s\n"
                                                     "5.000000000 hand let_go # no line for 5 s\n"));
}

static void refused_lines_are_not_recorded(void)
{
    open_port(true, true);
    join(&client);
    refuses("jump\n", "hand, fault, pause");
    refuses("hand\n", "a verb of the hand");
    refuses("fault\n", "a fault");
    refuses("hand fly\n", "fly");
    refuses("fault break robot\n", "break");
    refuses("1 2 3 4 5 6 7 8 9 10 11 12 13\n", "at most 12");
    refuses("name\n", "name <word>");
    refuses("name abcdefghijklmnopqrstuvwx\n", "at most 23");
    refuses("name a\"b\n", "without quotation marks");
    refuses("frames robot\n", "frames <bus> on|off");
    refuses("frames moon on\n", "a bus of this run");
    refuses("frames robot maybe\n", "on or off");
    refuses("truth\n", "truth <Hz>");
    refuses("truth 1001\n", "rate [Hz]");
    refuses("time now\n", "time");
    say(&client, "\n"); // An empty line has no answer.
    accepts("time\n", "ok ");
    TEST_ASSERT_EQUAL_STRING("", content("live.scn"));
}

static void a_world_without_a_hand_takes_faults_only(void)
{
    open_port(false, true);
    join(&client);
    refuses("hand rest\n", "this world has no hand");
}

static void frames_and_rows_are_sent_to_clients_that_request_them(void)
{
    const osal_can_frame_t frame = {.id = 0x80U};
    open_port(true, true);
    join(&client);
    live_frame(live, "robot", &frame); // No client has asked yet.
    accepts("frames robot on\n", "ok ");
    live_frame(live, "robot", &frame);
    live_frame(live, "elsewhere", &frame);
    TEST_ASSERT_NOT_NULL(strstr(hear(&client), " robot 080#"));
    accepts("frames robot off\n", "ok ");
    live_frame(live, "robot", &frame);
    say(&client, "truth 100\n");
    TEST_ASSERT_EQUAL_STRING_LEN("columns time ", hear(&client), strlen("columns time "));
    TEST_ASSERT_EQUAL_STRING_LEN("ok ", hear(&client), strlen("ok "));
    TEST_ASSERT_EQUAL_STRING_LEN("truth ", hear(&client), strlen("truth "));
    accepts("truth 0\n", "ok ");
}

static void a_slow_client_loses_whole_frames_and_gets_their_number(void)
{
    const osal_can_frame_t frame = {.id = 0x123U, .length = 8U};
    open_port(true, true);
    join(&client);
    accepts("frames robot on\n", "ok ");
    for (unsigned i = 0U; i < 400000U; i++) { // More than the kernel and the port keep.
        live_frame(live, "robot", &frame);
        if ((i % 1000U) == 0U) {
            live_report(live);
        }
    }
    // Read in large pieces; the last octets of a piece are kept, because a word may begin there.
    static char piece[65536];
    const char* note = NULL;
    size_t kept      = 0U;
    for (unsigned turn = 0U; (turn < TURNS) && (note == NULL); turn++) {
        size_t got = 0U;
        const status_t status =
            osal_stream_receive(&client, (uint8_t*)&piece[kept], sizeof piece - 1U - kept, &got);
        TEST_ASSERT_TRUE((status == STATUS_OK) || (status == STATUS_EMPTY));
        kept += (status == STATUS_OK) ? got : 0U;
        piece[kept] = '\0';
        note        = strstr(piece, "dropped ");
        if ((note == NULL) && (kept > 64U)) {
            memmove(piece, &piece[kept - 64U], 64U);
            kept = 64U;
        }
        live_frame(live, "robot", &frame);
        live_report(live);
    }
    TEST_ASSERT_NOT_NULL(note);
    TEST_ASSERT_EQUAL_INT('\n', note[-1]); // Frames are dropped whole.
    TEST_ASSERT_GREATER_THAN_INT(0, atoi(&note[strlen("dropped ")]));
}

static void a_ninth_client_is_refused_and_an_endless_line_disconnects(void)
{
    static osal_socket_t others[LIVE_CLIENTS_MAX];
    static char endless[SCENARIO_LINE_MAX + 1U];
    size_t got = 0U;
    open_port(true, true);
    for (unsigned i = 0U; i < LIVE_CLIENTS_MAX; i++) {
        join(&others[i]);
        say(&others[i], "time\n");
        (void)hear(&others[i]);
    }
    join(&client);
    TEST_ASSERT_EQUAL_STRING("refused live:0: found one more client, expected at most 8\n", hear(&client));
    osal_socket_close(&client);
    memset(endless, 'x', sizeof endless - 1U);
    say(&others[0], endless);
    status_t status = STATUS_EMPTY;
    for (unsigned turn = 0U; (turn < TURNS) && (status == STATUS_EMPTY); turn++) {
        live_take(live, now_ns);
        status = osal_stream_receive(&others[0], (uint8_t*)heard, sizeof heard, &got);
    }
    TEST_ASSERT_TRUE(status != STATUS_EMPTY);
    join(&client); // Its slot is free again.
    accepts("time\n", "ok ");
    for (unsigned i = 0U; i < LIVE_CLIENTS_MAX; i++) {
        osal_socket_close(&others[i]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_directory_that_cannot_be_written_is_an_error);
    RUN_TEST(the_pace_is_set_and_reported);
    RUN_TEST(without_a_common_clock_the_pace_is_refused);
    RUN_TEST(a_line_of_the_hand_is_recorded_and_marked_once);
    RUN_TEST(a_hand_without_lines_holds_and_lets_go);
    RUN_TEST(refused_lines_are_not_recorded);
    RUN_TEST(a_world_without_a_hand_takes_faults_only);
    RUN_TEST(frames_and_rows_are_sent_to_clients_that_request_them);
    RUN_TEST(a_slow_client_loses_whole_frames_and_gets_their_number);
    RUN_TEST(a_ninth_client_is_refused_and_an_endless_line_disconnects);
    return UNITY_END();
}
