// SPDX-License-Identifier: Apache-2.0
/// A test fixture for one generic subsystem: a descriptor of its own, callbacks whose results the test sets,
/// a port that writes down every report as one line of text, and simulated time.
///
///     fixture_open(NULL);
///     fixture_state(STATE_PRE_OPERATIONAL);     // A telecommand; the first has number 0.
///     fixture_run(1U);                          // Cycles.
///     fixture_expect("1.1 #0\n" ...);           // All lines since the last call.
///
/// Lines: "1.5 #0 step 3", "1.4 #0 0204 3" (code, detail), "129.2 0>1 ENTERING cause 0 code 0000 cfg 0",
/// "5.4 event 1 aux 0007", "130.10 link 1 2>3 reason 0"; callbacks as "* secure". Failure codes (PUS_FAILURE_
/// in pus/core/tailoring.h) and details are hexadecimal. subsystem_fixture_lines.c writes all forms of lines.
#ifndef TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_FIXTURE_H
#define TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_FIXTURE_H

#include "fsw/framework/subsystem/subsystem_core.h"
#include "test/support/fixture_lines.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FIXTURE_APID 16U
#define FIXTURE_USER 1U
#define FIXTURE_SUPERVISOR 0x8001U
/// Sampling time of both configurations; without a configuration the cycle is ten times as long.
#define FIXTURE_PERIOD_NS 1000000ULL
#define FIXTURE_ALONE 1U
#define FIXTURE_LINKED 2U

enum {
    FIXTURE_BROKEN        = 1, ///< HIGH, auxiliary CODE u16.
    FIXTURE_STRAINED      = 2, ///< MEDIUM.
    FIXTURE_NOTE          = 3, ///< LOW, samples LIMIT.
    FIXTURE_INFO          = 4, ///< INFORMATIVE.
    FIXTURE_POOL_WARNING  = 5,
    FIXTURE_LINK_STALE    = 6,
    FIXTURE_STATE_TIMEOUT = 10,
    FIXTURE_LINK_CLOSED   = 11,
    FIXTURE_NETWORK       = 12
};

typedef struct { // Arguments of MOVE.
    double target[2];
    uint16_t speed;
} fixture_move_t;

typedef struct {
    subsystem_t subsystem;
    subsystem_descriptor_t descriptor;
    uint64_t now_ns;
    uint16_t source;                ///< Source of the next telecommands.
    uint8_t ack;                    ///< Acknowledgement flags of the next telecommands.
    bool has_many_users;            ///< Reports may go to any user.
    bool is_port_closed;            ///< The port refuses all reports.
    bool shows_actions;             ///< Callbacks of actions become lines.
    bool shows_cycle;               ///< sense, control and emit become lines.
    bool shows_status;              ///< TM[129,5] and TM[3,25] become lines.
    status_t results[ACTION_COUNT]; ///< Status with which an action ends.
    unsigned delays[ACTION_COUNT];  ///< Number of STATUS_BUSY results before that.
    void (*in_sense)(void);         ///< Called from the callback of that name.
    void (*in_control)(void);
    void (*in_action)(state_action_t action);
    status_t (*in_perform)(const subsystem_function_t* function);
    fixture_move_t moved;            ///< Arguments of the last MOVE.
    pus_link_properties_t supported; ///< Properties in the last refusal of a link.
    uint32_t last_call_token;
    uint16_t next_sequence; ///< Expected sequence count of the next report.
    uint32_t set_id;        ///< Parameter id of the last parameter_set.
    unsigned releases;
    struct {
        int32_t state;
        double position[2];
    } values;
    double limit;
    uint16_t count;
    const subsystem_descriptor_t* next_descriptor; ///< Descriptor for TC[129,6]; null refuses the request.
} fixture_t;

extern fixture_t fixture;
/// Ids of the published parameters.
extern const uint32_t fixture_values_id;
extern const uint32_t fixture_limit_id;
extern const uint32_t fixture_count_id;

/// Start a component in OFFLINE at time 0, with the built-in descriptor (null) or with the descriptor `xml`.
void fixture_open(const char* xml);
/// Close and open the fixture, with the built-in descriptor in which every `old` is replaced.
void fixture_open_with(const char* old, const char* with);
/// Start again with another configuration of the component; time continues.
void fixture_begin(const subsystem_config_t* config);
/// Start a component whose descriptor was refused.
void fixture_open_invalid(void);
void fixture_close(void);
/// Parse a descriptor. Returns false and prints the reason if it is refused.
bool fixture_parse(const char* xml, subsystem_descriptor_t* out_descriptor);
/// Names of the fixture's links, for their other ends.
const rtlink_resolver_t* fixture_links(void);
/// Returns the text of the built-in descriptor.
const char* fixture_descriptor(void);

/// Send a telecommand; returns its number (#n in the lines).
uint16_t fixture_command(uint8_t service, uint8_t subtype, const void* data, size_t size);
uint16_t fixture_state(state_t target);
/// A request of the supervisor, with its cause.
uint16_t fixture_order(state_t target, state_cause_t cause);
uint16_t fixture_select(uint16_t configuration);
/// TC[8,1] with the encoded arguments.
uint16_t fixture_function(const char* name, const void* arguments, size_t size);
/// Deliver octets unchanged.
void fixture_accept(const uint8_t* octets, size_t size);
/// Deliver a report of the supervisor as its heartbeat.
void fixture_heartbeat(void);
/// Run the component at every wake of the next n cycles of its present period.
void fixture_run(unsigned cycles);
/// Run until a time, with heartbeats twice a second.
void fixture_run_until(uint64_t end_ns);
/// Bring the component to a rest state by telecommands, from state 3 on with a configuration (0: none), and
/// forget all lines.
void fixture_bring(state_t state, uint16_t configuration);

/// Add a line of the test.
void fixture_note(const char* text);

#endif // TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_FIXTURE_H
