// SPDX-License-Identifier: Apache-2.0
/// The data that a restarted supervisor takes over from the previous one, which has died: shared memory
/// "/<identity>.checkpoint". The launcher creates it (all zeros); only the supervisor writes it. It contains
/// no pointers; the supervisor checks each field before it uses the data.
///
/// There are two banks. A commit writes the older bank, its sum, then its generation (release); so one bank
/// is complete at any instant. A bank also contains the blocks in the rings that were passed to the commit;
/// usually the rings are empty.
///
/// Annexes belong to the last commit, and the next one empties them: the frames that have arrived after the
/// commit, the data to undo the writes after it, and the number of its outputs that were performed. A block
/// of an annex is complete or absent at any instant.
///
/// Ownership  The caller provides the memory.
/// Context    One loop of one process at a time.
/// Time       O(size): about 16 KiB, and the content of the rings.
#ifndef FSW_SUPERVISOR_CHECKPOINT_H
#define FSW_SUPERVISOR_CHECKPOINT_H

#include "base/capacities.h"
#include "base/status.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/message/message_positions.h"
#include "fsw/supervisor/ground_backlog.h"
#include "fsw/supervisor/link_graph.h"
#include "fsw/supervisor/orbit.h"
#include "fsw/supervisor/packet_log.h"
#include "fsw/supervisor/pending_table.h"
#include "fsw/supervisor/plan_runner.h"
#include "fsw/supervisor/recommission.h"
#include "pus/core/counts.h"
#include "pus/private/st130_rtlink.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define SUPERVISOR_LINK_SESSIONS 8U
#define CHECKPOINT_COUNTERS 16U
#define CHECKPOINT_RELEASED_OCTETS 65536U
#define CHECKPOINT_RINGS (4U + MESSAGE_PEERS_MAX)
#define CHECKPOINT_STATES_MAX 32768U ///< Largest size of the fields of both banks together [octets].
/// Octets of all rings of a bank if all of them are full.
#define CHECKPOINT_OCTETS                                                                                    \
    (MESSAGE_INBOX_OCTETS(CAPACITY_SUBSYSTEMS) + GROUND_OCTETS + CHECKPOINT_RELEASED_OCTETS +                \
     PACKET_LOG_RING_OCTETS + OUTPUT_COMMIT_OCTETS)
/// Room for the full windows of all peers, and for frames without data.
#define OUTPUT_COMMIT_OCTETS (MESSAGE_INBOX_OCTETS(CAPACITY_SUBSYSTEMS) + 32768U)
#define CHECKPOINT_ANNEX_OCTETS OUTPUT_COMMIT_OCTETS

#define RESTART_PAUSE_MAX_NS 1000000000ULL ///< Longest pause before a process is started again.

typedef struct { // Data of a subsystem, in the order of the mission; supervisor.h explains the fields.
    uint64_t heard_ns;
    uint64_t restart_ns;
    uint64_t started_ns;
    uint64_t interface_hash;
    uint64_t configuration_hash;
    uint64_t error_ns;
    recommission_t recommission;
    uint8_t order_cause; ///< pus_cause_t of `ordered`.
    uint8_t rested;
    uint16_t rested_with;
    uint16_t apid;
    uint16_t configuration;
    uint8_t process; ///< process_state_t.
    uint8_t state;
    uint8_t phase;
    uint8_t restarts;
    uint8_t deaths;
    uint8_t ordered;
    bool is_start_due;
    bool has_doubt; ///< `doubt` is not DOUBT_NONE.
    bool is_heard;
    bool is_order_pending;
    bool is_interface_mismatched;
    bool is_restarted;
} checkpoint_subsystem_t;

typedef enum {
    SESSION_FREE = 0,
    SESSION_ASK_PRODUCER,
    SESSION_ASK_CONSUMER,
    SESSION_OPEN_PRODUCER,
    SESSION_OPEN_CONSUMER,
    SESSION_CLOSING
} session_step_t;

typedef struct { // Running negotiation, opening or closing of one link.
    session_step_t step;
    uint16_t link;
    uint32_t asked;       ///< Transaction number of the requester.
    uint32_t transaction; ///< Transaction number of the manager; the answers of the subsystems contain it.
    uint32_t epoch;
    pus_link_ends_t ends;
    pus_link_properties_t wanted; ///< Properties that the request states, if the link is negotiated.
    pus_token_t token;            ///< Token of the request; source 0: the supervisor acts without a request.
    uint64_t deadline_ns;
} link_session_t;

typedef struct {   // Content of a message ring.
    uint32_t used; ///< [octets].
    uint32_t blocks;
} checkpoint_ring_t;

typedef struct {
    uint64_t interface_hash;                   ///< Hash of the mission.
    uint64_t now_ns;                           ///< Time of the commit.
    uint64_t log_number;                       ///< Number of the next record of the packet log.
    uint64_t log_written;                      ///< Last record that is in a file.
    uint64_t log_sizes[PACKET_LOG_STRATEGIES]; ///< Sizes of the files.
    uint64_t shutdown_ns;
    orbit_t orbit_state;
    pus_token_t shutdown_token;
    uint32_t lives;        ///< Number of lives of the supervisor in this run, this one included.
    uint32_t message_life; ///< Life of the supervisor's message channels, which outlive its process.
    uint32_t message_stamp;
    uint32_t link_epoch;
    uint32_t link_transaction;
    uint32_t renewed; ///< Bit n: link number n + 1 of the mission must be opened again.
    uint16_t subsystem_count;
    uint16_t channel_count;
    uint8_t mode;
    uint8_t log_strategy;
    uint8_t autostart_step;
    uint8_t shutdown_step;
    bool is_log_failure_reported;
    bool has_shutdown_token;
    uint32_t counters[CHECKPOINT_COUNTERS]; ///< The published counters.
    checkpoint_subsystem_t subsystems[MISSION_SUBSYSTEMS_MAX];
    link_edge_t accepted[MISSION_LINKS_MAX];
    link_graph_t graph;
    link_session_t sessions[SUPERVISOR_LINK_SESSIONS];
    pus_link_properties_t wanted[MISSION_LINKS_MAX]; ///< Not checked here: the subsystems check them.
    uint8_t renewals[MISSION_LINKS_MAX];
    plan_runner_t plans;
    pending_table_t pending; ///< Pending requests to subsystems.
    pending_table_t own;     ///< Pending requests to the supervisor itself.
    pus_counts_t counts;     ///< Counts of the supervisor's own packets.
    message_position_t channels[MESSAGE_PEERS_MAX];
    checkpoint_ring_t rings[CHECKPOINT_RINGS];
} checkpoint_state_t;

typedef struct {         // Private.
    uint64_t generation; // 0: the bank is not valid. The generation is stored last.
    uint64_t sum;
    checkpoint_state_t state;
    uint8_t octets[CHECKPOINT_OCTETS]; // Content of the rings, one after the other.
} checkpoint_bank_t;

typedef struct { // Private: a count that is valid only if it belongs to the last commit.
    uint64_t generation;
    uint64_t count;
} checkpoint_mark_t;

typedef struct { // Private.
    checkpoint_mark_t used;
    uint8_t octets[CHECKPOINT_ANNEX_OCTETS]; // Blocks, each with its size u32 before and after it.
} checkpoint_annex_t;

typedef struct {                 // Private; other modules use only the addresses of the annexes.
    checkpoint_annex_t arrivals; ///< Frames that have arrived, from message_watch.
    checkpoint_annex_t undo;     ///< Data to undo writes, see undo.h.
    checkpoint_mark_t performed;
    checkpoint_bank_t banks[2];
} checkpoint_t;

/// First field of a bank that is not consistent.
typedef enum {
    CHECKPOINT_SOUND = 0,
    CHECKPOINT_MISSION,
    CHECKPOINT_TIME,
    CHECKPOINT_COUNTS,
    CHECKPOINT_MODE,
    CHECKPOINT_LOG,
    CHECKPOINT_SHUTDOWN,
    CHECKPOINT_SUBSYSTEM,
    CHECKPOINT_LINK,
    CHECKPOINT_SESSION,
    CHECKPOINT_PLAN,
    CHECKPOINT_REQUEST,
    CHECKPOINT_NUMBERS,
    CHECKPOINT_CHANNEL,
    CHECKPOINT_RING
} checkpoint_flaw_t;

typedef struct {                         // Values against which a bank is checked.
    const mission_descriptor_t* mission; ///< A checkpoint of another mission is refused.
    uint64_t now_ns;                     ///< A bank with a later time is refused.
} checkpoint_limits_t;

typedef struct { // Rings whose content outlives the process; null: there is no such ring.
    message_ring_t* list[CHECKPOINT_RINGS];
} checkpoint_rings_t;

/// Commit `state` and the content of `rings` for the next life. If the process dies during this call, the
/// next life finds either all of them or the previous commit. Writes `state->rings`.
void supervisor_checkpoint_commit(checkpoint_t* checkpoint, checkpoint_state_t* state,
                                  const checkpoint_rings_t* rings);
/// Returns CHECKPOINT_SOUND, or the first field that is impossible: an index outside of its table, a
/// subsystem or link that the mission does not have, a count that contradicts another, a time in the future.
checkpoint_flaw_t supervisor_checkpoint_check(const checkpoint_state_t* state,
                                              const checkpoint_limits_t* limits);
/// Take over the newest sound bank; banks that are not sound are cleared. *out_older is true if a newer bank
/// was not sound. The waiting blocks are copied to `rings`, which must be empty; blocks without room are
/// counted as refused. STATUS_OK; STATUS_NOT_FOUND: there was no commit yet; STATUS_INVALID: no bank is
/// sound.
MUST_USE status_t supervisor_checkpoint_adopt(checkpoint_t* checkpoint, const checkpoint_limits_t* limits,
                                              checkpoint_state_t* out_state, const checkpoint_rings_t* rings,
                                              bool* out_older);

/// Add a block in two parts to an annex; the second part may be null if its size is 0. False if there is no
/// room.
bool supervisor_checkpoint_add(const checkpoint_t* checkpoint, checkpoint_annex_t* annex, const uint8_t* head,
                               size_t head_size, const uint8_t* octets, size_t size);
/// Returns the next block of an annex, from the first one on; null if there are no more. *position is 0 in
/// the first call.
const uint8_t* supervisor_checkpoint_next(const checkpoint_t* checkpoint, const checkpoint_annex_t* annex,
                                          size_t* position, size_t* out_size);
/// Returns the previous block of an annex, from the last one backwards; null if there are no more. *position
/// is 0 in the first call.
const uint8_t* supervisor_checkpoint_before(const checkpoint_t* checkpoint, const checkpoint_annex_t* annex,
                                            size_t* position, size_t* out_size);
/// Store and read the number of outputs of the last commit that were performed.
void supervisor_checkpoint_note_performed(checkpoint_t* checkpoint, uint32_t count);
uint32_t supervisor_checkpoint_performed(const checkpoint_t* checkpoint);
/// Returns the content of a ring (an index below CHECKPOINT_RINGS) in the last commit, which after the
/// takeover is the adopted one, as message_ring_copy wrote it; valid until the next commit.
const uint8_t* supervisor_checkpoint_waiting(const checkpoint_t* checkpoint, size_t ring, size_t* out_octets);

#endif // FSW_SUPERVISOR_CHECKPOINT_H
