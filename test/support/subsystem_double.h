// SPDX-License-Identifier: Apache-2.0
/// Replaces the generic subsystem (subsystem.h) in tests of specific ones. The test sets time, state and
/// links; the double records events, function results and the samples written to ports. A test directory that
/// uses it has one source file that includes subsystem_double.inc.
#ifndef TEST_SUPPORT_SUBSYSTEM_DOUBLE_H
#define TEST_SUPPORT_SUBSYSTEM_DOUBLE_H

#include "fsw/framework/descriptor/descriptor.h"
#include "fsw/framework/parameter/parameter.h"
#include "fsw/framework/subsystem/subsystem.h"

#define DOUBLE_EVENTS 64U
#define DOUBLE_RESULTS 16U
#define DOUBLE_PORTS 8U
#define DOUBLE_PAYLOAD 128U

typedef struct {
    uint16_t id;
    size_t size;
    uint8_t octets[64];
} double_event_t;

typedef struct {
    uint32_t call_token;
    uint16_t code;
    uint32_t detail;
} double_result_t;

typedef struct { // A port: the value read from it, and the value written to it.
    status_t read_status;
    uint8_t sample[DOUBLE_PAYLOAD];
    uint32_t age_us;
    status_t write_status;
    uint8_t written[DOUBLE_PAYLOAD];
    size_t written_size;
    unsigned writes;
    state_t written_state;
} double_port_t;

struct subsystem {
    const subsystem_descriptor_t* descriptor;
    const subsystem_callbacks_t* callbacks;
    void* self;
    const descriptor_configuration_t* configuration;
    state_t state;
    bool is_restarted;
    uint64_t now_ns;
    uint64_t period_ns;
    uint64_t device_deadline_ns;
    uint32_t cycle;
    parameter_dictionary_t dictionary;
    parameter_entry_t entries[DESCRIPTOR_PARAMETERS_MAX];
    parameter_bounds_t bounds[DESCRIPTOR_FIELDS_MAX];
    double_event_t events[DOUBLE_EVENTS];
    unsigned event_count;
    bool has_raised_high; ///< An event of high severity was raised in this cycle: double_cycle calls secure.
    double_result_t results[DOUBLE_RESULTS];
    unsigned result_count;
    double_port_t ports[DOUBLE_PORTS];
};

/// The subsystem is OFFLINE at time 0, with a period of 500 us; reading and writing a port return
/// STATUS_CLOSED until the test sets another status.
void double_init(subsystem_t* subsystem, const subsystem_descriptor_t* descriptor,
                 const subsystem_callbacks_t* callbacks, void* self);
/// Call software_init, then set the initial values of the descriptor. Returns the first failure.
status_t double_software_init(subsystem_t* subsystem);
/// Set the initial values of a configuration.
void double_set_initials(subsystem_t* subsystem, const descriptor_configuration_t* configuration);
/// One cycle as the generic subsystem runs it: sense; the action once (may be null), or secure if sense has
/// raised an event of high severity; control if `is_controlled`; emit. Returns the result of the action. The
/// test advances the time.
status_t double_cycle(subsystem_t* subsystem, status_t (*action)(void* self), bool is_controlled);
/// Returns the number of recorded events with this id.
unsigned double_events(const subsystem_t* subsystem, uint16_t id);
/// Returns the last recorded event with this id, or null if there is none.
const double_event_t* double_last_event(const subsystem_t* subsystem, uint16_t id);

#endif // TEST_SUPPORT_SUBSYSTEM_DOUBLE_H
