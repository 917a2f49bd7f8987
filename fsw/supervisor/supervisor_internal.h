// SPDX-License-Identifier: Apache-2.0
/// Between the source files of the supervisor; for nobody else.
#ifndef FSW_SUPERVISOR_SUPERVISOR_INTERNAL_H
#define FSW_SUPERVISOR_SUPERVISOR_INTERNAL_H

#include "fsw/supervisor/supervisor.h"

/// router.c
void router_take_in(supervisor_t* supervisor);
/// Write out the packet log; a failure is an event.
void router_flush_log(supervisor_t* supervisor);
/// Append a packet to the log.
void router_log(supervisor_t* supervisor, const uint8_t* packet, size_t size);
/// Port of the supervisor's own reports and requests: log, then deliver. STATUS_OK; STATUS_FULL: nothing was
/// done, since there is no room on the way; it comes again.
status_t router_send(void* context, const uint8_t* packet, size_t size);
/// Ports of ST[15] and ST[09] to ground; the context is the supervisor. STATUS_OK, STATUS_FULL (the way to
/// ground is taken, or there is none now: try again later).
status_t router_send_stored(void* context, uint8_t virtual_channel, const uint8_t* packet, size_t size);
status_t router_send_time(void* context, const uint8_t* packet, size_t size);
/// True if a request to `apid` would find room in its mailbox now; the supervisor itself always has.
bool router_has_room(const supervisor_t* supervisor, uint16_t apid);
/// Route a request that a service on board has released, as one that came from its source.
void router_route_released(supervisor_t* supervisor, const uint8_t* packet, size_t size);
/// Order to a subsystem of the mission: TC[129,1]. Where its mailbox has no room the order is owed, until
/// another one takes its place or its process dies. Statuses of pus_tc_send.
status_t order_state(supervisor_t* supervisor, uint16_t apid, state_t target);
/// Give the orders that are owed, as far as there is room now.
void order_owed(supervisor_t* supervisor);
/// Order to a subsystem: TC[129,3].
status_t order_configuration(supervisor_t* supervisor, uint16_t apid, uint16_t configuration);

/// Route a request that came in parts and is whole now, from the user that sent them. STATUS_OK, STATUS_FULL
/// (no room in the mailbox of its addressee: try again later).
status_t router_route_whole(supervisor_t* supervisor, const uint8_t* packet, size_t size);

/// ground_link.c
/// Send on what waits for the ground.
void ground_flush(supervisor_t* supervisor);
/// Carry a report of a subsystem to the ground: it leaves, or waits, in `block` if it lies in one; else it is
/// dropped and counted.
void ground_send(supervisor_t* supervisor, uint16_t apid, const uint8_t* packet, size_t size, uint8_t* block);
/// True if a report of the class would leave or wait, or if nobody is there to wait for.
bool ground_accepts(const supervisor_t* supervisor, pus_class_t class, size_t size);
/// True if reports wait, or the next one would have to.
bool ground_is_waiting(const supervisor_t* supervisor);
/// True if requests of the ground may be taken in: what answers them has room.
bool ground_takes_requests(const supervisor_t* supervisor);
/// What waits for the ground, for the next life of the supervisor, and back.
void ground_keep(supervisor_t* supervisor);
void ground_resume(supervisor_t* supervisor);
/// Raise GROUND_BEHIND, once for each time the ground falls behind.
void ground_tell(supervisor_t* supervisor);
/// Bring the published state of the way to ground up to date.
void ground_update(supervisor_t* supervisor);

/// roster.c
roster_entry_t* roster_find(supervisor_t* supervisor, uint16_t apid);
void roster_init(supervisor_t* supervisor);
/// True if its process runs and, where it was started again, has been heard since: nobody is told anything in
/// a life before that.
bool roster_is_there(const roster_entry_t* entry);
/// Order a new life of its process. Statuses of supervisor_platform_t.start.
status_t roster_start(supervisor_t* supervisor, roster_entry_t* entry);
/// Keep up with a report that passed.
void roster_report(supervisor_t* supervisor, const pus_tm_t* tm);
/// End every request that a subsystem which is gone still owed an answer to.
void roster_end_pending(supervisor_t* supervisor, uint16_t apid);
/// End every request whose addressee lives and has not even accepted it.
void roster_end_unanswered(supervisor_t* supervisor);
/// Look after processes and heartbeats; once per tick.
void roster_watch(supervisor_t* supervisor);
/// Electrical power [W] of all subsystems, with one of them in another state.
uint32_t roster_power_w(const supervisor_t* supervisor, uint16_t apid, state_t state);

/// adoption.c: what the next supervisor takes over: at the beginning of a step, when all that has come lies
/// in the inboxes, and at its end. One that dies between the two is followed by one that does the step again.
void adoption_intake(supervisor_t* supervisor);
void adoption_commit(supervisor_t* supervisor);
/// Take over what the one before has left, if there was one; before the packet log is opened.
void adoption_begin(supervisor_t* supervisor);
/// In the first step, when what had come to the one before is done: what was not kept, and what is asked.
void adoption_tell(supervisor_t* supervisor);
/// A member tells its state itself: what was taken over is compared once.
void adoption_compare(supervisor_t* supervisor, roster_entry_t* entry, uint8_t state, uint16_t configuration);

/// doubt.c
/// True if a subsystem may be in another state than is known: its state is no ground for a verdict.
bool doubt_is_about(const roster_entry_t* entry);
/// Ask those anew that are heard again after silence; once per tick.
void doubt_watch(supervisor_t* supervisor);
/// Believe a subsystem that has answered.
void doubt_verification(supervisor_t* supervisor, const pus_tm_t* tm, const pus_verification_t* verification);

/// permission.c: PUS_FAILURE_NONE or why the request may not pass.
pus_failure_t permission_of(supervisor_t* supervisor, const pus_tc_t* tc);

/// link_manager.c
pus_rtlink_port_t link_manager_port(supervisor_t* supervisor);
void link_manager_report(supervisor_t* supervisor, const pus_tm_t* tm);
/// Order the other ends of links of which one has closed to close, too; when all reports have been taken in.
void link_manager_settle(supervisor_t* supervisor);
void link_manager_watch(supervisor_t* supervisor);
/// Next step to open a link again as it was asked for last, in the supervisor's own name: negotiate, then
/// open. True if a step was begun.
bool link_manager_renew(supervisor_t* supervisor, uint16_t link);
/// Every edge of a member that is gone: remove it and close the other end.
void link_manager_member_lost(supervisor_t* supervisor, uint16_t apid);

/// error_handling.c
/// React to an event of a member, by its report or by the notice that takes its place while the report is
/// disabled.
void error_event(supervisor_t* supervisor, const pus_event_occurrence_t* event);
/// Note an event of the supervisor itself, told by `tm`; error_own_events reacts. It is called while the
/// report is being sent, when no other may be built.
void error_own_event(supervisor_t* supervisor, const pus_tm_t* tm, const pus_event_occurrence_t* event);
void error_own_events(supervisor_t* supervisor);
/// The process of a member died, as PROCESS_LOST or PROCESS_HUNG tells; its links are still in the graph.
void error_member_lost(supervisor_t* supervisor, uint16_t apid, uint16_t event_id);
/// A member has not been heard for too long.
void error_member_silent(supervisor_t* supervisor, uint16_t apid);
void error_run_plans(supervisor_t* supervisor);
void error_set_mode(supervisor_t* supervisor, uint8_t mode, uint8_t cause);
/// Raise an event of the supervisor with up to two u16 of auxiliary data.
void raise_u16(supervisor_t* supervisor, uint16_t event_id, uint16_t first);
void raise_u16_u16(supervisor_t* supervisor, uint16_t event_id, uint16_t first, uint16_t second);

/// sequences.c
void sequence_autostart(supervisor_t* supervisor);
void sequence_shutdown_begin(supervisor_t* supervisor, const pus_token_t* token);
void sequence_shutdown(supervisor_t* supervisor);
/// True once the shutdown has ordered everybody to OFFLINE.
bool sequence_is_ending(const supervisor_t* supervisor);

/// mission_service.c
pus_mission_port_t mission_service_port(supervisor_t* supervisor);

#endif // FSW_SUPERVISOR_SUPERVISOR_INTERNAL_H
