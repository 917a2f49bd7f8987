// SPDX-License-Identifier: Apache-2.0
/// What a supervisor that is started again takes over from the one that died: shared memory
/// "/<identity>.vitals", made (all zeros) by the launcher, written by the supervisor alone. No pointers, no
/// enumerations and no truth values: whatever octets lie there can be read, are checked field by field, and
/// are believed only then.
///
/// Two banks. A commit writes the older one, its sum, then its generation (release): at whatever instant the
/// writer dies, one bank is whole. Beside the banks lie the rings whose octets outlive the process; their
/// positions are in the bank.
///
/// Ownership  The memory is the caller's. Context: one loop of one process at a time. Time: O(size), about 12
/// KiB.
#ifndef FSW_SUPERVISOR_VITALS_H
#define FSW_SUPERVISOR_VITALS_H

#include "fsw/framework/base/status.h"
#include "fsw/framework/descriptor/mission_descriptor.h"
#include "fsw/framework/message/message.h"
#include "fsw/supervisor/link_graph.h"
#include "fsw/supervisor/pending_table.h"
#include "pus/process.h"
#include "pus/requester.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define VITALS_SESSIONS 8U
#define VITALS_PLANS 8U
#define VITALS_RINGS 3U
#define VITALS_BANKS_MAX 32768U ///< Both banks together [octets].
#define VITALS_NO_PLAN 0U       ///< vitals_plan_t.plan: built in.

typedef struct { // pus_token_t.
    uint32_t request_id;
    uint16_t source;
    uint8_t ack;
    uint8_t service;
    uint8_t subtype;
    uint8_t reserved[3];
} vitals_token_t;

typedef struct { // A subsystem of the mission, in its order.
    uint64_t heard_ns;
    uint64_t started_ns;
    uint64_t interface_hash;
    uint64_t configuration_hash;
    uint32_t life;
    uint16_t apid;
    uint16_t configuration;
    uint8_t process; ///< process_state_t.
    uint8_t state;
    uint8_t phase;
    uint8_t is_heard;
    uint8_t restarts;
    uint8_t is_order_owed;
    uint8_t ordered;
    uint8_t is_interface_foreign;
} vitals_member_t;

typedef struct { // A link that was agreed on, or that is open.
    uint16_t link;
    uint16_t producer_apid;
    uint16_t producer_port;
    uint16_t consumer_apid;
    uint16_t consumer_port;
    uint16_t is_stale;
} vitals_edge_t;

typedef struct { // A negotiation under way.
    uint64_t deadline_ns;
    vitals_token_t token;
    uint32_t asked;
    uint32_t transaction;
    uint32_t epoch;
    vitals_edge_t edge;
    uint32_t step; ///< session_step_t; 0: free.
} vitals_session_t;

typedef struct { // A recovery plan under way.
    uint64_t start_ns;
    uint16_t is_used;
    uint16_t plan; ///< Number in the mission, from 1.
    uint16_t apid;
    uint16_t lost;
    uint16_t next_action;
    uint16_t member_count;
    uint16_t members[LINK_GRAPH_MEMBERS];
} vitals_plan_t;

typedef struct { // A request whose verification is not over.
    uint64_t since_ns;
    vitals_token_t token;
    uint16_t apid; ///< 0: free.
    uint16_t is_answered;
} vitals_request_t;

typedef struct { // pus_message_counter_t.
    uint8_t service;
    uint8_t subtype;
    uint16_t destination;
    uint16_t count;
} vitals_message_t;

typedef struct { // Sequence count of requests to an addressee.
    uint16_t apid;
    uint16_t sequence;
} vitals_addressee_t;

typedef struct { // Of an octet ring whose octets lie beside the banks.
    uint32_t head;
    uint32_t used;
    uint32_t blocks;
} vitals_ring_t;

typedef struct { // message_channel_t.
    uint32_t peer_epoch;
    uint32_t sent;
    uint32_t credited;
    uint32_t expected;
    uint32_t taken;
    uint32_t told;
    uint32_t refusals;
    uint32_t under_way;
    uint32_t untold;
    uint16_t peer;
    uint16_t reserved;
    uint16_t sizes[MESSAGE_WINDOW];
} vitals_channel_t;

typedef struct {
    uint64_t interface_hash; ///< Of the mission.
    uint64_t now_ns;         ///< Of the commit.
    uint64_t log_number;     ///< Of the next record.
    uint64_t orbit_offset;
    uint64_t shutdown_ns;
    vitals_token_t shutdown_token;
    uint32_t lives; ///< Of the supervisor in this run, this one included.
    uint32_t epoch; ///< Of its message channels, which outlive it.
    uint32_t link_epoch;
    uint32_t link_transaction;
    uint32_t orbit_period_ms;
    uint16_t sequence; ///< Of the next report.
    uint16_t member_count;
    uint16_t channel_count;
    uint16_t message_count;
    uint16_t addressee_count;
    uint16_t accepted_count;
    uint16_t open_count;
    uint8_t mode;
    uint8_t log_strategy;
    uint8_t is_log_failure_told;
    uint8_t autostart_step;
    uint8_t shutdown_step;
    uint8_t has_shutdown_token;
    vitals_member_t members[MISSION_SUBSYSTEMS_MAX];
    vitals_edge_t accepted[LINK_GRAPH_EDGES];
    vitals_edge_t open[LINK_GRAPH_EDGES]; ///< In the order of opening.
    vitals_session_t sessions[VITALS_SESSIONS];
    vitals_plan_t plans[VITALS_PLANS];
    vitals_request_t passed[PENDING_MAX]; ///< To subsystems.
    vitals_request_t own[PENDING_MAX];    ///< To the supervisor itself.
    vitals_message_t messages[PUS_MESSAGE_COUNTERS];
    vitals_addressee_t addressees[PUS_ADDRESSEES];
    vitals_channel_t channels[MESSAGE_PEERS_MAX];
    vitals_ring_t rings[VITALS_RINGS];
} supervisor_vitals_t;

typedef struct {         // Private.
    uint64_t generation; // 0: never written. Stored last.
    uint64_t sum;
    supervisor_vitals_t state;
} vitals_bank_t;

typedef struct { // Private.
    vitals_bank_t banks[2];
} vitals_t;

/// What of it is not sound. The first one found is told.
typedef enum {
    VITALS_SOUND = 0,
    VITALS_MISSION,
    VITALS_TIME,
    VITALS_COUNTS,
    VITALS_MODE,
    VITALS_LOG,
    VITALS_SHUTDOWN,
    VITALS_MEMBER,
    VITALS_LINK,
    VITALS_SESSION,
    VITALS_PLAN,
    VITALS_REQUEST,
    VITALS_MESSAGE,
    VITALS_ADDRESSEE,
    VITALS_CHANNEL,
    VITALS_RING
} vitals_flaw_t;

typedef struct {                          // Against which a bank is checked.
    const mission_descriptor_t* mission;  ///< Another one's vitals are nobody's.
    uint64_t now_ns;                      ///< Nothing has happened later.
    size_t ring_capacities[VITALS_RINGS]; ///< [octets].
} vitals_limits_t;

/// Make `state` the one that the next life takes over. Whole or not at all, whenever the process ends.
void vitals_commit(vitals_t* vitals, const supervisor_vitals_t* state);
/// VITALS_SOUND, or the first field that cannot be: an index out of its table, a member or link that the
/// mission does not have, a count that contradicts another, a time to come.
vitals_flaw_t vitals_check(const supervisor_vitals_t* state, const vitals_limits_t* limits);
/// Take over the newer of the sound banks; one that is not sound is cleared. *out_older: the newest one was
/// not. STATUS_OK; STATUS_NOT_FOUND:
/// nothing was ever committed; STATUS_INVALID: no bank is sound.
MUST_USE status_t vitals_adopt(vitals_t* vitals, const vitals_limits_t* limits,
                               supervisor_vitals_t* out_state, bool* out_older);

#endif // FSW_SUPERVISOR_VITALS_H
