// SPDX-License-Identifier: Apache-2.0
/// The relay of a run passes frames from the producers to the consumers of links; it delays, loses and
/// reorders them (sim/relay/relay.h). It is a participant of the scheduler, in its own process or in the
/// image.
///
/// Ownership  The program provides launcher_relay_t.
/// Context    One task.
#ifndef LAUNCHER_LAUNCHER_RELAY_H
#define LAUNCHER_LAUNCHER_RELAY_H

#include "fsw/programs/run_state.h"
#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/socket.h"
#include "sim/relay/relay.h"

#define LAUNCHER_RELAY_JITTER 0.1 ///< Jitter as a share of the delay.
#define LAUNCHER_RELAY_LOSS 0.05  ///< Share of the frames that are lost.
/// The same share for netem, which delays the network between two computers.
#define LAUNCHER_RELAY_LOSS_TEXT "5%"

typedef struct { // Private.
    run_state_t* run;
    osal_lockstep_t* scheduler;
    osal_socket_t sockets[RUN_LINKS_MAX]; // Each receives the frames that the producer of one link sends.
    osal_socket_t sender;
    relay_t relay;
} launcher_relay_t;

/// Take over the sockets of the run's relay; no effect if the run has none. Returns null, or the error text.
const char* launcher_relay_open(launcher_relay_t* self, run_state_t* run, osal_lockstep_t* scheduler);
/// Perform one turn: receive the frames that the producers have announced, and send those that are due when
/// the consumers run next. Returns the time of the next turn [ns of the run].
uint64_t launcher_relay_step(launcher_relay_t* self, const osal_grant_t* grant);
void launcher_relay_close(launcher_relay_t* self);

#endif // LAUNCHER_LAUNCHER_RELAY_H
