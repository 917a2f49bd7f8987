// SPDX-License-Identifier: Apache-2.0
/// A test bed for one generic subsystem: a descriptor of its own, callbacks that do as they are told, a port
/// that writes down every report as one line of text, and simulated time.
///
///     bed_open(NULL);
///     bed_state(STATE_PRE_OPERATIONAL);     // A telecommand; the first has number 0.
///     bed_run(1U);                          // Cycles.
///     bed_expect("1.1 #0\n" ...);           // All lines since the last look.
///
/// Lines: "1.5 #0 step 3", "1.4 #0 0204 3" (code, detail), "129.2 0>1 ENTERING cause 0 code 0000 cfg 0",
/// "5.4 event 1 aux 0007", "130.10 link 1 2>3 reason 0"; callbacks as "* secure"; links and lists see bed.c.
#ifndef TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_BED_H
#define TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_BED_H

#include "fsw/framework/subsystem/component.h"
#include "test/support/bed_lines.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define BED_APID 16U
#define BED_USER 1U
#define BED_SUPERVISOR 0x8001U
#define BED_PERIOD_NS 1000000ULL ///< Of both configurations; without one it is ten times as long.
#define BED_ALONE 1U
#define BED_LINKED 2U

enum {
    BED_BROKEN        = 1, ///< HIGH, auxiliary CODE u16.
    BED_STRAINED      = 2, ///< MEDIUM.
    BED_NOTE          = 3, ///< LOW, samples LIMIT.
    BED_INFO          = 4, ///< INFORMATIVE.
    BED_POOL_WARNING  = 5,
    BED_LINK_STALE    = 6,
    BED_STATE_TIMEOUT = 10,
    BED_LINK_CLOSED   = 11,
    BED_NETWORK       = 12
};

typedef struct { // Argument structure of MOVE.
    double target[2];
    uint16_t speed;
} bed_move_t;

typedef struct {
    component_t component;
    subsystem_descriptor_t descriptor;
    uint64_t now_ns;
    uint16_t source;                ///< Of the next telecommands.
    uint8_t ack;                    ///< Of the next telecommands.
    bool has_many_users;            ///< Reports may go to anybody.
    bool is_port_closed;            ///< The port refuses everything.
    bool shows_actions;             ///< Callbacks of actions become lines.
    bool shows_cycle;               ///< sense, control and emit become lines.
    bool shows_status;              ///< TM[129,5] and TM[3,25] become lines.
    status_t results[ACTION_COUNT]; ///< What an action ends with.
    unsigned delays[ACTION_COUNT];  ///< How often it says STATUS_BUSY before that.
    void (*in_sense)(void);         ///< Called from the callback of that name.
    void (*in_control)(void);
    void (*in_action)(state_action_t action);
    status_t (*in_perform)(const subsystem_function_t* function);
    bed_move_t moved;                ///< Arguments of the last MOVE.
    pus_link_properties_t supported; ///< What the last refusal of a link says.
    uint32_t last_ticket;
    uint16_t next_sequence; ///< Number that the next report has.
    uint32_t set_id;        ///< Last parameter_set.
    unsigned releases;
    struct {
        int32_t state;
        double position[2];
    } values;
    double limit;
    uint16_t count;
    const subsystem_descriptor_t* next_descriptor; ///< For TC[129,6]; null refuses.
} bed_t;

extern bed_t bed;
/// Ids of the published parameters.
extern const uint32_t bed_values_id;
extern const uint32_t bed_limit_id;
extern const uint32_t bed_count_id;

/// A component in OFFLINE at time 0 with the built-in descriptor, or the one of `xml`.
void bed_open(const char* xml);
/// The same after bed_close, with the built-in descriptor in which `old` is replaced wherever it stands.
void bed_open_with(const char* old, const char* with);
/// Begin anew with another configuration of the component; time goes on.
void bed_begin(const component_config_t* config);
/// A component with a descriptor that was refused.
void bed_open_invalid(void);
void bed_close(void);
/// Parse a descriptor. False with the reason printed.
bool bed_parse(const char* xml, subsystem_descriptor_t* out_descriptor);
/// Names of the links of this bed, for the other ends.
const link_resolver_t* bed_links(void);
/// Text of the built-in descriptor.
const char* bed_descriptor(void);

/// Send a telecommand; returns its number (#n in the lines).
uint16_t bed_command(uint8_t service, uint8_t subtype, const void* data, size_t size);
uint16_t bed_state(state_t target);
/// The supervisor's, with its cause.
uint16_t bed_order(state_t target, state_cause_t cause);
uint16_t bed_select(uint16_t configuration);
/// TC[8,1] with the arguments as they are on the wire.
uint16_t bed_function(const char* name, const void* arguments, size_t size);
/// Bring octets as they are.
void bed_accept(const uint8_t* octets, size_t size);
/// A report of the supervisor: its heartbeat.
void bed_heartbeat(void);
/// Run the component at every wake of the next n cycles of its present period.
void bed_run(unsigned cycles);
/// Run until a time, with heartbeats twice a second.
void bed_run_until(uint64_t end_ns);
/// Bring it to a rest state by telecommands, with a configuration from 3 upwards (0: none), and forget all
/// lines.
void bed_bring(state_t state, uint16_t configuration);

/// Note a line of the test itself.
void bed_note(const char* text);

#endif // TEST_UNIT_FSW_FRAMEWORK_SUBSYSTEM_BED_H
