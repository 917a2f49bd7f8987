// SPDX-License-Identifier: Apache-2.0
/// ST[18] under test on an engine that plays scripts: what its procedures call is what the test lists.
#ifndef TEST_UNIT_PUS_SCRIPTS_H
#define TEST_UNIT_PUS_SCRIPTS_H

#include "pus/st18_procedures.h"
#include "test/unit/pus/records.h"
#include "test/unit/pus/reports.h"

#define SCRIPT_SLOTS 2U
#define SCRIPT_PROCEDURES 3U
#define SCRIPT_CALLS 64U
#define SCRIPT_CALLS_EACH 5U ///< Noticed by others, of a procedure in a cycle.
#define SCRIPT_CYCLE_NS 10000000ULL
#define SCRIPT_OBSERVATION 700U
#define SCRIPT_FAILURE 701U
#define SCRIPT_KNOWN_EVENT 702U
#define SCRIPT_TIMEOUT 50U ///< Of requests that are waited for [cycles].

typedef struct {
    pus_procedures_t service;
    pus_requester_t requester;
    uint32_t cycle;
    status_t start_status; ///< What the engine answers next.
    struct {
        size_t count; ///< Calls that the test has listed, and those played.
        size_t next;
        pus_call_t calls[SCRIPT_CALLS];
        pus_answer_t answer; ///< To the last call.
        uint32_t budget;     ///< All that it was granted.
        uint32_t last;       ///< Budget granted last.
        uint32_t uses;       ///< What it uses in each cycle.
        bool is_running;
    } slots[SCRIPT_SLOTS];
    uint8_t arguments[64]; ///< Of the last start,
    size_t arguments_size;
    struct {
        unsigned count;
        uint16_t id;
        size_t size;
        uint8_t auxiliary[80];
    } events;
    struct {
        status_t status; ///< What the port for requests answers.
        unsigned count;
        pus_tc_t last;
        uint8_t packet[PUS_PACKET_MAX];
    } sent;
    struct {
        status_t open;
        status_t read;
        uint32_t size;
        unsigned opened;
        unsigned closed;
    } file;
} scripts_t;

extern scripts_t scripts;

void scripts_start(void);
/// Begin anew with the records that are lasting.
void scripts_restart(void);
void scripts_step(unsigned cycles);

/// Requests: of a procedure's id and what follows it.
status_t script_send(uint8_t subtype, const char* id, const void* data, size_t size);
/// Load code of `size` octets, each `fill`; activate at a level, without arguments.
void script_loaded(const char* id, size_t size, uint8_t fill);
void script_activated(const char* id, uint8_t level);
/// List a call of a slot.
void script_call(uint16_t slot, pus_call_kind_t kind, uint32_t number);
void script_wait(uint16_t slot, pus_call_kind_t kind, double seconds);
void script_request(uint16_t slot, bool does_wait);
/// TM[18,9] tells this status of the only procedure.
void expect_script_status(uint8_t status);
/// The last event: what happened to procedure `id`, and its detail.
void expect_observation(uint16_t event, const char* id, uint8_t what, uint16_t step, uint32_t detail);

#endif // TEST_UNIT_PUS_SCRIPTS_H
