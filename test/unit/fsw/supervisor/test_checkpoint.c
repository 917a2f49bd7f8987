// SPDX-License-Identifier: Apache-2.0
#define _DEFAULT_SOURCE // MAP_ANONYMOUS.
#include "fsw/supervisor/checkpoint.h"

#include "fsw/framework/subsystem/state_machine.h"
#include "fsw/supervisor/recommission.h"
#include "test/support/repetitions.h"
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
static checkpoint_t checkpoint;
static checkpoint_state_t state;
static checkpoint_state_t found;
static checkpoint_limits_t limits;
static bool is_older;
static uint8_t storage[4][100];
static message_ring_t waiting[2];
static message_ring_t taken[2];
static checkpoint_rings_t rings;
static checkpoint_rings_t taken_rings;

/// A mission of two subsystems, the supervisor and a link: everything that the checks need.
static void make_mission(void)
{
    mission = (mission_descriptor_t){.interface_hash  = 0x0102030405060708U,
                                     .subsystem_count = 3U,
                                     .mode_count      = 2U,
                                     .link_count      = 1U,
                                     .plan_count      = 1U,
                                     .action_count    = 2U};
    descriptor_mission_use_storage(&mission);
    static const uint16_t apids[] = {16U, 17U, 1U};
    for (unsigned i = 0U; i < 3U; i++) {
        mission.storage.subsystems[i].apid = apids[i];
    }
    mission.storage.modes[1].id = 1U;
    mission.storage.links[0]    = (mission_link_t){
           .number = 1U, .producer_apid = 16U, .producer_port = 1U, .consumer_apid = 17U, .consumer_port = 2U};
    mission.storage.plans[0] = (mission_plan_t){.action_count = 2U};
}

/// Put an entry into every table.
static void make_state(void)
{
    const link_edge_t edge = {1U, {16U, 1U, 17U, 2U}, false};
    (void)memset(&state, 0, sizeof state);
    state.interface_hash  = mission.interface_hash;
    state.now_ns          = NOW - 1U;
    state.log_number      = 77U;
    state.lives           = 1U;
    state.message_life    = 1U;
    state.mode            = 1U;
    state.subsystem_count = 3U;
    state.channel_count   = 1U;
    for (unsigned i = 0U; i < 3U; i++) {
        state.subsystems[i] = (checkpoint_subsystem_t){.apid = mission.subsystems[i].apid, .process = 1U};
    }
    state.accepted[0]        = edge;
    state.graph.edges[0]     = edge;
    state.graph.count        = 1U;
    state.sessions[0]        = (link_session_t){.link = 1U, .ends = edge.ends, .step = SESSION_ASK_PRODUCER};
    state.plans.runs[0]      = (plan_run_t){.plan         = 0U,
                                            .apid         = 16U,
                                            .severity     = DESCRIPTOR_HIGH,
                                            .lost         = 2U,
                                            .member_count = 2U,
                                            .members      = {16U, 17U}};
    state.pending.entries[0] = (pending_request_t){.apid = 16U, .token = {.ack = 9U, .source = 1U}};
    state.pending.count      = 1U;
    state.own.entries[3]     = (pending_request_t){.apid = 1U, .token = {.ack = 8U, .source = 1U}};
    state.own.count          = 1U;
    state.counts.messages[0] = (pus_message_count_t){1U, 7U, 1U, 12U};
    state.counts.requests[0] = (pus_request_count_t){16U, 5U};
    state.channels[0]        = (message_position_t){.peer_life = 1U,
                                                    .peer      = 16U,
                                                    .sent      = 40U,
                                                    .credited  = 38U,
                                                    .under_way = 90U,
                                                    .expected  = 7U,
                                                    .taken     = 7U};
    state.channels[0].sizes[38U % MESSAGE_WINDOW] = 50U;
    state.channels[0].sizes[39U % MESSAGE_WINDOW] = 40U;
    state.rings[0]                                = (checkpoint_ring_t){.used = 20U, .blocks = 2U};
}

void setUp(void)
{
    make_mission();
    make_state();
    limits = (checkpoint_limits_t){&mission, NOW};
    for (size_t i = 0U; i < 2U; i++) {
        message_ring_init(&waiting[i], storage[i], sizeof storage[i]);
        message_ring_init(&taken[i], storage[2U + i], sizeof storage[2U + i]);
    }
    rings       = (checkpoint_rings_t){{&waiting[0], NULL, &waiting[1]}};
    taken_rings = (checkpoint_rings_t){{&taken[0], NULL, &taken[1]}};
    (void)memset(&checkpoint, 0, sizeof checkpoint);
}

void tearDown(void)
{
}

static status_t adopt(void)
{
    return supervisor_checkpoint_adopt(&checkpoint, &limits, &found, &taken_rings, &is_older);
}

static void memory_that_was_never_written_contains_no_checkpoint(void)
{
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, adopt());
}

static void the_last_commit_is_adopted(void)
{
    for (uint64_t i = 1U; i <= 5U; i++) {
        state.log_number = i;
        supervisor_checkpoint_commit(&checkpoint, &state, &rings);
        TEST_ASSERT_EQUAL(STATUS_OK, adopt());
        TEST_ASSERT_FALSE(is_older);
        TEST_ASSERT_EQUAL_MEMORY(&state, &found, sizeof state);
    }
}

// A change of any octet makes its bank invalid, and the older bank is used.
static void a_bank_with_any_changed_octet_is_refused(void)
{
    for (size_t at = 0U; at < offsetof(checkpoint_bank_t, octets); at++) {
        checkpoint.banks[0].generation = 0U;
        checkpoint.banks[1].generation = 0U;
        state.log_number               = 1U;
        supervisor_checkpoint_commit(&checkpoint, &state, &rings); // The first commit writes one bank.
        state.log_number = 2U;
        supervisor_checkpoint_commit(&checkpoint, &state, &rings); // The second commit writes the other bank.
        const size_t newer = (checkpoint.banks[0].generation > checkpoint.banks[1].generation) ? 0U : 1U;
        ((uint8_t*)&checkpoint.banks[newer])[at] ^= 0x5AU;
        TEST_ASSERT_EQUAL(STATUS_OK, adopt());
        TEST_ASSERT_EQUAL_UINT64(1U, found.log_number);
        TEST_ASSERT_TRUE(is_older);
        state.log_number = 3U;
        // The next life continues with these numbers.
        supervisor_checkpoint_commit(&checkpoint, &state, &rings);
        TEST_ASSERT_EQUAL(STATUS_OK, adopt());
        TEST_ASSERT_EQUAL_UINT64(3U, found.log_number);
    }
}

static void two_damaged_banks_are_reported(void)
{
    supervisor_checkpoint_commit(&checkpoint, &state, &rings);
    supervisor_checkpoint_commit(&checkpoint, &state, &rings);
    checkpoint.banks[0].state.mode ^= 1U;
    checkpoint.banks[1].state.mode ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, adopt());
    TEST_ASSERT_EQUAL(STATUS_NOT_FOUND, adopt()); // No bank is valid any more.
}

// The writer is killed after every seventh octet of a commit.
static void an_incomplete_commit_leaves_the_previous_one(void)
{
    static checkpoint_t before;
    static checkpoint_t after;
    state.log_number = 1U;
    supervisor_checkpoint_commit(&checkpoint, &state, &rings);
    before           = checkpoint;
    state.log_number = 2U;
    state.mode       = 0U;
    supervisor_checkpoint_commit(&checkpoint, &state, &rings);
    after              = checkpoint;
    const size_t newer = (after.banks[0].generation == 2U) ? 0U : 1U;
    const size_t first = offsetof(checkpoint_bank_t, state);
    for (size_t octets = 0U; octets <= sizeof state; octets += 7U) {
        checkpoint = before;
        (void)memcpy((uint8_t*)&checkpoint.banks[newer] + first, &after.banks[newer].state, octets);
        checkpoint.banks[newer].generation = 0U;
        TEST_ASSERT_EQUAL(STATUS_OK, adopt());
        TEST_ASSERT_EQUAL_UINT64(1U, found.log_number);
        TEST_ASSERT_FALSE(is_older); // An unfinished commit does not count as lost.
    }
}

/// Commit states in which three fields have the same number, until the process is killed.
static void commit_until_killed(checkpoint_t* const shared)
{
    for (uint64_t i = 1U;; i++) {
        state.log_number  = i;
        state.shutdown_ns = i;
        state.link_epoch  = (uint32_t)i;
        supervisor_checkpoint_commit(shared, &state, &rings);
    }
}

static void a_writer_that_is_killed_at_any_step_leaves_a_consistent_state(void)
{
    checkpoint_t* const shared =
        mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    TEST_ASSERT_TRUE(shared != MAP_FAILED);
    for (long i = 0; i < (long)REPETITIONS(50U); i++) {
        const pid_t writer = fork();
        if (writer == 0) {
            commit_until_killed(shared);
        }
        const struct timespec wait = {0, 1000000L + (i * 7919L)};
        (void)nanosleep(&wait, NULL);
        (void)kill(writer, SIGKILL);
        int result = 0;
        TEST_ASSERT_EQUAL(writer, waitpid(writer, &result, 0));
        const status_t status = supervisor_checkpoint_adopt(shared, &limits, &found, &taken_rings, &is_older);
        if (status == STATUS_NOT_FOUND) {
            continue; // The child had not started yet.
        }
        TEST_ASSERT_EQUAL(STATUS_OK, status);
        TEST_ASSERT_FALSE(is_older);
        TEST_ASSERT_EQUAL_UINT64(found.log_number, found.shutdown_ns);
        TEST_ASSERT_EQUAL_UINT32((uint32_t)found.log_number, found.link_epoch);
    }
    (void)munmap(shared, sizeof *shared);
}

// ---- Fields ----

static void expect_flaw(checkpoint_flaw_t flaw)
{
    TEST_ASSERT_EQUAL(flaw, supervisor_checkpoint_check(&state, &limits));
    make_state();
    TEST_ASSERT_EQUAL(CHECKPOINT_SOUND, supervisor_checkpoint_check(&state, &limits));
}

/// Expect that an octet other than 0 and 1 in this boolean field is refused.
#define NOT_BOOL_REFUSED(flaw, field)                                                                        \
    do {                                                                                                     \
        *(uint8_t*)&state.field = 2U;                                                                        \
        expect_flaw(flaw);                                                                                   \
    } while (0)

#define REFUSED(flaw, field, value)                                                                          \
    do {                                                                                                     \
        state.field = (value);                                                                               \
        expect_flaw(flaw);                                                                                   \
    } while (0)

static void an_impossible_header_is_refused(void)
{
    TEST_ASSERT_EQUAL(CHECKPOINT_SOUND, supervisor_checkpoint_check(&state, &limits));
    REFUSED(CHECKPOINT_MISSION, interface_hash, 1U);
    REFUSED(CHECKPOINT_TIME, now_ns, NOW + 1U);
    REFUSED(CHECKPOINT_COUNTS, lives, 0U);
    REFUSED(CHECKPOINT_COUNTS, message_life, 0U);
    REFUSED(CHECKPOINT_COUNTS, subsystem_count, 2U);
    REFUSED(CHECKPOINT_COUNTS, channel_count, MESSAGE_PEERS_MAX + 1U);
    REFUSED(CHECKPOINT_COUNTS, graph.count, LINK_GRAPH_EDGES + 1U);
    REFUSED(CHECKPOINT_COUNTS, autostart_step, 2U);
    REFUSED(CHECKPOINT_MODE, mode, 2U);
    REFUSED(CHECKPOINT_LOG, log_number, 0U);
    REFUSED(CHECKPOINT_LOG, log_written, 77U);
    REFUSED(CHECKPOINT_LOG, log_strategy, 4U);
    NOT_BOOL_REFUSED(CHECKPOINT_LOG, is_log_failure_reported);
    REFUSED(CHECKPOINT_SHUTDOWN, shutdown_step, 6U);
    REFUSED(CHECKPOINT_SHUTDOWN, shutdown_ns, NOW);
    REFUSED(CHECKPOINT_SHUTDOWN, orbit_state.since_ns, NOW);
    NOT_BOOL_REFUSED(CHECKPOINT_SHUTDOWN, has_shutdown_token);
    REFUSED(CHECKPOINT_SHUTDOWN, shutdown_token.ack, 16U);
}

static void an_impossible_subsystem_is_refused(void)
{
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].apid, 16U);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].process, 3U);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].state, STATE_COUNT);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].ordered, STATE_COUNT);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].phase, PHASE_UNSECURED + 1);
    NOT_BOOL_REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].is_heard);
    NOT_BOOL_REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].is_order_pending);
    NOT_BOOL_REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].is_interface_mismatched);
    NOT_BOOL_REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].is_restarted);
    NOT_BOOL_REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].is_start_due);
    NOT_BOOL_REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].has_doubt);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].restart_ns, NOW + RESTART_PAUSE_MAX_NS);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].rested, STATE_COUNT);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].error_ns, NOW);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].recommission.since_ns, NOW);
    NOT_BOOL_REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].recommission.is_active);
    NOT_BOOL_REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].recommission.has_left_offline);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].recommission.target, STATE_COUNT);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].recommission.ordered, STATE_COUNT + 1);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].recommission.seen, STATE_COUNT + 1);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[1].recommission.seen_phase, PHASE_UNSECURED + 1);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[2].heard_ns, NOW);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[2].started_ns, NOW);
}

static void a_link_that_the_mission_does_not_have_is_refused(void)
{
    REFUSED(CHECKPOINT_LINK, accepted[0].link, 2U);
    REFUSED(CHECKPOINT_LINK, accepted[0].ends.producer_apid, 17U);
    REFUSED(CHECKPOINT_LINK, graph.edges[0].ends.consumer_port, 9U);
    NOT_BOOL_REFUSED(CHECKPOINT_LINK, graph.edges[0].is_stale);
    REFUSED(CHECKPOINT_LINK, renewals[MISSION_LINKS_MAX - 1U], RECOMMISSION_RENEWALS + 1U);
    REFUSED(CHECKPOINT_LINK, renewed, 2U);
    state.accepted[1] = state.accepted[0]; // The entry is at the position of another link.
    expect_flaw(CHECKPOINT_LINK);
    state.graph.count    = 2U; // The same link twice.
    state.graph.edges[1] = state.graph.edges[0];
    expect_flaw(CHECKPOINT_LINK);
    REFUSED(CHECKPOINT_SESSION, sessions[0].step, 6U);
    REFUSED(CHECKPOINT_SESSION, sessions[0].link, 0U);
    REFUSED(CHECKPOINT_SESSION, sessions[0].token.ack, 255U);
    REFUSED(CHECKPOINT_SESSION, sessions[0].deadline_ns, UINT64_MAX);
}

static void a_plan_that_the_mission_does_not_have_is_refused(void)
{
    state.plans.runs[0].plan        = PLAN_BUILT_IN;
    state.plans.runs[0].next_action = 1U;
    expect_flaw(CHECKPOINT_SOUND);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].plan, 1U);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].next_action, 3U);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].apid, 99U);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].lost, 4U); // The network has two members only.
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].severity, 0U);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].severity, 5U);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].member_count, LINK_GRAPH_MEMBERS + 1U);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].members[1], 99U);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].start_ns, NOW);
}

/// The largest valid values of fields that have a limit.
static void values_at_their_limits_are_accepted(void)
{
    checkpoint_subsystem_t* const subsystem = &state.subsystems[0];
    recommission_t* const run               = &subsystem->recommission;
    state.now_ns                            = NOW;
    state.shutdown_ns                       = NOW;
    state.orbit_state.since_ns              = NOW;
    state.shutdown_step                     = 5U;
    state.shutdown_token.ack                = 15U;
    state.autostart_step                    = 1U;
    state.log_strategy                      = 3U;
    state.log_written                       = state.log_number - 1U;
    state.renewals[0]                       = RECOMMISSION_RENEWALS;
    state.renewed                           = 1U;
    subsystem->heard_ns                     = NOW;
    subsystem->started_ns                   = NOW;
    subsystem->error_ns                     = NOW;
    subsystem->process                      = 2U;
    subsystem->state                        = (uint8_t)STATE_COUNT - 1U;
    subsystem->ordered                      = (uint8_t)STATE_COUNT - 1U;
    subsystem->rested                       = (uint8_t)STATE_COUNT - 1U;
    subsystem->phase                        = (uint8_t)PHASE_UNSECURED;
    subsystem->order_cause                  = (uint8_t)CAUSE_SUPERVISOR_LOST;
    subsystem->is_heard                     = true;
    *run =
        (recommission_t){true, true, STATE_OPERATIONAL, 9U, STATE_COUNT, STATE_COUNT, PHASE_UNSECURED, NOW};
    state.sessions[0].step            = SESSION_CLOSING;
    state.sessions[0].deadline_ns     = NOW + 10000000000U;
    state.graph.edges[0].is_stale     = true;
    state.plans.runs[0].start_ns      = NOW;
    state.plans.runs[0].severity      = DESCRIPTOR_INFORMATIVE;
    state.plans.runs[0].lost          = 3U;
    state.plans.runs[0].next_action   = 2U;
    state.pending.entries[0].since_ns = NOW;
    state.pending.entries[0].stage    = PENDING_STARTED;
    TEST_ASSERT_EQUAL(CHECKPOINT_SOUND, supervisor_checkpoint_check(&state, &limits));
    state.sessions[0].deadline_ns++;
    expect_flaw(CHECKPOINT_SESSION);
    REFUSED(CHECKPOINT_SUBSYSTEM, subsystems[0].order_cause, (uint8_t)CAUSE_SUPERVISOR_LOST + 1U);
    REFUSED(CHECKPOINT_PLAN, plans.runs[0].members[0], 99U);
    state.plans.runs[0].plan        = PLAN_BUILT_IN;
    state.plans.runs[0].next_action = 2U;
    expect_flaw(CHECKPOINT_PLAN);
}

static void invalid_requests_counts_channels_and_rings_are_refused(void)
{
    REFUSED(CHECKPOINT_REQUEST, pending.entries[0].apid, 99U);
    REFUSED(CHECKPOINT_REQUEST, pending.entries[0].since_ns, NOW);
    REFUSED(CHECKPOINT_REQUEST, pending.entries[0].stage, 4U);
    REFUSED(CHECKPOINT_REQUEST, own.entries[3].token.ack, 16U);
    REFUSED(CHECKPOINT_REQUEST, pending.count, 2U);
    REFUSED(CHECKPOINT_REQUEST, own.count, 0U);
    REFUSED(CHECKPOINT_NUMBERS, counts.sequence, 16384U);
    REFUSED(CHECKPOINT_NUMBERS, counts.requests[0].apid, 2047U);
    REFUSED(CHECKPOINT_NUMBERS, counts.requests[0].sequence, 16384U);
    REFUSED(CHECKPOINT_CHANNEL, channels[0].peer, 99U);
    REFUSED(CHECKPOINT_CHANNEL, channels[0].sent, 38U + MESSAGE_WINDOW + 1U);
    REFUSED(CHECKPOINT_CHANNEL, channels[0].under_way, 91U);
    REFUSED(CHECKPOINT_CHANNEL, channels[0].acknowledged, 8U);
    REFUSED(CHECKPOINT_CHANNEL, channels[0].expected, 8U + MESSAGE_WINDOW);
    REFUSED(CHECKPOINT_CHANNEL, channels[0].unacknowledged, MESSAGE_WINDOW_OCTETS + 1U);
    REFUSED(CHECKPOINT_RING, rings[0].used, CHECKPOINT_OCTETS + 1U);
    REFUSED(CHECKPOINT_RING, rings[0].blocks, 0U);
    REFUSED(CHECKPOINT_RING, rings[1].blocks, 1U);
}

static void put(message_ring_t* ring, const char* text)
{
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_put(ring, (const uint8_t*)text, strlen(text)));
}

static void expect_block(message_ring_t* ring, const char* text)
{
    uint8_t octets[64];
    size_t size = 0U;
    TEST_ASSERT_EQUAL(STATUS_OK, message_ring_take(ring, octets, sizeof octets, &size));
    TEST_ASSERT_EQUAL(strlen(text), size);
    TEST_ASSERT_EQUAL_MEMORY(text, octets, size);
}

static void a_checkpoint_keeps_the_blocks_of_rings_in_order(void)
{
    uint8_t block[64];
    size_t size = 0U;
    put(&waiting[0], "a block that is taken before, so that the next ones wrap around ......");
    TEST_ASSERT_EQUAL(STATUS_TOO_LARGE, message_ring_take(&waiting[0], block, sizeof block, &size));
    put(&waiting[0], "one");
    put(&waiting[0], "a second one that wraps around the end");
    put(&waiting[1], "three");
    supervisor_checkpoint_commit(&checkpoint, &state, &rings);
    TEST_ASSERT_EQUAL(2U, waiting[0].blocks); // Reading them for the checkpoint does not remove the blocks.
    TEST_ASSERT_EQUAL(STATUS_OK, adopt());
    expect_block(&taken[0], "one");
    expect_block(&taken[0], "a second one that wraps around the end");
    expect_block(&taken[1], "three");
    TEST_ASSERT_EQUAL(0U, taken[0].blocks + taken[1].blocks);
}

static void a_bank_with_a_changed_octet_of_a_ring_is_refused(void)
{
    put(&waiting[0], "one");
    supervisor_checkpoint_commit(&checkpoint, &state, &rings);
    checkpoint.banks[0].octets[5] ^= 1U;
    TEST_ASSERT_EQUAL(STATUS_INVALID, adopt());
    TEST_ASSERT_EQUAL(0U, taken[0].blocks);
}

// Free entries of a table may have any content.
static void the_content_of_free_entries_is_not_checked(void)
{
    (void)memset(&state.sessions[7], 0xFF, sizeof state.sessions[7]);
    state.sessions[7].step = SESSION_FREE;
    (void)memset(&state.accepted[7], 0xFF, sizeof state.accepted[7]);
    state.accepted[7].link = 0U;
    (void)memset(&state.plans.runs[7], 0xFF, sizeof state.plans.runs[7]);
    state.plans.runs[7].member_count = 0U;
    (void)memset(&state.pending.entries[9], 0xFF, sizeof state.pending.entries[9]);
    state.pending.entries[9].apid = 0U;
    TEST_ASSERT_EQUAL(CHECKPOINT_SOUND, supervisor_checkpoint_check(&state, &limits));
}

// Octets that a faulty writer has committed are checked, whatever they contain.
static void random_octets_are_accepted_or_refused_without_a_crash(void)
{
    uint32_t seed = 1U;
    for (unsigned round = 0U; round < REPETITIONS(3000U); round++) {
        make_state();
        for (unsigned i = 0U; i < 3U; i++) {
            seed                                            = (seed * 1664525U) + 1013904223U;
            ((uint8_t*)&state)[(seed >> 8U) % sizeof state] = (uint8_t)(seed >> 3U);
        }
        checkpoint.banks[0].generation = 0U;
        checkpoint.banks[1].generation = 0U;
        supervisor_checkpoint_commit(&checkpoint, &state, &rings);
        const bool is_sound = (supervisor_checkpoint_check(&state, &limits) == CHECKPOINT_SOUND);
        TEST_ASSERT_EQUAL(is_sound ? STATUS_OK : STATUS_INVALID, adopt());
    }
}

// ---- Annexes ----

#define ANNEX (&checkpoint.arrivals)

static void commit(void)
{
    supervisor_checkpoint_commit(&checkpoint, &state, &rings);
}

static void add(const char* head, const char* rest)
{
    TEST_ASSERT_TRUE(supervisor_checkpoint_add(&checkpoint, ANNEX, (const uint8_t*)head, strlen(head),
                                               (const uint8_t*)rest, strlen(rest)));
}

/// Returns the blocks in order or in reverse order, each followed by a comma.
static const char* blocks(bool is_backwards)
{
    static char content[200];
    size_t length        = 0U;
    size_t position      = 0U;
    size_t size          = 0U;
    const uint8_t* block = NULL;
    do {
        block = is_backwards ? supervisor_checkpoint_before(&checkpoint, ANNEX, &position, &size)
                             : supervisor_checkpoint_next(&checkpoint, ANNEX, &position, &size);
        if (block != NULL) {
            (void)memcpy(&content[length], block, size);
            length += size;
            content[length] = ',';
            length++;
        }
    } while (block != NULL);
    content[length] = '\0';
    return content;
}

static void an_annex_belongs_to_the_last_commit(void)
{
    commit();
    TEST_ASSERT_EQUAL_STRING("", blocks(false));
    add("ab", "c");
    add("", "");
    add("d", "");
    TEST_ASSERT_EQUAL_STRING("abc,,d,", blocks(false));
    TEST_ASSERT_EQUAL_STRING("d,,abc,", blocks(true));
    commit();
    TEST_ASSERT_EQUAL_STRING("", blocks(false));
    TEST_ASSERT_EQUAL_STRING("", blocks(true));
    add("e", "");
    TEST_ASSERT_EQUAL_STRING("e,", blocks(false));
}

static void a_full_annex_accepts_no_more_blocks(void)
{
    static uint8_t octets[65536];
    commit();
    unsigned count = 0U;
    while (supervisor_checkpoint_add(&checkpoint, ANNEX, octets, sizeof octets, NULL, 0U)) {
        count++;
    }
    TEST_ASSERT_EQUAL(CHECKPOINT_ANNEX_OCTETS / (sizeof octets + 8U), count);
    const size_t left = CHECKPOINT_ANNEX_OCTETS - (count * (sizeof octets + 8U));
    TEST_ASSERT_FALSE(supervisor_checkpoint_add(&checkpoint, ANNEX, octets, left - 7U, NULL, 0U));
    TEST_ASSERT_TRUE(supervisor_checkpoint_add(&checkpoint, ANNEX, octets, left - 8U, NULL, 0U));
    TEST_ASSERT_FALSE(supervisor_checkpoint_add(&checkpoint, ANNEX, octets, 0U, NULL, 0U));
}

static void a_damaged_annex_is_read_up_to_its_damage(void)
{
    commit();
    add("abc", "");
    add("def", "");
    checkpoint.arrivals.octets[11] ^= 0xFFU; // The size before the last block.
    checkpoint.arrivals.octets[7] ^= 0xFFU;  // The size after the first block.
    TEST_ASSERT_EQUAL_STRING("abc,", blocks(false));
    TEST_ASSERT_EQUAL_STRING("def,", blocks(true));
    // Room for an empty block, but the sizes exceed it; less than a block; more than the annex.
    static const uint64_t counts[] = {8U, 7U, CHECKPOINT_ANNEX_OCTETS + 1U};
    for (size_t i = 0U; i < (sizeof counts / sizeof counts[0]); i++) {
        checkpoint.arrivals.used.count = counts[i];
        TEST_ASSERT_EQUAL_STRING("", blocks(false));
        TEST_ASSERT_EQUAL_STRING("", blocks(true));
    }
}

static void performed_requests_are_noted_until_the_next_commit(void)
{
    commit();
    TEST_ASSERT_EQUAL(0U, supervisor_checkpoint_performed(&checkpoint));
    supervisor_checkpoint_note_performed(&checkpoint, 1U);
    supervisor_checkpoint_note_performed(&checkpoint, 2U);
    TEST_ASSERT_EQUAL(2U, supervisor_checkpoint_performed(&checkpoint));
    commit();
    TEST_ASSERT_EQUAL(0U, supervisor_checkpoint_performed(&checkpoint));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(memory_that_was_never_written_contains_no_checkpoint);
    RUN_TEST(the_last_commit_is_adopted);
    RUN_TEST(a_bank_with_any_changed_octet_is_refused);
    RUN_TEST(two_damaged_banks_are_reported);
    RUN_TEST(an_incomplete_commit_leaves_the_previous_one);
    RUN_TEST(a_writer_that_is_killed_at_any_step_leaves_a_consistent_state);
    RUN_TEST(an_impossible_header_is_refused);
    RUN_TEST(an_impossible_subsystem_is_refused);
    RUN_TEST(a_link_that_the_mission_does_not_have_is_refused);
    RUN_TEST(a_plan_that_the_mission_does_not_have_is_refused);
    RUN_TEST(values_at_their_limits_are_accepted);
    RUN_TEST(invalid_requests_counts_channels_and_rings_are_refused);
    RUN_TEST(a_checkpoint_keeps_the_blocks_of_rings_in_order);
    RUN_TEST(a_bank_with_a_changed_octet_of_a_ring_is_refused);
    RUN_TEST(the_content_of_free_entries_is_not_checked);
    RUN_TEST(random_octets_are_accepted_or_refused_without_a_crash);
    RUN_TEST(an_annex_belongs_to_the_last_commit);
    RUN_TEST(a_full_annex_accepts_no_more_blocks);
    RUN_TEST(a_damaged_annex_is_read_up_to_its_damage);
    RUN_TEST(performed_requests_are_noted_until_the_next_commit);
    return UNITY_END();
}
