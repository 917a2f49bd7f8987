// SPDX-License-Identifier: Apache-2.0
/// Functions that only the source files of the generic subsystem share.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_INTERNAL_H
#define FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_INTERNAL_H

#include "fsw/framework/subsystem/subsystem_core.h"

/// subsystem_core.c: set from the descriptor: the period that is used while no configuration is applied, and
/// the thresholds of the pools.
void subsystem_set_idle_period(subsystem_t* subsystem);
void subsystem_set_pool_thresholds(subsystem_t* subsystem);
/// subsystem_core.c: raise the event of this name without auxiliary data; no effect if the descriptor does
/// not define it.
void subsystem_raise_named(subsystem_t* subsystem, const char* name);

/// subsystem_services.c: fill the service list from the descriptor.
void subsystem_register_services(subsystem_t* subsystem);
/// Step the services that the descriptor lists.
void subsystem_step_optional(subsystem_t* subsystem);
/// Set bounds, settable flags and initial values of all published parameters. STATUS_OK or the first
/// refusal.
status_t subsystem_initialise_parameters(subsystem_t* subsystem);
/// Define the housekeeping structures and set the initial values of the configuration. STATUS_OK or the
/// first refusal.
status_t subsystem_apply_configuration(subsystem_t* subsystem);
/// Apply the descriptor that waits to be loaded if the subsystem is in a rest state that allows it, and
/// complete the request.
void subsystem_take_reload(subsystem_t* subsystem);
/// Reverse subsystem_apply_configuration: stop housekeeping.
void subsystem_revoke_configuration(subsystem_t* subsystem);
/// Write the present values of the parameters to which an event refers, and zeros for its own fields; returns
/// the octets written, which are those of the event's auxiliary data: `capacity` must have room for them.
size_t subsystem_sample_auxiliary(subsystem_t* subsystem, const descriptor_event_t* event, uint8_t* octets,
                                  size_t capacity);

/// subsystem_loops.c: the loops of services run from the moment their configuration is applied until just
/// before it is revoked. When they end, no loop samples any more, requests in their inboxes are performed,
/// and housekeeping reports in their mailboxes are dropped and counted. The ST[20] of the loops reads values
/// through the port `values`.
void subsystem_init_loops(subsystem_t* subsystem, const pus_parameter_port_t* values);
/// Create the mutexes of the loops. Must be called before any service is initialised, because a service may
/// lock loop_mutex immediately.
void subsystem_create_mutexes(subsystem_t* subsystem);
void subsystem_begin_loops(subsystem_t* subsystem);
void subsystem_end_loops(subsystem_t* subsystem);
/// Step all loops of services in their order, if they have no tasks of their own; returns the earliest wake.
uint64_t subsystem_step_loops(subsystem_t* subsystem);
/// Send the reports that the loops have finished.
void subsystem_empty_mailboxes(subsystem_t* subsystem);

/// subsystem_state.c: run the entry action that is due; report changes.
void subsystem_run_action(subsystem_t* subsystem);
/// Report the last transitions of the machine: TM[129,2], and the progress or end of the pending request.
void subsystem_after_change(subsystem_t* subsystem);
/// Functions of the port of service 129: request a state; select a configuration.
pus_reply_t subsystem_request_state(void* context, const pus_state_order_t* order, const pus_token_t* token,
                                    uint64_t now_ns);
pus_reply_t subsystem_select_configuration(void* context, uint16_t configuration, const pus_token_t* token,
                                           uint64_t now_ns);
/// Pass an event to the state machine; TM[129,2] reports `code`.
void subsystem_machine_event(subsystem_t* subsystem, state_event_t event, state_cause_t cause, uint16_t code);

/// subsystem_links.c: port of service 130; monitoring and closing of links.
pus_rtlink_port_t subsystem_link_port(subsystem_t* subsystem);
void subsystem_watch_links(subsystem_t* subsystem);
void subsystem_close_links(subsystem_t* subsystem, uint8_t reason);
/// True if every required port of the configuration has an open link with fresh samples.
bool subsystem_has_required_links(subsystem_t* subsystem, uint16_t* out_missing_port);

// subsystem_link_table.c: a provided port can have several links (one for each reader), each with its own
// slot; a required port has one link and one slot.

/// Returns the link with this number; null if there is none.
subsystem_link_t* subsystem_link_numbered(subsystem_t* subsystem, uint16_t number);
/// Returns the first link of a port; null if there is none.
subsystem_link_t* subsystem_link_of(subsystem_t* subsystem, uint16_t port);
/// Returns the link of a port that follows `previous` in the table (null: the first one); null if there is
/// none.
subsystem_link_t* subsystem_link_next(subsystem_t* subsystem, const subsystem_link_t* previous,
                                      uint16_t port);
/// Returns the slot for a link of this number and port: the slot of the link that it replaces, otherwise a
/// free one. Null if no slot is free, or if the number belongs to a link of another port.
subsystem_link_t* subsystem_link_slot(subsystem_t* subsystem, const descriptor_port_t* port, uint16_t number);

#endif // FSW_FRAMEWORK_SUBSYSTEM_SUBSYSTEM_INTERNAL_H
