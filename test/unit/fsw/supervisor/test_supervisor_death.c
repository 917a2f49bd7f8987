// SPDX-License-Identifier: Apache-2.0
// The supervisor dies between two steps, and the next one continues with its checkpoint.
#include "fsw/supervisor/supervisor.h"

#include "test/unit/fsw/supervisor/supervisor_fixture.h"
#include "unity.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Reports of events of the supervisor, up to the event number; fields of the event follow.
#define RESTARTED "G 5.2 0014"    ///< SUPERVISOR_RESTARTED.
#define DIFFERS "G 5.2 0015"      ///< ADOPTION_DIFFERS.
#define LINK_DIFFERS "G 5.2 0018" ///< ADOPTION_LINK_DIFFERS.
#define DAMAGED "G 5.4 0016"      ///< CHECKPOINT_DAMAGED.
#define BACK "G 5.1 001F"         ///< RECOMMISSIONED.
#define STOPPED "G 5.2 0020"      ///< RECOMMISSION_STOPPED.

static checkpoint_t checkpoint;
static supervisor_config_t configuration;
static uint32_t life;

static void configure(supervisor_config_t* config)
{
    config->checkpoint = &checkpoint;
    configuration      = *config;
}

static void note_arrival(void* context, const uint8_t* frame, size_t size)
{
    TEST_ASSERT_TRUE(supervisor_checkpoint_add(context, &checkpoint.arrivals, frame, size, NULL, 0U));
}

/// Watch received messages as the program does: the blocks are kept when the supervisor dies.
static void watch(void)
{
    message_watch(&fixture.endpoint, (message_arrival_t){&checkpoint, note_arrival});
}

void setUp(void)
{
    (void)memset(&checkpoint, 0, sizeof checkpoint);
    fixture_configure = configure;
    life              = 1U;
    fixture_open_up();
    watch();
}

void tearDown(void)
{
    fixture_close();
}

/// Kill the supervisor and open the next one, which has none of the memory of the first.
static void die(void)
{
    static message_slot_t inbox[sizeof fixture.inbox / sizeof fixture.inbox[0]];
    osal_file_close(&fixture.supervisor.log.file); // The system closes the file of a dead process.
    (void)memset(&fixture.supervisor, 0, sizeof fixture.supervisor);
    life++; // The channels begin a new life, too.
    message_open(&fixture.endpoint, SUPERVISOR_APID, life, fixture.endpoint.carrier, inbox,
                 sizeof inbox / sizeof inbox[0]);
    for (unsigned i = 0U; i < FIXTURE_MEMBERS; i++) {
        TEST_ASSERT_EQUAL(STATUS_OK, message_add_peer(&fixture.endpoint, fixture.members[i].apid));
    }
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_init(&fixture.supervisor, &configuration));
    watch();
    fixture.now_ns += 5U * FIXTURE_TICK_NS;
}

/// Expect that the record numbers of the log are 1, 2, 3 and so on, each once.
static void expect_complete_log(void)
{
    unsigned long number = 0UL;
    for (const char* line = fixture_log_file("packets.ascii"); line[0] != '\0';
         line             = strchr(line, '\n') + 1) {
        number++;
        TEST_ASSERT_EQUAL_UINT64(number, strtoul(line, NULL, 10));
    }
    TEST_ASSERT_TRUE(number > 10UL);
}

static void a_restarted_supervisor_continues_and_reports_it(void)
{
    die();
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has(RESTARTED "000000020000"));
    // The supervisor requests the state of each subsystem.
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.4 from 8001"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.4 from 8001"));
    fixture_run(60U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.supervisor.subsystem));
    TEST_ASSERT_FALSE(fixture_has(DIFFERS));
    TEST_ASSERT_FALSE(fixture_has("2 TC 129.8")); // A running subsystem keeps its state and gets no order.
    fixture_forget();
    die();
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has(RESTARTED "000000030000"));
    expect_complete_log();
}

static void a_stopped_subsystem_gets_no_request_for_its_status(void)
{
    const uint8_t apid[2] = {0U, LONE};
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, PUS_MISSION_STOP_PROCESS, apid, sizeof apid);
    fixture_run(2U);
    die();
    fixture_run(2U);
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.4 from 8001"));
    TEST_ASSERT_FALSE(fixture_has("18 TC 129.4 from 8001"));
}

static void a_request_in_progress_is_answered_once(void)
{
    fixture.members[FIXTURE_ARM].is_passive = true;
    const uint16_t number                   = fixture_request_state(ARM, STATE_PRE_OPERATIONAL);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.1 03 from 1"));
    die();
    fixture_step();
    fixture_forget();
    fixture_verify(FIXTURE_ARM, 1U, number);
    fixture_verify(FIXTURE_ARM, 7U, number);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("G/16 1.1 #0"));
    TEST_ASSERT_TRUE(fixture_has("G/16 1.7 #0"));
    TEST_ASSERT_FALSE(fixture_has("G 1."));
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.pending.count);
    expect_complete_log();
}

static void a_request_received_while_the_supervisor_is_dead_is_performed_once(void)
{
    fixture.members[FIXTURE_ARM].is_passive = true;
    die();
    (void)fixture_request_state(ARM, STATE_PRE_OPERATIONAL);
    fixture_step();
    fixture_run(3U);
    const char* const text  = fixture_look();
    const char* const first = strstr(text, "16 TC 129.1 03 from 1");
    TEST_ASSERT_NOT_NULL(first);
    TEST_ASSERT_NULL(strstr(first + 1, "16 TC 129.1 03 from 1"));
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.pending.count);
}

static void a_subsystem_that_dies_meanwhile_still_ends_its_requests(void)
{
    fixture.members[FIXTURE_ARM].is_passive = true;
    (void)fixture_request_state(ARM, STATE_PRE_OPERATIONAL);
    fixture_step();
    die();
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 0408 10"));
}

static void requests_that_the_dead_supervisor_was_performing_fail_with_the_reason(void)
{
    const uint8_t apid[2]                   = {0U, ARM};
    fixture.members[FIXTURE_ARM].is_passive = true;
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_TEST, 3U, apid, sizeof apid);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("G 1.3 #0"));
    fixture_forget();
    die();
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has("G 1.8 #0 040B 2"));
    TEST_ASSERT_TRUE(fixture_has(RESTARTED "000000020001"));
    fixture_forget();
    die();
    fixture_run(200U);
    TEST_ASSERT_FALSE(fixture_has("G 1.8")); // The failure is reported only once.
}

static void the_graph_follows_the_link_reports_of_subsystems(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    die();
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has("16 TC 130.8 00 from 8001"));
    TEST_ASSERT_FALSE(fixture_has(LINK_DIFFERS)); // The link has not changed.
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
    fixture_forget();
    fixture.members[FIXTURE_ARM].open_links &= ~((uint32_t)1U << (LINK_ARM_STATE - 1U));
    fixture.members[FIXTURE_HAND].open_links |= (uint32_t)1U << (LINK_LONE_STATE - 1U);
    die();
    fixture_run(5U);
    TEST_ASSERT_TRUE(fixture_has(LINK_DIFFERS "00100001")); // One end was closed during the death.
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 0001"));      // The supervisor closes the other end.
    TEST_ASSERT_TRUE(fixture_has(LINK_DIFFERS "00110003")); // A link was opened without a command.
    TEST_ASSERT_TRUE(fixture_has("17 TC 130.7 0003"));
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.graph.count);
    fixture_forget();
    die();
    fixture_run(5U);
    TEST_ASSERT_FALSE(fixture_has(LINK_DIFFERS));
}

/// A link that was agreed and is not open yet can be opened as without the death.
static void a_restarted_supervisor_has_the_link_agreements(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
    for (uint16_t link = LINK_ARM_STATE; link <= LINK_HAND_POS; link++) {
        (void)fixture_request_link(link);
        fixture_run(5U);
    }
    die();
    fixture_run(5U);
    TEST_ASSERT_EQUAL(0U, fixture.supervisor.graph.count);
    for (uint16_t link = LINK_ARM_STATE; link <= LINK_HAND_POS; link++) {
        (void)fixture_open_link(link);
        fixture_run(5U);
    }
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
}

static void a_restarted_supervisor_has_the_networks(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    die();
    fixture_step();
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
    fixture_forget();
    fixture_event(FIXTURE_ARM, PUS_SEVERITY_HIGH, GRIPLESS);
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 0602 from 8001"));
    die();
    fixture_put_in_state(FIXTURE_ARM, STATE_ERROR_OPERATIONAL);
    fixture_forget();
    fixture_run(60U); // The plan continues to its end.
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.8 0003 from 8001"));
    TEST_ASSERT_TRUE(fixture_has("17 TC 129.8 0003 from 8001"));
}

static void a_negotiation_continues(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_put_in_state(FIXTURE_HAND, STATE_PRE_OPERATIONAL);
    fixture.members[FIXTURE_ARM].takes_nothing = true;
    const uint16_t number                      = fixture_request_link(LINK_ARM_STATE);
    fixture_step();
    die();
    fixture.members[FIXTURE_ARM].takes_nothing = false;
    fixture_forget();
    fixture_run(5U);
    char completed[16];
    (void)snprintf(completed, sizeof completed, "G 1.7 #%u\n", number);
    TEST_ASSERT_TRUE(fixture_has(completed));
    fixture_forget();
    (void)fixture_open_link(LINK_ARM_STATE);
    fixture_run(5U);
    TEST_ASSERT_EQUAL(1U, fixture.supervisor.graph.count);
}

/// ARM and HAND are linked in OPERATIONAL; the process of ARM dies, and both are being recommissioned.
static void start_recommissioning(void)
{
    fixture_link_up(STATE_OPERATIONAL);
    for (uint16_t i = 0U; i < fixture.supervisor.mission->subsystem_count; i++) {
        ((mission_subsystem_t*)fixture.supervisor.registry[i].mission)->is_recommissioned = true;
    }
    fixture_run(20U);
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(1U);
    TEST_ASSERT_TRUE(fixture.supervisor.registry[0].recommission.is_active);
}

static void expect_recommissioned(void)
{
    TEST_ASSERT_TRUE(fixture_has(BACK "00100005"));
    TEST_ASSERT_TRUE(fixture_has(BACK "00110005"));
    TEST_ASSERT_FALSE(fixture_has(STOPPED));
    TEST_ASSERT_FALSE(fixture_has("G 1.")); // No verification, because no user has requested this.
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_ARM].state);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, fixture.members[FIXTURE_HAND].state);
    TEST_ASSERT_EQUAL(2U, fixture.supervisor.graph.count);
}

/// Check the data with which a recommissioning continues or begins.
static void expect_taken_over(const registry_entry_t* was, const registry_entry_t* entry)
{
    TEST_ASSERT_EQUAL(was->is_restarted, entry->is_restarted);
    TEST_ASSERT_EQUAL_UINT64(was->error_ns, entry->error_ns);
    TEST_ASSERT_EQUAL(was->rested, entry->rested);
    TEST_ASSERT_EQUAL(was->rested_with, entry->rested_with);
    TEST_ASSERT_EQUAL(was->recommission.is_active, entry->recommission.is_active);
    TEST_ASSERT_EQUAL(was->recommission.has_left_offline, entry->recommission.has_left_offline);
    TEST_ASSERT_EQUAL(was->recommission.target, entry->recommission.target);
    TEST_ASSERT_EQUAL(was->recommission.configuration, entry->recommission.configuration);
    TEST_ASSERT_EQUAL(was->recommission.ordered, entry->recommission.ordered);
    TEST_ASSERT_EQUAL(was->recommission.seen, entry->recommission.seen);
    TEST_ASSERT_EQUAL(was->recommission.seen_phase, entry->recommission.seen_phase);
    TEST_ASSERT_EQUAL_UINT64(was->recommission.since_ns, entry->recommission.since_ns);
}

/// The supervisor dies this number of ticks after the recommissioning began; its successor completes
/// it.
static void die_while_recommissioning(unsigned ticks)
{
    start_recommissioning();
    fixture_run(ticks);
    const registry_entry_t was[2] = {fixture.supervisor.registry[0], fixture.supervisor.registry[1]};
    die();
    expect_taken_over(&was[0], &fixture.supervisor.registry[0]);
    expect_taken_over(&was[1], &fixture.supervisor.registry[1]);
    fixture_run(200U);
    expect_recommissioned();
    fixture_forget();
    // The next supervisor still knows how the links are opened.
    fixture.members[FIXTURE_ARM].is_running = false;
    fixture_run(200U);
    expect_recommissioned();
    expect_complete_log();
}

/// The supervisor dies at every third tick of the recommissioning.
static void a_recommissioning_continues(void)
{
    for (unsigned ticks = 0U; ticks < 140U; ticks += 3U) {
        die_while_recommissioning(ticks);
        tearDown();
        setUp();
    }
}

/// Supervisor and member die. The next supervisor detects the death of the member and knows its earlier
/// state.
static void a_member_that_dies_with_the_supervisor_is_recommissioned(void)
{
    start_recommissioning();
    fixture_run(200U);
    expect_recommissioned();
    fixture_forget();
    fixture.members[FIXTURE_ARM].is_running = false;
    die();
    fixture_run(200U);
    expect_recommissioned();
}

static void a_restarted_supervisor_has_the_mode(void)
{
    const uint8_t safe[1] = {MODE_SAFE};
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, 1U, safe, sizeof safe);
    fixture_step();
    die();
    fixture_step();
    TEST_ASSERT_EQUAL(MODE_SAFE, fixture.supervisor.mode);
}

static void select_log(uint8_t strategy)
{
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, 3U, &strategy, 1U);
    fixture_run(3U);
    TEST_ASSERT_EQUAL(strategy, fixture.supervisor.log.wanted);
}

static void a_restarted_supervisor_has_the_records_in_memory(void)
{
    select_log(PACKET_LOG_RING);
    fixture_run(20U);
    die();
    fixture_run(20U);
    TEST_ASSERT_EQUAL(PACKET_LOG_RING, fixture.supervisor.log.strategy);
    select_log(PACKET_LOG_ASCII);
    expect_complete_log();
}

// ---- Within a step ----

static message_carrier_t true_carrier;
static unsigned sends_left;
static bool is_killed_before; // The last send is not performed.
static jmp_buf killed;

static status_t mortal_send(void* context, uint16_t to, const uint8_t* frame, size_t size)
{
    status_t status = STATUS_OK;
    (void)context;
    sends_left--;
    if ((sends_left > 0U) || !is_killed_before) {
        status = true_carrier.send(true_carrier.context, to, frame, size);
    }
    if (sends_left == 0U) {
        longjmp(killed, 1);
    }
    return status;
}

/// Make one step in which the supervisor dies at its n-th send. Returns false if the step has fewer sends.
static bool dies_within_a_step(unsigned sends)
{
    true_carrier             = fixture.endpoint.carrier;
    sends_left               = sends;
    fixture.endpoint.carrier = (message_carrier_t){NULL, mortal_send};
    if (setjmp(killed) == 0) {
        (void)supervisor_step(&fixture.supervisor, fixture.now_ns);
        fixture.endpoint.carrier = true_carrier;
        return false;
    }
    fixture.endpoint.carrier = true_carrier;
    die();
    return true;
}

/// Requests to a subsystem, one to the supervisor, and a report are received in one step.
static void expect_that_everything_arrives_once(unsigned sends)
{
    fixture.members[FIXTURE_ARM].is_passive  = true;
    fixture.members[FIXTURE_HAND].is_passive = true;
    (void)fixture_request_state(ARM, STATE_PRE_OPERATIONAL);
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_TEST, 1U, NULL, 0U);
    (void)fixture_request_state(HAND, STATE_PRE_OPERATIONAL);
    fixture_event(FIXTURE_LONE, PUS_SEVERITY_INFORMATIVE, NOTE);
    const bool has_died = dies_within_a_step(sends);
    fixture_run(60U);
    const char* const text = fixture_look();
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "16 TC 129.1 03 from 1\n"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "17 TC 129.1 03 from 1\n"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "G/18 5.1 0004"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "G 1.1 #1\n"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "G 17.2"));
    TEST_ASSERT_EQUAL(1U, fixture_count_lines(text, "G 1.7 #1\n"));
    TEST_ASSERT_EQUAL(has_died ? 1U : 0U, fixture_count_lines(text, RESTARTED "000000020000"));
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.supervisor.subsystem));
    expect_complete_log();
}

static void an_interrupted_step_is_repeated(void)
{
    unsigned deaths = 0U;
    for (unsigned sends = 1U; sends <= 10U; sends++) {
        for (unsigned before = 0U; before < 2U; before++) {
            is_killed_before = (before != 0U);
            expect_that_everything_arrives_once(sends);
            deaths += (fixture.supervisor.lives > 1U) ? 1U : 0U;
            tearDown();
            setUp();
        }
    }
    TEST_ASSERT_TRUE(deaths >= 10U);
}

static void a_shutdown_continues(void)
{
    (void)fixture_tc(SUPERVISOR_APID, PUS_SERVICE_MISSION, 5U, NULL, 0U);
    fixture_step();
    if (fixture.supervisor.shutdown_step == 0U) {
        fixture.is_stop_requested = true;
        fixture_step();
    }
    TEST_ASSERT_TRUE(fixture.supervisor.shutdown_step != 0U);
    die();
    fixture_run(100U);
    TEST_ASSERT_TRUE(fixture.is_finished);
}

static void the_report_of_the_member_takes_precedence(void)
{
    fixture_put_in_state(FIXTURE_ARM, STATE_PRE_OPERATIONAL);
    fixture_step();
    die();
    fixture.members[FIXTURE_ARM].state = STATE_ERROR_OPERATIONAL; // The report of this state was lost.
    fixture.members[FIXTURE_ARM].phase = PHASE_SECURED;
    fixture.next_status_ns             = 0U;
    fixture_run(3U);
    TEST_ASSERT_TRUE(fixture_has(DIFFERS "0010"));
    TEST_ASSERT_EQUAL(STATE_ERROR_OPERATIONAL, fixture.supervisor.registry[0].state);
    fixture_forget();
    fixture_run(100U);
    TEST_ASSERT_FALSE(fixture_has(DIFFERS)); // The difference is reported only once.
}

static void after_a_damaged_commit_the_previous_one_is_used(void)
{
    fixture_step();
    checkpoint.banks[(checkpoint.banks[0].generation > checkpoint.banks[1].generation) ? 0U : 1U]
        .state.mode ^= 1U;
    die();
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has(DAMAGED "0100"));
    TEST_ASSERT_EQUAL_UINT8(MODE_NOMINAL, fixture.supervisor.mode);
    TEST_ASSERT_TRUE(fixture_has(RESTARTED));
}

static void without_a_checkpoint_the_supervisor_starts_without_adoption_and_reports_it(void)
{
    checkpoint.banks[0].sum ^= 1U;
    checkpoint.banks[1].sum ^= 1U;
    configuration.log_records = fixture.supervisor.log.next_number - 1U;
    die();
    fixture_step();
    TEST_ASSERT_TRUE(fixture.supervisor.lives == 1U);
    // The members learn that the supervisor has restarted.
    TEST_ASSERT_TRUE(fixture_has("16 TC 129.4 from 8001"));
    TEST_ASSERT_FALSE(fixture_has("1 TC 129.4"));
    expect_complete_log();
    TEST_ASSERT_TRUE(fixture_has(DAMAGED "0000"));
    // It is unknown which requests and plans were in progress.
    TEST_ASSERT_EQUAL_UINT8(MODE_SAFE, fixture.supervisor.mode);
    fixture_run(60U);
    TEST_ASSERT_EQUAL(STATE_OPERATIONAL, subsystem_state(&fixture.supervisor.subsystem));
}

static bool can_keep;
static const checkpoint_t* kept;

static bool keep_checkpoint(void* context, const checkpoint_t* of)
{
    TEST_ASSERT_EQUAL_PTR(configuration.platform.context, context);
    kept = of;
    return can_keep;
}

/// A damaged checkpoint is kept for analysis before it is overwritten.
static void a_damaged_checkpoint_is_preserved(void)
{
    configuration.keep_checkpoint = keep_checkpoint;
    die();
    TEST_ASSERT_NULL(kept);
    for (unsigned i = 0U; i < 2U; i++) {
        can_keep = (i == 0U);
        checkpoint.banks[0].sum ^= 1U;
        checkpoint.banks[1].sum ^= 1U;
        die();
        TEST_ASSERT_EQUAL_PTR(&checkpoint, kept);
        fixture_step();
        TEST_ASSERT_TRUE(fixture_has(can_keep ? DAMAGED "0001" : DAMAGED "0000"));
        fixture_run(5U);
        fixture_forget();
    }
}

/// If the supervisor ran as a thread, its messages are still in memory and must not be restored a second
/// time.
static void messages_that_were_kept_continue_as_they_are(void)
{
    fixture_run(5U);
    const uint32_t sent = fixture.supervisor.subsystem.process.counters.sent;
    TEST_ASSERT_TRUE(sent > 0U);
    osal_file_close(&fixture.supervisor.log.file);
    (void)memset(&fixture.supervisor, 0, sizeof fixture.supervisor);
    configuration.is_endpoint_kept = true;
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_init(&fixture.supervisor, &configuration));
    fixture.now_ns += 5U * FIXTURE_TICK_NS;
    fixture_step();
    TEST_ASSERT_TRUE(fixture_has(RESTARTED "000000020000"));
    fixture_forget();
    (void)fixture_request_state(ARM, STATE_PRE_OPERATIONAL);
    fixture_run(60U);
    TEST_ASSERT_TRUE(fixture_has("G/16 1.7 #"));
    TEST_ASSERT_FALSE(fixture_has(DIFFERS));
    expect_complete_log();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(a_restarted_supervisor_continues_and_reports_it);
    RUN_TEST(a_stopped_subsystem_gets_no_request_for_its_status);
    RUN_TEST(a_request_in_progress_is_answered_once);
    RUN_TEST(a_request_received_while_the_supervisor_is_dead_is_performed_once);
    RUN_TEST(a_subsystem_that_dies_meanwhile_still_ends_its_requests);
    RUN_TEST(requests_that_the_dead_supervisor_was_performing_fail_with_the_reason);
    RUN_TEST(the_graph_follows_the_link_reports_of_subsystems);
    RUN_TEST(a_restarted_supervisor_has_the_link_agreements);
    RUN_TEST(a_restarted_supervisor_has_the_networks);
    RUN_TEST(a_negotiation_continues);
    RUN_TEST(a_recommissioning_continues);
    RUN_TEST(a_member_that_dies_with_the_supervisor_is_recommissioned);
    RUN_TEST(a_restarted_supervisor_has_the_mode);
    RUN_TEST(a_restarted_supervisor_has_the_records_in_memory);
    RUN_TEST(an_interrupted_step_is_repeated);
    RUN_TEST(a_shutdown_continues);
    RUN_TEST(the_report_of_the_member_takes_precedence);
    RUN_TEST(after_a_damaged_commit_the_previous_one_is_used);
    RUN_TEST(without_a_checkpoint_the_supervisor_starts_without_adoption_and_reports_it);
    RUN_TEST(a_damaged_checkpoint_is_preserved);
    RUN_TEST(messages_that_were_kept_continue_as_they_are);
    return UNITY_END();
}
