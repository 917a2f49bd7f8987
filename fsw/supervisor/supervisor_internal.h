// SPDX-License-Identifier: Apache-2.0
/// Functions that only the source files of the supervisor share.
#ifndef FSW_SUPERVISOR_SUPERVISOR_INTERNAL_H
#define FSW_SUPERVISOR_SUPERVISOR_INTERNAL_H

#include "fsw/supervisor/supervisor.h"

/// output_commit.c: from now on only supervisor_output_commit_perform sends frames.
void supervisor_output_commit_init(supervisor_t* supervisor);
/// Order to start or stop (`is_hung`: kill) the process of a subsystem. supervisor_output_commit_perform
/// performs the orders, but supervisor_output_commit_is_running already regards them as performed.
void supervisor_output_commit_start(supervisor_t* supervisor, registry_entry_t* entry);
void supervisor_output_commit_stop(supervisor_t* supervisor, registry_entry_t* entry, bool is_hung);
bool supervisor_output_commit_is_running(const supervisor_t* supervisor, const registry_entry_t* entry);
/// Report to the platform that the mission has ended.
void supervisor_output_commit_finish(supervisor_t* supervisor);
/// Perform all outputs, which must have been committed, then report the processes that could not be started.
/// True if a peer could not take a frame; the next call performs the rest, which must be committed again.
bool supervisor_output_commit_perform(supervisor_t* supervisor);
/// Skip the outputs of the adopted commit that were already performed.
void supervisor_output_commit_resume(supervisor_t* supervisor);

/// router.c: take in the packets that have arrived, and route them.
void supervisor_router_take_in(supervisor_t* supervisor);
/// Write out the packet log; a failure raises an event.
void supervisor_router_flush_log(supervisor_t* supervisor);
/// Append a packet to the log; a longer one than PUS_PACKET_MAX is already there, in parts.
void supervisor_router_log(supervisor_t* supervisor, const uint8_t* packet, size_t size);
/// Port of the supervisor's own reports and requests: logs and then delivers a packet. STATUS_OK: logged; a
/// report for which the ground has no room is dropped if it is periodic, or if the ground has taken no report
/// for 1 s. STATUS_FULL: there is no room, the packet was neither logged nor delivered; the caller sends it
/// again.
status_t supervisor_router_send(void* context, const uint8_t* packet, size_t size);
/// Ports of ST[15] and ST[09] to ground; the context is the supervisor. STATUS_OK, STATUS_FULL (other reports
/// wait, no room, or no connection to ground now: try again later).
status_t supervisor_router_send_stored(void* context, uint8_t virtual_channel, const uint8_t* packet,
                                       size_t size);
status_t supervisor_router_send_time(void* context, const uint8_t* packet, size_t size);
/// True if the inbox of `apid` has room for a request now; the supervisor itself always has room.
bool supervisor_router_has_room(const supervisor_t* supervisor, uint16_t apid);
/// Route a request that a service on board has released, as if its source had sent it.
void supervisor_router_route_released(supervisor_t* supervisor, const uint8_t* packet, size_t size);
/// Order a subsystem of the mission to a state by TC[129,8], with the cause. If the inbox has no room, the
/// order is stored and sent later, unless another one replaces it or the process dies. Statuses of
/// pus_tc_send.
status_t supervisor_order_state(supervisor_t* supervisor, uint16_t apid, state_t target, pus_cause_t cause);
/// Send the stored orders for which there is room now.
void supervisor_send_pending_orders(supervisor_t* supervisor);
/// Order a subsystem to apply a configuration by TC[129,3]. Statuses of pus_tc_send; the order is not stored.
status_t supervisor_order_configuration(supervisor_t* supervisor, uint16_t apid, uint16_t configuration);

/// Route a request of a user that was assembled from parts and is well-formed. STATUS_OK (also if it is
/// refused), STATUS_FULL (no room in the inbox of its addressee: try again later).
status_t supervisor_router_route_whole(supervisor_t* supervisor, const uint8_t* packet, size_t size);

/// ground_link.c: send reports that wait for the ground.
void supervisor_ground_flush(supervisor_t* supervisor);
/// Send a report of a subsystem to the ground, or let it wait; if it cannot wait, it is dropped and counted.
/// `block` is the block that contains the packet, or null.
void supervisor_ground_send(supervisor_t* supervisor, uint16_t apid, const uint8_t* packet, size_t size,
                            uint8_t* block);
/// True if a report of this class could be sent or could wait, or if the supervisor has stopped waiting for
/// the ground.
bool supervisor_ground_accepts(const supervisor_t* supervisor, pus_class_t class, size_t size);
/// True if reports wait, or the next one would have to wait.
bool supervisor_ground_is_waiting(const supervisor_t* supervisor);
/// True if requests of the ground may be accepted, because there is room for the answers.
bool supervisor_ground_takes_requests(const supervisor_t* supervisor);
/// Copy the reports that wait for the ground, for the next life of the supervisor.
void supervisor_ground_keep(supervisor_t* supervisor);
/// Restore the reports that the previous life has copied.
void supervisor_ground_resume(supervisor_t* supervisor);
/// Raise GROUND_BEHIND if a report for the ground was dropped; once until no report waits any more.
void supervisor_ground_report(supervisor_t* supervisor);
/// Update the published state of the link to ground.
void supervisor_ground_update(supervisor_t* supervisor);

/// subsystem_registry.c: the data of all subsystems.
registry_entry_t* supervisor_registry_find(supervisor_t* supervisor, uint16_t apid);
void supervisor_registry_init(supervisor_t* supervisor);
/// True if the subsystem's process runs and, if it was started again, has reported since: before its first
/// report in a new life, no packet may be sent to it.
bool supervisor_registry_is_there(const registry_entry_t* entry);
/// Order a new life of the subsystem's process. If the platform refuses it, supervisor_output_commit_perform
/// calls supervisor_registry_start_failed.
void supervisor_registry_start(supervisor_t* supervisor, registry_entry_t* entry);
/// Handle a refusal of the platform: the process counts as lost, and the mission enters its fallback mode.
void supervisor_registry_start_failed(supervisor_t* supervisor, registry_entry_t* entry);
/// Update the registry from a report that was routed.
void supervisor_registry_report(supervisor_t* supervisor, const pus_tm_t* tm);
/// End every unanswered request to a subsystem whose process ended.
void supervisor_registry_end_pending(supervisor_t* supervisor, uint16_t apid);
/// End every request that requires a report of acceptance and has got no report within `timeout_ns`.
void supervisor_registry_end_unanswered(supervisor_t* supervisor, uint64_t timeout_ns);
/// Check processes and heartbeats, and start processes again that are due; called every 10 ms.
void supervisor_registry_watch(supervisor_t* supervisor);
/// Returns the electrical power [W] of all subsystems if one of them were in another state.
uint32_t supervisor_registry_power_w(const supervisor_t* supervisor, uint16_t apid, state_t state);

/// adoption.c: commit the data that the next supervisor takes over, at the end of a step, before its outputs
/// are performed. If the supervisor dies before this, the next one repeats the step.
void supervisor_adoption_commit(supervisor_t* supervisor);
/// Take over the data of the previous supervisor, if there was one; called before the packet log is opened.
void supervisor_adoption_begin(supervisor_t* supervisor);
/// Called in the first step: if both commits were damaged, agree with all subsystems on the sequence numbers
/// of messages, and request their status.
void supervisor_adoption_reopen(supervisor_t* supervisor);
/// Called in each step, after the messages were taken in; once after a takeover: end the requests that cannot
/// continue, report it, and request the status of all subsystems. Once after a damaged commit: report it, and
/// enter the fallback mode if both were damaged.
void supervisor_adoption_report(supervisor_t* supervisor);
/// Compare a state that a subsystem reports with the state that was taken over; once for each subsystem.
void supervisor_adoption_compare(supervisor_t* supervisor, registry_entry_t* entry, uint8_t state,
                                 uint16_t configuration);

/// doubt.c: true if the state of a subsystem may differ from the known one; no decision may depend on it.
bool supervisor_doubt_exists(const registry_entry_t* entry);
/// Request the status of subsystems whose reports arrive again after a silence; called every 10 ms.
void supervisor_doubt_watch(supervisor_t* supervisor);
/// End the doubt about a subsystem that has answered.
void supervisor_doubt_verification(supervisor_t* supervisor, const pus_tm_t* tm,
                                   const pus_verification_t* verification);

/// permission.c: returns PUS_FAILURE_NONE, or the reason why a request is not permitted.
pus_failure_t supervisor_permission_of(supervisor_t* supervisor, const pus_tc_t* tc);

/// link_manager.c: port of service 130; the reports of the ends of links.
pus_rtlink_port_t supervisor_link_manager_port(supervisor_t* supervisor);
void supervisor_link_manager_report(supervisor_t* supervisor, const pus_tm_t* tm);
/// For each link of which one end has closed, order the other end to close, too. Called after all reports of
/// the step have been processed.
void supervisor_link_manager_settle(supervisor_t* supervisor);
/// End sessions whose time-out has passed; called every 10 ms.
void supervisor_link_manager_watch(supervisor_t* supervisor);
/// Begin the next step of opening a link again (first negotiate, then open) with the properties on which both
/// ends agreed last. True if a step was begun.
bool supervisor_link_manager_renew(supervisor_t* supervisor, uint16_t link);
/// End the sessions of a subsystem whose process ended or that is OFFLINE, remove its agreed and open links,
/// and close their other ends.
void supervisor_link_manager_member_lost(supervisor_t* supervisor, uint16_t apid);

/// error_handling.c: react to an event of a subsystem, which its report or, if the report is disabled, a
/// notice contains.
void supervisor_error_event(supervisor_t* supervisor, const pus_event_occurrence_t* event);
/// Store an event of the supervisor itself, which `tm` reports, if it needs a reaction; without room it is
/// counted as missed. supervisor_error_own_events reacts later, because this is called while that report is
/// being sent, and no other report may be built at that time.
void supervisor_error_own_event(supervisor_t* supervisor, const pus_tm_t* tm,
                                const pus_event_occurrence_t* event);
/// React to the stored events of the supervisor itself.
void supervisor_error_own_events(supervisor_t* supervisor);
/// React to the death of a process (event PROCESS_LOST or PROCESS_HUNG); the links of the subsystem must
/// still be in the graph.
void supervisor_error_member_lost(supervisor_t* supervisor, uint16_t apid, uint16_t event_id);
/// React to a subsystem that has not sent a report for too long.
void supervisor_error_member_silent(supervisor_t* supervisor, uint16_t apid);
/// Perform the actions of recovery plans that are due.
void supervisor_error_run_plans(supervisor_t* supervisor);
/// Raise an event of the supervisor with one or two u16 of auxiliary data.
void supervisor_raise_u16(supervisor_t* supervisor, uint16_t event_id, uint16_t first);
void supervisor_raise_u16_u16(supervisor_t* supervisor, uint16_t event_id, uint16_t first, uint16_t second);

/// mode.c: set a mode of the mission, report it with its cause, and store the record. The present mode: no
/// effect.
void supervisor_mode_set(supervisor_t* supervisor, uint8_t mode, uint8_t cause);
/// Enter the fallback mode of the mission.
void supervisor_mode_fall_back(supervisor_t* supervisor);
/// Restore the persistent record of the mode. STATUS_OK, STATUS_INVALID (not SUPERVISOR_MODE_RECORD octets).
status_t supervisor_mode_restore(supervisor_t* supervisor, const uint8_t* octets, size_t size);
/// Called in the first step; without effect after a takeover. Enter the fallback mode if the previous flight
/// was interrupted, and store the record.
void supervisor_mode_begin(supervisor_t* supervisor);
/// Erase the record when the mission has been shut down, so that the next flight begins in its initial mode.
void supervisor_mode_end(supervisor_t* supervisor);

/// sequences.c: give the next orders of the autostart; begin the shutdown, unless there is one, for the
/// request `token` (null: there is no request to answer); perform its next step.
void supervisor_sequence_autostart(supervisor_t* supervisor);
void supervisor_sequence_shutdown_begin(supervisor_t* supervisor, const pus_token_t* token);
void supervisor_sequence_shutdown(supervisor_t* supervisor);
/// A subsystem has left OFFLINE: it gets the order for OFFLINE again if the shutdown has already ordered it;
/// but not `communication`.
void supervisor_sequence_left_offline(supervisor_t* supervisor, const registry_entry_t* entry);
/// True after the shutdown has ordered all subsystems but `communication` and the supervisor to OFFLINE.
bool supervisor_sequence_is_ending(const supervisor_t* supervisor);

/// mission_service.c: port of service 131.
pus_mission_port_t supervisor_mission_service_port(supervisor_t* supervisor);

#endif // FSW_SUPERVISOR_SUPERVISOR_INTERNAL_H
