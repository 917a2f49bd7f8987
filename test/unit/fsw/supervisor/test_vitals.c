// SPDX-License-Identifier: Apache-2.0
#define _DEFAULT_SOURCE // MAP_ANONYMOUS.
#include "fsw/supervisor/vitals.h"

#include "fsw/framework/subsystem/state_machine.h"
#include "unity.h"

#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define NOW 5000000000ULL

static mission_descriptor_t mission;
static vitals_t vitals;
static supervisor_vitals_t state;
static supervisor_vitals_t found;
static vitals_limits_t limits;
static bool is_older;

/// A mission of two subsystems, the supervisor and a link; what the checks ask of it is there.
static void make_mission(void)
{
    mission                       = (mission_descriptor_t){.interface_hash  = 0x0102030405060708U,
                                                           .subsystem_count = 3U,
                                                           .mode_count      = 2U,
                                                           .link_count      = 1U,
                                                           .plan_count      = 1U,
                                                           .action_count    = 2U};
    static const uint16_t apids[] = {16U, 17U, 1U};
    for (unsigned i = 0U; i < 3U; i++) {
        mission.subsystems[i].apid = apids[i];
    }
    mission.modes[1].id = 1U;
    mission.links[0]    = (mission_link_t){
           .number = 1U, .producer_apid = 16U, .producer_port = 1U, .consumer_apid = 17U, .consumer_port = 2U};
    mission.plans[0] = (mission_plan_t){.action_count = 2U};
}

/// Something in every table.
static void make_state(void)
{
    const vitals_edge_t edge = {1U, 16U, 1U, 17U, 2U, 0U};
    (void)memset(&state, 0, sizeof state);
    state.interface_hash  = mission.interface_hash;
    state.now_ns          = NOW - 1U;
    state.log_number      = 77U;
    state.lives           = 1U;
    state.epoch           = 1U;
    state.mode            = 1U;
    state.member_count    = 3U;
    state.channel_count   = 1U;
    state.message_count   = 1U;
    state.addressee_count = 1U;
    state.accepted_count  = 1U;
    state.open_count      = 1U;
    for (unsigned i = 0U; i < 3U; i++) {
        state.members[i] = (vitals_member_t){.apid = mission.subsystems[i].apid, .process = 1U, .life = 1U};
    }
    state.accepted[0] = edge;
    state.open[0]     = edge;
    state.sessions[0] = (vitals_session_t){.edge = edge, .step = 1U};
    state.plans[0]    = (vitals_plan_t){
           .is_used = 1U, .plan = 1U, .apid = 16U, .lost = 17U, .member_count = 2U, .members = {16U, 17U}};
    state.passed[0]     = (vitals_request_t){.apid = 16U, .token = {.ack = 9U, .source = 1U}};
    state.own[3]        = (vitals_request_t){.apid = 1U, .token = {.ack = 8U, .source = 1U}};
    state.messages[0]   = (vitals_message_t){1U, 7U, 1U, 12U};
    state.addressees[0] = (vitals_addressee_t){16U, 5U};
    state.channels[0]   = (vitals_channel_t){.peer_epoch = 1U,
                                             .peer       = 16U,
                                             .sent       = 40U,
                                             .credited   = 38U,
                                             .under_way  = 90U,
                                             .expected   = 7U,
                                             .taken      = 7U};
    state.channels[0].sizes[38U % MESSAGE_WINDOW] = 50U;
    state.channels[0].sizes[39U % MESSAGE_WINDOW] = 40U;
    state.rings[0]                                = (vitals_ring_t){.head = 10U, .used = 20U, .blocks = 2U};
}

void setUp(void)
{
    make_mission();
    make_state();
    limits = (vitals_limits_t){&mission, NOW, {100U, 100U, 100U}};
    (void)memset(&vitals, 0, sizeof vitals);
}

void tearDown(void)
{
}

static status_t adopt(void)
{
    return vitals_adopt(&vitals, &limits, &found, &is_older);
}

static void memory_that_was_never_written_is_nobodys(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, adopt());
}

static void the_last_commit_is_adopted(void)
{
    for (uint64_t i = 1U; i <= 5U; i++) {
        state.log_number = i;
        vitals_commit(&vitals, &state);
        TEST_ASSERT_EQUAL(STATUS_OK, adopt());
        TEST_ASSERT_FALSE(is_older);
        TEST_ASSERT_EQUAL_MEMORY(&state, &found, sizeof state);
    }
}

// Whatever octet changes where it lies, the bank is refused, and the one before it serves.
static void any_octet_that_changes_refuses_its_bank(void)
{
    for (size_t at = 0U; at < sizeof vitals.banks[0]; at++) {
        (void)memset(&vitals, 0, sizeof vitals);
        state.log_number = 1U;
        vitals_commit(&vitals, &state); // Into one bank,
        state.log_number = 2U;
        vitals_commit(&vitals, &state); // into the other.
        const size_t newer = (vitals.banks[0].generation > vitals.banks[1].generation) ? 0U : 1U;
        ((uint8_t*)&vitals.banks[newer])[at] ^= 0x5AU;
        TEST_ASSERT_EQUAL(STATUS_OK, adopt());
        TEST_ASSERT_EQUAL_UINT64(1U, found.log_number);
        TEST_ASSERT_TRUE(is_older);
        state.log_number = 3U;
        vitals_commit(&vitals, &state); // It goes on from there.
        TEST_ASSERT_EQUAL(STATUS_OK, adopt());
        TEST_ASSERT_EQUAL_UINT64(3U, found.log_number);
    }
}

static void two_damaged_banks_are_told(void)
{
    vitals_commit(&vitals, &state);
    vitals_commit(&vitals, &state);
    vitals.banks[0].state.mode ^= 1U;
    vitals.banks[1].state.mode ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, adopt());
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, adopt()); // Nothing is left to be believed.
}

// The writer ends after each octet of a commit.
static void a_commit_that_was_cut_short_leaves_the_one_before(void)
{
    static vitals_t before;
    static vitals_t after;
    state.log_number = 1U;
    vitals_commit(&vitals, &state);
    before           = vitals;
    state.log_number = 2U;
    state.mode       = 0U;
    vitals_commit(&vitals, &state);
    after              = vitals;
    const size_t newer = (after.banks[0].generation == 2U) ? 0U : 1U;
    const size_t first = offsetof(vitals_bank_t, state);
    for (size_t octets = 0U; octets <= sizeof state; octets += 7U) {
        vitals = before;
        (void)memcpy((uint8_t*)&vitals.banks[newer] + first, &after.banks[newer].state, octets);
        vitals.banks[newer].generation = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, adopt());
        TEST_ASSERT_EQUAL_UINT64(1U, found.log_number);
        TEST_ASSERT_FALSE(is_older); // What was never finished is no loss.
    }
}

/// Commits states whose words all tell the same number, until it is killed.
static void commit_for_ever(vitals_t* const shared)
{
    for (uint64_t i = 1U;; i++) {
        state.log_number      = i;
        state.orbit_offset    = i;
        state.rings[2].head   = (uint32_t)(i % 100U);
        state.rings[2].used   = 1U;
        state.rings[2].blocks = 1U;
        vitals_commit(shared, &state);
    }
}

static void a_writer_that_is_killed_anywhere_leaves_a_whole_state(void)
{
    vitals_t* const shared =
        mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(shared != MAP_FAILED);
    for (long i = 0; i < 50; i++) {
        const pid_t writer = fork();
        if (writer == 0) {
            commit_for_ever(shared);
        }
        const struct timespec wait = {0, 1000000L + (i * 7919L)};
        (void)nanosleep(&wait, NULL);
        (void)kill(writer, SIGKILL);
        int result = 0;
        TEST_ASSERT_EQUAL(writer, waitpid(writer, &result, 0));
        const status_t status = vitals_adopt(shared, &limits, &found, &is_older);
        if (status == STATUS_NOT_FOUND) {
            continue; // It had not begun.
        }
        TEST_ASSERT_EQUAL(STATUS_OK, status);
        TEST_ASSERT_FALSE(is_older);
        TEST_ASSERT_EQUAL_UINT64(found.log_number, found.orbit_offset);
        TEST_ASSERT_EQUAL_UINT32(found.log_number % 100U, found.rings[2].head);
    }
    (void)munmap(shared, sizeof *shared);
}

// ---- Fields ----

static void expect_flaw(vitals_flaw_t flaw)
{
    TEST_ASSERT_EQUAL(flaw, vitals_check(&state, &limits));
    make_state();
    TEST_ASSERT_EQUAL(VITALS_SOUND, vitals_check(&state, &limits));
}

#define REFUSED(flaw, field, value)                                                                          \
    do {                                                                                                     \
        state.field = (value);                                                                               \
        expect_flaw(flaw);                                                                                   \
    } while (0)

static void a_head_that_cannot_be_is_refused(void)
{
    TEST_ASSERT_EQUAL(VITALS_SOUND, vitals_check(&state, &limits));
    REFUSED(VITALS_MISSION, interface_hash, 1U);
    REFUSED(VITALS_TIME, now_ns, NOW + 1U);
    REFUSED(VITALS_COUNTS, lives, 0U);
    REFUSED(VITALS_COUNTS, epoch, 0U);
    REFUSED(VITALS_COUNTS, sequence, 16384U);
    REFUSED(VITALS_COUNTS, member_count, 2U);
    REFUSED(VITALS_COUNTS, channel_count, MESSAGE_PEERS_MAX + 1U);
    REFUSED(VITALS_COUNTS, message_count, PUS_MESSAGE_COUNTERS + 1U);
    REFUSED(VITALS_COUNTS, addressee_count, PUS_ADDRESSEES + 1U);
    REFUSED(VITALS_COUNTS, accepted_count, LINK_GRAPH_EDGES + 1U);
    REFUSED(VITALS_COUNTS, open_count, LINK_GRAPH_EDGES + 1U);
    REFUSED(VITALS_COUNTS, autostart_step, 2U);
    REFUSED(VITALS_MODE, mode, 2U);
    REFUSED(VITALS_LOG, log_number, 0U);
    REFUSED(VITALS_LOG, log_strategy, 4U);
    REFUSED(VITALS_LOG, is_log_failure_told, 2U);
    REFUSED(VITALS_SHUTDOWN, shutdown_step, 6U);
    REFUSED(VITALS_SHUTDOWN, shutdown_ns, NOW);
    REFUSED(VITALS_SHUTDOWN, has_shutdown_token, 2U);
    REFUSED(VITALS_SHUTDOWN, shutdown_token.ack, 16U);
}

static void a_member_that_cannot_be_is_refused(void)
{
    REFUSED(VITALS_MEMBER, members[1].apid, 16U);
    REFUSED(VITALS_MEMBER, members[0].process, 3U);
    REFUSED(VITALS_MEMBER, members[0].state, STATE_COUNT);
    REFUSED(VITALS_MEMBER, members[0].ordered, STATE_COUNT);
    REFUSED(VITALS_MEMBER, members[0].phase, PHASE_UNSECURED + 1);
    REFUSED(VITALS_MEMBER, members[0].is_heard, 2U);
    REFUSED(VITALS_MEMBER, members[0].is_order_owed, 2U);
    REFUSED(VITALS_MEMBER, members[0].is_interface_foreign, 2U);
    REFUSED(VITALS_MEMBER, members[2].heard_ns, NOW);
    REFUSED(VITALS_MEMBER, members[2].started_ns, NOW);
}

static void a_link_that_the_mission_does_not_have_is_refused(void)
{
    REFUSED(VITALS_LINK, accepted[0].link, 2U);
    REFUSED(VITALS_LINK, accepted[0].producer_apid, 17U);
    REFUSED(VITALS_LINK, open[0].consumer_port, 9U);
    REFUSED(VITALS_LINK, open[0].is_stale, 2U);
    state.open_count = 2U; // Twice the same.
    state.open[1]    = state.open[0];
    expect_flaw(VITALS_LINK);
    REFUSED(VITALS_SESSION, sessions[0].step, 6U);
    REFUSED(VITALS_SESSION, sessions[0].edge.link, 0U);
    REFUSED(VITALS_SESSION, sessions[0].token.ack, 255U);
    REFUSED(VITALS_SESSION, sessions[0].deadline_ns, UINT64_MAX);
}

static void a_plan_that_the_mission_does_not_have_is_refused(void)
{
    state.plans[0].plan        = VITALS_NO_PLAN; // Built in.
    state.plans[0].next_action = 0U;
    expect_flaw(VITALS_SOUND);
    REFUSED(VITALS_PLAN, plans[0].plan, 2U);
    REFUSED(VITALS_PLAN, plans[0].is_used, 2U);
    REFUSED(VITALS_PLAN, plans[0].next_action, 3U);
    REFUSED(VITALS_PLAN, plans[0].apid, 99U);
    REFUSED(VITALS_PLAN, plans[0].lost, 99U);
    REFUSED(VITALS_PLAN, plans[0].member_count, LINK_GRAPH_MEMBERS + 1U);
    REFUSED(VITALS_PLAN, plans[0].members[1], 99U);
    REFUSED(VITALS_PLAN, plans[0].start_ns, NOW);
}

static void what_numbers_packets_is_checked(void)
{
    REFUSED(VITALS_REQUEST, passed[0].apid, 99U);
    REFUSED(VITALS_REQUEST, passed[0].since_ns, NOW);
    REFUSED(VITALS_REQUEST, passed[0].is_answered, 2U);
    REFUSED(VITALS_REQUEST, own[3].token.ack, 16U);
    REFUSED(VITALS_MESSAGE, messages[0].service, 0U);
    REFUSED(VITALS_ADDRESSEE, addressees[0].apid, 2047U);
    REFUSED(VITALS_ADDRESSEE, addressees[0].sequence, 16384U);
    REFUSED(VITALS_CHANNEL, channels[0].peer, 99U);
    REFUSED(VITALS_CHANNEL, channels[0].sent, 38U + MESSAGE_WINDOW + 1U);
    REFUSED(VITALS_CHANNEL, channels[0].under_way, 91U);
    REFUSED(VITALS_CHANNEL, channels[0].told, 8U);
    REFUSED(VITALS_CHANNEL, channels[0].expected, 8U);
    REFUSED(VITALS_CHANNEL, channels[0].untold, MESSAGE_WINDOW_OCTETS + 1U);
    REFUSED(VITALS_RING, rings[0].head, 100U);
    REFUSED(VITALS_RING, rings[0].used, 101U);
    REFUSED(VITALS_RING, rings[0].blocks, 0U);
    REFUSED(VITALS_RING, rings[1].blocks, 1U);
}

// A ring that this flight does not have is empty.
static void a_ring_without_room_is_empty_or_refused(void)
{
    limits.ring_capacities[2] = 0U;
    TEST_ASSERT_EQUAL(VITALS_SOUND, vitals_check(&state, &limits));
    state.rings[2].head = 1U;
    TEST_ASSERT_EQUAL(VITALS_RING, vitals_check(&state, &limits));
}

// Free entries of a table may hold anything.
static void what_a_free_entry_holds_means_nothing(void)
{
    (void)memset(&state.sessions[7], 0xFF, sizeof state.sessions[7]);
    state.sessions[7].step = 0U;
    (void)memset(&state.plans[7], 0xFF, sizeof state.plans[7]);
    state.plans[7].is_used = 0U;
    (void)memset(&state.passed[9], 0xFF, sizeof state.passed[9]);
    state.passed[9].apid = 0U;
    TEST_ASSERT_EQUAL(VITALS_SOUND, vitals_check(&state, &limits));
}

// Octets that a writer in disorder has committed: judged, whatever they are.
static void any_octets_are_judged(void)
{
    uint32_t seed = 1U;
    for (unsigned round = 0U; round < 3000U; round++) {
        make_state();
        for (unsigned i = 0U; i < 3U; i++) {
            seed                                            = (seed * 1664525U) + 1013904223U;
            ((uint8_t*)&state)[(seed >> 8U) % sizeof state] = (uint8_t)(seed >> 3U);
        }
        (void)memset(&vitals, 0, sizeof vitals);
        vitals_commit(&vitals, &state);
        const bool is_sound = (vitals_check(&state, &limits) == VITALS_SOUND);
        TEST_ASSERT_EQUAL(is_sound ? STATUS_OK : STATUS_INVALID, adopt());
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(memory_that_was_never_written_is_nobodys);
    RUN_TEST(the_last_commit_is_adopted);
    RUN_TEST(any_octet_that_changes_refuses_its_bank);
    RUN_TEST(two_damaged_banks_are_told);
    RUN_TEST(a_commit_that_was_cut_short_leaves_the_one_before);
    RUN_TEST(a_writer_that_is_killed_anywhere_leaves_a_whole_state);
    RUN_TEST(a_head_that_cannot_be_is_refused);
    RUN_TEST(a_member_that_cannot_be_is_refused);
    RUN_TEST(a_link_that_the_mission_does_not_have_is_refused);
    RUN_TEST(a_plan_that_the_mission_does_not_have_is_refused);
    RUN_TEST(what_numbers_packets_is_checked);
    RUN_TEST(a_ring_without_room_is_empty_or_refused);
    RUN_TEST(what_a_free_entry_holds_means_nothing);
    RUN_TEST(any_octets_are_judged);
    return UNITY_END();
}
