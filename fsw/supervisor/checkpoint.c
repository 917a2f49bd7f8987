// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/checkpoint.h"

#include "base/assertion.h"
#include "base/capacities.h"
#include "base/crc.h"
#include "fsw/framework/subsystem/state_machine.h"
#include "fsw/supervisor/recommission.h"
#include "pus/core/packet.h"

#include <string.h>

#define BANKS 2U
#define PROCESS_STATES 3U
#define SHUTDOWN_STEPS 6U              // Number of steps in sequences.c.
#define SESSION_TIME_NS 10000000000ULL ///< A session with a later deadline than this is not possible.
#define ANNEX_FRAME (2U * sizeof(uint32_t))
#define WORD sizeof(uint64_t)
#define LANES 4U
#define PRIME 0x100000001B3ULL // Prime of FNV-1a, here over words.

CAPACITY_CHECK(both_states_have_room, (2U * sizeof(checkpoint_state_t)) <= CHECKPOINT_STATES_MAX);
CAPACITY_CHECK(a_boolean_is_an_octet, sizeof(bool) == 1U);
CAPACITY_CHECK(the_state_is_whole_words, (sizeof(checkpoint_state_t) % sizeof(uint64_t)) == 0U);

// ---- Banks ----

static uint64_t sum_word(const uint64_t sum, const uint8_t* const octets, const size_t size)
{
    uint64_t word = 0U;
    (void)memcpy((uint8_t*)&word, octets, size);
    return (sum ^ word) * PRIME;
}

/// Compute four sums, each over every fourth word, because the processor can perform their multiplications
/// in parallel. `start` is part of one of them only: in this way a change of `start`, or of one word, changes
/// one of the four, and therefore always the result.
static uint64_t sum_words(const uint64_t start, const uint8_t* const octets, const size_t size)
{
    uint64_t sums[LANES] = {start, FNV64_START, FNV64_START, FNV64_START};
    size_t at            = 0U;
    for (; (size - at) >= (LANES * WORD); at += LANES * WORD) {
        sums[0] = sum_word(sums[0], &octets[at], WORD);
        sums[1] = sum_word(sums[1], &octets[at + WORD], WORD);
        sums[2] = sum_word(sums[2], &octets[at + (2U * WORD)], WORD);
        sums[3] = sum_word(sums[3], &octets[at + (3U * WORD)], WORD);
    }
    uint64_t sum = sum_word(sums[0], (const uint8_t*)&sums[1], WORD);
    sum          = sum_word(sum, (const uint8_t*)&sums[2], WORD);
    sum          = sum_word(sum, (const uint8_t*)&sums[3], WORD);
    for (; at < size; at += WORD) {
        const size_t left = size - at;
        sum               = sum_word(sum, &octets[at], (left < WORD) ? left : WORD);
    }
    return sum;
}

static size_t waiting_octets(const checkpoint_state_t* const state)
{
    size_t sum = 0U;
    for (size_t i = 0U; i < CHECKPOINT_RINGS; i++) {
        sum += state->rings[i].used;
    }
    return sum;
}

/// Returns the sum of a bank; a change of any word, also of the generation, changes the sum. The rings must
/// have at most CHECKPOINT_OCTETS.
static uint64_t sum_of(const checkpoint_bank_t* const bank, const uint64_t generation)
{
    const uint64_t sum =
        sum_words((FNV64_START ^ generation) * PRIME, (const uint8_t*)&bank->state, sizeof bank->state);
    return sum_words(sum, bank->octets, waiting_octets(&bank->state));
}

static uint64_t generation_of(const checkpoint_bank_t* const bank)
{
    return __atomic_load_n(&bank->generation, __ATOMIC_ACQUIRE);
}

void supervisor_checkpoint_commit(checkpoint_t* const checkpoint, checkpoint_state_t* const state,
                                  const checkpoint_rings_t* const rings)
{
    FSW_ASSERT((checkpoint != NULL) && (state != NULL) && (rings != NULL));
    const uint64_t first          = generation_of(&checkpoint->banks[0]);
    const uint64_t second         = generation_of(&checkpoint->banks[1]);
    checkpoint_bank_t* const bank = &checkpoint->banks[(first <= second) ? 0U : 1U];
    const uint64_t generation     = ((first <= second) ? second : first) + 1U;
    size_t position               = 0U;
    // The bank is invalid until its generation is stored.
    __atomic_store_n(&bank->generation, 0U, __ATOMIC_SEQ_CST);
    __atomic_thread_fence(__ATOMIC_SEQ_CST);
    for (size_t i = 0U; i < CHECKPOINT_RINGS; i++) {
        const message_ring_t* const ring = rings->list[i];
        const size_t used =
            (ring != NULL) ? message_ring_copy(ring, &bank->octets[position], CHECKPOINT_OCTETS - position)
                           : 0U;
        state->rings[i] =
            (checkpoint_ring_t){.used = (uint32_t)used, .blocks = (used > 0U) ? ring->blocks : 0U};
        position += used;
    }
    bank->state = *state;
    bank->sum   = sum_of(bank, generation);
    __atomic_store_n(&bank->generation, generation, __ATOMIC_RELEASE);
}

static bool is_bank_sound(const checkpoint_bank_t* const bank, const checkpoint_limits_t* const limits)
{
    const uint64_t generation = generation_of(bank);
    size_t octets             = 0U;
    for (size_t i = 0U; i < CHECKPOINT_RINGS; i++) { // Check the sizes of the rings before the sum uses them.
        if (bank->state.rings[i].used > (CHECKPOINT_OCTETS - octets)) {
            return false;
        }
        octets += bank->state.rings[i].used;
    }
    return (generation != 0U) && (bank->sum == sum_of(bank, generation)) &&
           (supervisor_checkpoint_check(&bank->state, limits) == CHECKPOINT_SOUND);
}

static const checkpoint_bank_t* newest(const checkpoint_t* const checkpoint)
{
    return &checkpoint
                ->banks[(generation_of(&checkpoint->banks[0]) > generation_of(&checkpoint->banks[1])) ? 0U
                                                                                                      : 1U];
}

const uint8_t* supervisor_checkpoint_waiting(const checkpoint_t* const checkpoint, const size_t ring,
                                             size_t* const out_octets)
{
    FSW_ASSERT((checkpoint != NULL) && (ring < CHECKPOINT_RINGS) && (out_octets != NULL));
    const checkpoint_bank_t* const bank = newest(checkpoint);
    size_t position                     = 0U;
    for (size_t i = 0U; i < ring; i++) {
        position += bank->state.rings[i].used;
    }
    *out_octets = bank->state.rings[ring].used;
    return &bank->octets[position];
}

static void fill_rings(const checkpoint_bank_t* const bank, const checkpoint_rings_t* const rings)
{
    size_t position = 0U;
    for (size_t i = 0U; i < CHECKPOINT_RINGS; i++) {
        const size_t used = bank->state.rings[i].used;
        if (rings->list[i] != NULL) {
            message_ring_refill(rings->list[i], &bank->octets[position], used);
        }
        position += used;
    }
}

status_t supervisor_checkpoint_adopt(checkpoint_t* const checkpoint, const checkpoint_limits_t* const limits,
                                     checkpoint_state_t* const out_state,
                                     const checkpoint_rings_t* const rings, bool* const out_older)
{
    FSW_ASSERT((checkpoint != NULL) && (limits != NULL) && (out_state != NULL) && (rings != NULL) &&
               (out_older != NULL));
    const uint64_t first  = generation_of(&checkpoint->banks[0]);
    const uint64_t second = generation_of(&checkpoint->banks[1]);
    const size_t newer    = (first > second) ? 0U : 1U;
    *out_older            = false;
    if ((first == 0U) && (second == 0U)) {
        return STATUS_NOT_FOUND;
    }
    for (size_t i = 0U; i < BANKS; i++) {
        checkpoint_bank_t* const bank = &checkpoint->banks[(newer + i) % BANKS];
        if (is_bank_sound(bank, limits)) {
            *out_state = bank->state;
            fill_rings(bank, rings);
            return STATUS_OK;
        }
        // A bank without a generation is not newer: it was being written when the writer died.
        *out_older = *out_older || (generation_of(bank) != 0U);
        __atomic_store_n(&bank->generation, 0U, __ATOMIC_RELEASE);
    }
    return STATUS_INVALID;
}

// ---- Annexes ----

static uint64_t count_of(const checkpoint_t* const checkpoint, const checkpoint_mark_t* const mark)
{
    return (__atomic_load_n(&mark->generation, __ATOMIC_ACQUIRE) == generation_of(newest(checkpoint)))
               ? __atomic_load_n(&mark->count, __ATOMIC_ACQUIRE)
               : 0U;
}

static void set_count(const checkpoint_t* const checkpoint, checkpoint_mark_t* const mark,
                      const uint64_t count)
{
    const uint64_t generation = generation_of(newest(checkpoint));
    if (mark->generation != generation) {
        // Until its generation is stored, the annex still belongs to an earlier commit and is empty.
        __atomic_store_n(&mark->count, 0U, __ATOMIC_SEQ_CST);
        __atomic_store_n(&mark->generation, generation, __ATOMIC_SEQ_CST);
    }
    __atomic_store_n(&mark->count, count, __ATOMIC_RELEASE);
}

/// Returns the used octets of an annex; 0 if that number exceeds its size. The sizes in an annex are not
/// trusted: no content lets a block exceed the annex.
static size_t used_of(const checkpoint_t* const checkpoint, const checkpoint_annex_t* const annex)
{
    const uint64_t used = count_of(checkpoint, &annex->used);
    return (used <= sizeof annex->octets) ? (size_t)used : 0U;
}

static uint32_t size_at(const checkpoint_annex_t* const annex, const size_t position)
{
    uint32_t size = 0U;
    (void)memcpy((uint8_t*)&size, &annex->octets[position], sizeof size);
    return size;
}

bool supervisor_checkpoint_add(const checkpoint_t* const checkpoint, checkpoint_annex_t* const annex,
                               const uint8_t* const head, const size_t head_size, const uint8_t* const octets,
                               const size_t size)
{
    FSW_ASSERT((checkpoint != NULL) && (annex != NULL) && (head != NULL) &&
               ((octets != NULL) || (size == 0U)));
    const uint32_t length = (uint32_t)(head_size + size);
    const size_t position = used_of(checkpoint, annex);
    if ((length + ANNEX_FRAME) > (sizeof annex->octets - position)) {
        return false;
    }
    uint8_t* const block = &annex->octets[position];
    (void)memcpy(block, (const uint8_t*)&length, sizeof length);
    (void)memcpy(&block[sizeof length], head, head_size);
    if (size > 0U) {
        (void)memcpy(&block[sizeof length + head_size], octets, size);
    }
    (void)memcpy(&block[sizeof length + length], (const uint8_t*)&length, sizeof length);
    // From this store on the block is valid.
    set_count(checkpoint, &annex->used, position + length + ANNEX_FRAME);
    return true;
}

const uint8_t* supervisor_checkpoint_next(const checkpoint_t* const checkpoint,
                                          const checkpoint_annex_t* const annex, size_t* const position,
                                          size_t* const out_size)
{
    FSW_ASSERT((checkpoint != NULL) && (annex != NULL) && (position != NULL) && (out_size != NULL));
    const size_t left = used_of(checkpoint, annex) - *position;
    *out_size         = (left >= ANNEX_FRAME) ? size_at(annex, *position) : 0U;
    if ((left < ANNEX_FRAME) || (*out_size > (left - ANNEX_FRAME))) {
        return NULL;
    }
    const uint8_t* const block = &annex->octets[*position + sizeof(uint32_t)];
    *position += *out_size + ANNEX_FRAME;
    return block;
}

const uint8_t* supervisor_checkpoint_before(const checkpoint_t* const checkpoint,
                                            const checkpoint_annex_t* const annex, size_t* const position,
                                            size_t* const out_size)
{
    FSW_ASSERT((checkpoint != NULL) && (annex != NULL) && (position != NULL) && (out_size != NULL));
    const size_t left = used_of(checkpoint, annex) - *position;
    *out_size         = (left >= ANNEX_FRAME) ? size_at(annex, left - sizeof(uint32_t)) : 0U;
    if ((left < ANNEX_FRAME) || (*out_size > (left - ANNEX_FRAME))) {
        return NULL;
    }
    *position += *out_size + ANNEX_FRAME;
    return &annex->octets[left - *out_size - sizeof(uint32_t)];
}

void supervisor_checkpoint_note_performed(checkpoint_t* const checkpoint, const uint32_t count)
{
    FSW_ASSERT(checkpoint != NULL);
    set_count(checkpoint, &checkpoint->performed, count);
}

uint32_t supervisor_checkpoint_performed(const checkpoint_t* const checkpoint)
{
    FSW_ASSERT(checkpoint != NULL);
    return (uint32_t)count_of(checkpoint, &checkpoint->performed);
}

// ---- Checks ----

/// True if an octet is a valid boolean. Another process has written it, so it must not be read as a boolean
/// before this check.
static bool is_boolean(const void* const value)
{
    return *(const uint8_t*)value <= 1U;
}

static bool is_subsystem(const checkpoint_limits_t* const limits, const uint16_t apid)
{
    return descriptor_mission_find_subsystem(limits->mission, apid) != NULL;
}

static bool are_counts_sound(const checkpoint_state_t* const state, const checkpoint_limits_t* const limits)
{
    FSW_ASSERT(limits->mission->subsystem_count <= MISSION_SUBSYSTEMS_MAX);
    return (state->lives >= 1U) && (state->message_life >= 1U) &&
           (state->subsystem_count == limits->mission->subsystem_count) &&
           (state->channel_count <= MESSAGE_PEERS_MAX) && (state->graph.count <= LINK_GRAPH_EDGES) &&
           (state->autostart_step <= 1U);
}

static bool is_token_sound(const pus_token_t* const token)
{
    return (token->ack & (uint8_t)~PUS_ACK_ALL) == 0U;
}

static bool is_shutdown_sound(const checkpoint_state_t* const state)
{
    return (state->shutdown_step < SHUTDOWN_STEPS) && (state->shutdown_ns <= state->now_ns) &&
           (state->orbit_state.since_ns <= state->now_ns) && is_boolean(&state->has_shutdown_token) &&
           is_token_sound(&state->shutdown_token);
}

/// Check the fields of a recommissioning that is running, or that would start if the subsystem died now.
static bool is_run_sound(const checkpoint_subsystem_t* const subsystem, const uint64_t now_ns)
{
    const recommission_t* const run = &subsystem->recommission;
    return (subsystem->rested < (uint8_t)STATE_COUNT) && (subsystem->error_ns <= now_ns) &&
           (run->since_ns <= now_ns) && is_boolean(&run->is_active) && is_boolean(&run->has_left_offline) &&
           (run->target < STATE_COUNT) && (run->ordered <= STATE_COUNT) && (run->seen <= STATE_COUNT) &&
           (run->seen_phase <= PHASE_UNSECURED);
}

/// Check what is known of the process of a subsystem.
static bool is_process_sound(const checkpoint_subsystem_t* const subsystem, const uint64_t now_ns)
{
    return (subsystem->process < PROCESS_STATES) && is_boolean(&subsystem->is_heard) &&
           is_boolean(&subsystem->is_restarted) && is_boolean(&subsystem->is_start_due) &&
           (subsystem->restart_ns <= (now_ns + RESTART_PAUSE_MAX_NS)) && (subsystem->heard_ns <= now_ns) &&
           (subsystem->started_ns <= now_ns);
}

static bool are_subsystems_sound(const checkpoint_state_t* const state,
                                 const checkpoint_limits_t* const limits)
{
    for (uint16_t i = 0U; i < state->subsystem_count; i++) {
        const checkpoint_subsystem_t* const subsystem = &state->subsystems[i];
        const bool is_sound =
            (subsystem->apid == limits->mission->subsystems[i].apid) &&
            is_process_sound(subsystem, state->now_ns) && (subsystem->state < (uint8_t)STATE_COUNT) &&
            (subsystem->ordered < (uint8_t)STATE_COUNT) &&
            (subsystem->order_cause <= (uint8_t)CAUSE_SUPERVISOR_LOST) &&
            (subsystem->phase <= (uint8_t)PHASE_UNSECURED) && is_boolean(&subsystem->is_order_pending) &&
            is_boolean(&subsystem->has_doubt) && is_boolean(&subsystem->is_interface_mismatched) &&
            is_run_sound(subsystem, state->now_ns);
        if (!is_sound) {
            return false;
        }
    }
    return true;
}

/// True if the mission has a link with this number and these ends.
static bool is_link_sound(const uint16_t number, const pus_link_ends_t* const ends,
                          const checkpoint_limits_t* const limits)
{
    const mission_link_t* const link = descriptor_mission_find_link(
        limits->mission, ends->producer_apid, ends->producer_port, ends->consumer_apid, ends->consumer_port);
    return (link != NULL) && (link->number == number);
}

static bool are_accepted_sound(const checkpoint_state_t* const state, const checkpoint_limits_t* const limits)
{
    for (uint16_t i = 0U; i < MISSION_LINKS_MAX; i++) {
        const link_edge_t* const edge = &state->accepted[i];
        if ((edge->link != 0U) &&
            ((edge->link != (i + 1U)) || !is_link_sound(edge->link, &edge->ends, limits))) {
            return false;
        }
    }
    return true;
}

static bool is_graph_sound(const link_graph_t* const graph, const checkpoint_limits_t* const limits)
{
    for (uint16_t i = 0U; i < graph->count; i++) {
        const link_edge_t* const edge = &graph->edges[i];
        if (!is_link_sound(edge->link, &edge->ends, limits) || !is_boolean(&edge->is_stale)) {
            return false;
        }
        for (uint16_t k = 0U; k < i; k++) {
            if (graph->edges[k].link == edge->link) {
                return false;
            }
        }
    }
    return true;
}

static bool are_renewals_sound(const checkpoint_state_t* const state, const checkpoint_limits_t* const limits)
{
    for (size_t i = 0U; i < MISSION_LINKS_MAX; i++) {
        if (state->renewals[i] > RECOMMISSION_RENEWALS) {
            return false;
        }
    }
    return ((uint64_t)state->renewed >> limits->mission->link_count) == 0U;
}

static bool are_sessions_sound(const checkpoint_state_t* const state, const checkpoint_limits_t* const limits)
{
    for (size_t i = 0U; i < SUPERVISOR_LINK_SESSIONS; i++) {
        const link_session_t* const session = &state->sessions[i];
        const bool is_sound = (session->step <= SESSION_CLOSING) && is_token_sound(&session->token) &&
                              is_link_sound(session->link, &session->ends, limits) &&
                              (session->deadline_ns <= (state->now_ns + SESSION_TIME_NS));
        if ((session->step != SESSION_FREE) && !is_sound) {
            return false;
        }
    }
    return true;
}

static bool is_plan_sound(const plan_run_t* const run, const uint64_t now_ns,
                          const checkpoint_limits_t* const limits)
{
    const mission_descriptor_t* const mission = limits->mission;
    const bool is_built_in                    = (run->plan == PLAN_BUILT_IN);
    if ((!is_built_in && (run->plan >= mission->plan_count)) || (run->member_count > LINK_GRAPH_MEMBERS) ||
        (run->start_ns > now_ns) || !is_subsystem(limits, run->apid) ||
        (run->severity < DESCRIPTOR_INFORMATIVE) || (run->severity > DESCRIPTOR_HIGH) ||
        (run->lost >= (1UL << run->member_count))) {
        return false;
    }
    for (uint16_t i = 0U; i < run->member_count; i++) {
        if (!is_subsystem(limits, run->members[i])) {
            return false;
        }
    }
    return run->next_action <= (is_built_in ? 1U : mission->plans[run->plan].action_count);
}

static bool are_plans_sound(const checkpoint_state_t* const state, const checkpoint_limits_t* const limits)
{
    for (size_t i = 0U; i < PLAN_RUNS; i++) {
        const plan_run_t* const run = &state->plans.runs[i];
        if ((run->member_count != 0U) && !is_plan_sound(run, state->now_ns, limits)) {
            return false;
        }
    }
    return true;
}

static bool are_requests_sound(const pending_table_t* const table, const uint64_t now_ns,
                               const checkpoint_limits_t* const limits)
{
    uint16_t count = 0U;
    for (size_t i = 0U; i < PENDING_MAX; i++) {
        const pending_request_t* const request = &table->entries[i];
        const bool is_sound = is_subsystem(limits, request->apid) && (request->stage <= PENDING_STARTED) &&
                              (request->since_ns <= now_ns) && is_token_sound(&request->token);
        if ((request->apid != 0U) && !is_sound) {
            return false;
        }
        count = (uint16_t)(count + ((request->apid != 0U) ? 1U : 0U));
    }
    return table->count == count;
}

static bool are_channels_sound(const checkpoint_state_t* const state, const checkpoint_limits_t* const limits)
{
    for (uint16_t i = 0U; i < state->channel_count; i++) {
        const message_position_t* const channel = &state->channels[i];
        if (!is_subsystem(limits, channel->peer) || !message_position_is_sound(channel)) {
            return false;
        }
    }
    return true;
}

static bool are_rings_sound(const checkpoint_state_t* const state)
{
    for (size_t i = 0U; i < CHECKPOINT_RINGS; i++) {
        if ((state->rings[i].used == 0U) != (state->rings[i].blocks == 0U)) {
            return false;
        }
    }
    return waiting_octets(state) <= CHECKPOINT_OCTETS;
}

checkpoint_flaw_t supervisor_checkpoint_check(const checkpoint_state_t* const state,
                                              const checkpoint_limits_t* const limits)
{
    FSW_ASSERT((state != NULL) && (limits != NULL) && (limits->mission != NULL));
    if (state->interface_hash != limits->mission->interface_hash) {
        return CHECKPOINT_MISSION;
    }
    if (state->now_ns > limits->now_ns) {
        return CHECKPOINT_TIME;
    }
    if (!are_counts_sound(state, limits)) {
        return CHECKPOINT_COUNTS; // Check the counts before any table is read.
    }
    const mission_descriptor_t* const mission = limits->mission;
    const struct {
        bool is_sound;
        checkpoint_flaw_t flaw;
    } checks[] = {
        {descriptor_mission_find_mode(mission, state->mode) != NULL, CHECKPOINT_MODE},
        {(state->log_written < state->log_number) && (state->log_strategy <= (uint8_t)MISSION_LOG_RING) &&
             is_boolean(&state->is_log_failure_reported),
         CHECKPOINT_LOG},
        {is_shutdown_sound(state), CHECKPOINT_SHUTDOWN},
        {are_subsystems_sound(state, limits), CHECKPOINT_SUBSYSTEM},
        {are_accepted_sound(state, limits) && is_graph_sound(&state->graph, limits) &&
             are_renewals_sound(state, limits),
         CHECKPOINT_LINK},
        {are_sessions_sound(state, limits), CHECKPOINT_SESSION},
        {are_plans_sound(state, limits), CHECKPOINT_PLAN},
        {are_requests_sound(&state->pending, state->now_ns, limits) &&
             are_requests_sound(&state->own, state->now_ns, limits),
         CHECKPOINT_REQUEST},
        {pus_counts_are_sound(&state->counts), CHECKPOINT_NUMBERS},
        {are_channels_sound(state, limits), CHECKPOINT_CHANNEL},
        {are_rings_sound(state), CHECKPOINT_RING},
    };
    for (size_t i = 0U; i < (sizeof checks / sizeof checks[0]); i++) {
        if (!checks[i].is_sound) {
            return checks[i].flaw;
        }
    }
    return CHECKPOINT_SOUND;
}
