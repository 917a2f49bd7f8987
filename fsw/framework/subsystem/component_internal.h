// SPDX-License-Identifier: Apache-2.0
/// Shared by the source files of the generic subsystem; private to them.
#ifndef FSW_FRAMEWORK_SUBSYSTEM_COMPONENT_INTERNAL_H
#define FSW_FRAMEWORK_SUBSYSTEM_COMPONENT_INTERNAL_H

#include "fsw/framework/subsystem/component.h"

/// component.c: the cycle without a configuration, and when pools warn, as the descriptor has them.
void component_set_idle_period(component_t* component);
void component_set_pool_thresholds(component_t* component);
/// component.c: raise an event without auxiliary data of its own, if the descriptor has it.
void component_raise(component_t* component, const char* name);

/// component_services.c: fill the service list from the descriptor.
void component_register_services(component_t* component);
/// Step the services that the descriptor lists.
void component_step_optional(component_t* component);
/// Bounds, settable flags and initial values of all published parameters. STATUS_OK or the first refusal.
status_t component_initialise_parameters(component_t* component);
/// Housekeeping structures and initial values of the configuration. STATUS_OK or the first refusal.
status_t component_apply_configuration(component_t* component);
/// Take the waiting descriptor in if the component rests where it may change; ends its request.
void component_take_reload(component_t* component);
/// Stop housekeeping.
void component_revoke_configuration(component_t* component);
/// Auxiliary data of an event by its references; returns the size written.
size_t component_sample_auxiliary(component_t* component, const descriptor_event_t* event, uint8_t* octets,
                                  size_t capacity);

/// component_loops.c: loops begin when their configuration is applied, and end before it is revoked: then
/// none samples, waiting requests are performed, and housekeeping that waits in the mailboxes is dropped and
/// counted. `values` is what their instance of ST[20] reads.
void component_init_loops(component_t* component, const pus_parameter_port_t* values);
/// Call it before any service is set up, because a service may lock loop_guard at once.
void component_create_guards(component_t* component);
void component_begin_loops(component_t* component);
void component_end_loops(component_t* component);
/// Step them all in their order, where they have no tasks of their own; returns the earliest wake.
uint64_t component_step_loops(component_t* component);
/// Send the reports that the loops have finished.
void component_empty_mailboxes(component_t* component);

/// component_state.c: run the entry action that is due; report changes.
void component_run_action(component_t* component);
/// Make the machine's last transitions known: TM[129,2], progress, end of the pending request.
void component_after_change(component_t* component);
pus_reply_t component_request_state(void* context, const pus_state_order_t* order, const pus_token_t* token,
                                    uint64_t now_ns);
pus_reply_t component_select_configuration(void* context, uint16_t configuration, const pus_token_t* token,
                                           uint64_t now_ns);
/// Feed an event to the machine. `code` goes into TM[129,2].
void component_machine_event(component_t* component, state_event_t event, state_cause_t cause, uint16_t code);

/// component_links.c.
pus_rtlink_port_t component_link_port(component_t* component);
void component_watch_links(component_t* component);
void component_close_links(component_t* component, uint8_t reason);
/// True if every required port of the configuration has an open, fresh link.
bool component_has_required_links(component_t* component, uint16_t* out_missing_port);

/// component_link_table.c: a provided port has any readers, one slot for each of its links; a required port
/// has one writer and one slot.
/// Link of this number; null if there is none.
component_link_t* component_link_numbered(component_t* component, uint16_t number);
/// First link of a port; null if there is none.
component_link_t* component_link_of(component_t* component, uint16_t port);
/// Next link of a port after `previous` in the table (null: first of all); null if there is none.
component_link_t* component_link_next(component_t* component, const component_link_t* previous,
                                      uint16_t port);
/// The slot for a link of this number and port: that of the link it replaces, else a free slot. Null: there
/// is no room, or the number belongs to a link of another port.
component_link_t* component_link_slot(component_t* component, const descriptor_port_t* port, uint16_t number);

#endif // FSW_FRAMEWORK_SUBSYSTEM_COMPONENT_INTERNAL_H
