// SPDX-License-Identifier: Apache-2.0
/// The lock-step scheduler grants the processor to one participant at a time, at the simulated time for which
/// the participant asked, in participant order within one instant. A participant runs only during its grant.
///
/// Time advances in time steps of `step_ns`; a participant that ends its turn asks for its next wake time. A
/// delivery (osal_lockstep_deliver) wakes the receiver in the current time step if its order is higher than
/// that of the running participant, else at the start of the next one. Each grant contains the number of
/// deliveries since the last grant.
///
/// The storage is plain memory: shared memory with one process per participant (futex hand-off), or memory of
/// one program that calls osal_lockstep_next in a loop (image form). Both give the same sequence of grants.
///
/// Each start of a participant's process begins a new life with the next number. A life is first EXPECTED: it
/// begins at a given instant, at which simulated time stops until the life has joined. Then it is JOINED, and
/// finally ended. Start, stop and death happen at a defined simulated time; the processes follow in
/// wall-clock time. Calls in the name of an ended life have no effect.
#ifndef OSAL_LOCKSTEP_SCHEDULER_H
#define OSAL_LOCKSTEP_SCHEDULER_H

#include "base/capacities.h"
#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_LOCKSTEP_PARTICIPANTS_MAX CAPACITY_PARTICIPANTS
/// Wake time that means: wake the participant only for a delivery.
#define OSAL_LOCKSTEP_NEVER UINT64_MAX
/// In place of a life: the present life. Lives are numbered 1, 2, ...
#define OSAL_LOCKSTEP_ANY_LIFE 0U
#define OSAL_LOCKSTEP_OCTETS 4096U             ///< Storage of one scheduler.
#define OSAL_LOCKSTEP_TIMEOUT_NS 5000000000ULL ///< Default of osal_lockstep_set_timeout.

typedef struct osal_lockstep osal_lockstep_t;

typedef enum {
    OSAL_LOCKSTEP_ABSENT = 0, ///< The participant had no life yet, or its life has ended.
    /// EXPECTED and JOINED: see the top of this file.
    OSAL_LOCKSTEP_EXPECTED,
    OSAL_LOCKSTEP_JOINED
} osal_lockstep_presence_t;

typedef struct {
    uint64_t now_ns;   ///< Simulated time of this grant [ns].
    uint32_t messages; ///< Deliveries of whole messages since the last grant.
    uint32_t octets;   ///< Octets delivered on the participant's stream since the last grant.
} osal_grant_t;

/// Create a scheduler in `storage` (aligned to 64, OSAL_LOCKSTEP_OCTETS). All participants are ABSENT; time
/// is 0. step_ns >= 1. `is_shared`: participants are tasks or processes and use osal_lockstep_wait; else one
/// loop uses osal_lockstep_next and osal_lockstep_done. Null if the system has no lock for `is_shared`.
osal_lockstep_t* osal_lockstep_create(void* storage, uint64_t step_ns, bool is_shared);
/// A process that a signal stops inside one of these calls blocks the calls of all other processes. If such a
/// process has a life and blocks another one for `timeout_ns` (at least 2) of wall-clock time, it is killed,
/// and its death is treated like any other. A process without a life is not killed. The initial value is
/// OSAL_LOCKSTEP_TIMEOUT_NS.
void osal_lockstep_set_timeout(osal_lockstep_t* scheduler, uint64_t timeout_ns);
/// Returns the scheduler that another process has created in `storage`; null if there is none.
osal_lockstep_t* osal_lockstep_attach(void* storage);

/// Life `life` (>= 1) of the participant begins at `at_ns`, or now if that is past: it gets its first grant
/// then. Simulated time stops at `at_ns` until the life has joined by its first wait. Deliveries to that life
/// count from this call on. No effect on a participant whose life has not ended.
void osal_lockstep_expect(osal_lockstep_t* scheduler, unsigned participant, uint32_t life, uint64_t at_ns);
/// The process of that life has died. If it held the grant, the next participant gets the grant. A wait in
/// that life returns STATUS_CLOSED. Any process may call this at any time. It must be called for every
/// process that dies, because the process may have been killed anywhere, even while it passed the grant on. A
/// life that has not had its first grant yet ends at the simulated time of that grant. No effect on another
/// life.
void osal_lockstep_end(osal_lockstep_t* scheduler, unsigned participant, uint32_t life);
/// Called by the holder of the grant: that life gets no further grant. A wait in that life returns
/// STATUS_CLOSED.
void osal_lockstep_dismiss(osal_lockstep_t* scheduler, unsigned participant, uint32_t life);
/// Like osal_lockstep_dismiss, but the process that waits in that life is killed and does nothing more.
void osal_lockstep_kill(osal_lockstep_t* scheduler, unsigned participant, uint32_t life);
/// From this call on, when a life of the participant ends, its next life begins `delay_ns` later. Both happen
/// in one operation, so no other participant gets a grant in between. The next life gets the deliveries that
/// were not yet reported to the ended one. `delay_ns` 0: no further life begins automatically.
void osal_lockstep_set_succession(osal_lockstep_t* scheduler, unsigned participant, uint64_t delay_ns);
/// The participant gets no grant until it is resumed; its deliveries and its wake time are kept. If it held
/// the grant, the next participant gets the grant, and later calls of the suspended one have no effect, as
/// those of an ended life. No effect on a participant that is absent, or before the instant at which its life
/// begins: whether it has joined by then depends on wall-clock time.
void osal_lockstep_suspend(osal_lockstep_t* scheduler, unsigned participant);
/// End a suspension. A participant that was due in the meantime wakes in the current time step if its turn is
/// still to come, else at the start of the next one.
void osal_lockstep_resume(osal_lockstep_t* scheduler, unsigned participant);
/// End the run: every present and later wait returns STATUS_CLOSED at once.
void osal_lockstep_close(osal_lockstep_t* scheduler);
bool osal_lockstep_is_closed(const osal_lockstep_t* scheduler);

/// End the turn: give the grant back, ask for `wake_ns` (or earlier by a delivery), wait for the next grant.
/// A wake time that is not after now means the next time step. The first call joins: the participant takes
/// part from the end of the present grant on, in the same instant if its turn is still to come. `life`: the
/// life of the caller; a participant that was not expected joins with OSAL_LOCKSTEP_ANY_LIFE. Returns
/// STATUS_OK, STATUS_CLOSED (the run or that life has ended, or the life does not hold the grant).
MUST_USE status_t osal_lockstep_wait(osal_lockstep_t* scheduler, unsigned participant, uint32_t life,
                                     uint64_t wake_ns, osal_grant_t* out_grant);

/// Image form: set the running participant's next wake time (first call joins) without blocking.
void osal_lockstep_done(osal_lockstep_t* scheduler, unsigned participant, uint64_t wake_ns);
/// Image form: choose and grant the next participant. Returns STATUS_OK, STATUS_EMPTY (no participant wants
/// to wake), STATUS_BUSY (*out_participant is expected and has not joined), STATUS_CLOSED (the run has
/// ended).
MUST_USE status_t osal_lockstep_next(osal_lockstep_t* scheduler, unsigned* out_participant,
                                     osal_grant_t* out_grant);

/// Announce a delivery by the running participant `sender` to life `life` of `receiver`: `messages` whole
/// messages, and `octets` on the stream of the receiver (both counts saturate). No effect if the receiver is
/// absent or in another life.
void osal_lockstep_deliver(osal_lockstep_t* scheduler, unsigned sender, unsigned receiver, uint32_t life,
                           uint32_t messages, uint32_t octets);

/// Present simulated time [ns].
uint64_t osal_lockstep_now_ns(const osal_lockstep_t* scheduler);
/// Presence of a participant. *out_life: number of its life, or of its last life if it is absent (0: none).
osal_lockstep_presence_t osal_lockstep_presence(const osal_lockstep_t* scheduler, unsigned participant,
                                                uint32_t* out_life);
/// Returns the time [ns] at which the present life of the participant began or begins; OSAL_LOCKSTEP_NEVER
/// unless it is JOINED.
uint64_t osal_lockstep_begin_ns(osal_lockstep_t* scheduler, unsigned participant);
/// True if the participant has joined and not ended.
bool osal_lockstep_is_present(const osal_lockstep_t* scheduler, unsigned participant);
/// Returns the expected participant for which simulated time is stopped now (OSAL_LOCKSTEP_PARTICIPANTS_MAX:
/// none).
unsigned osal_lockstep_awaited(const osal_lockstep_t* scheduler);
/// Let an expected life begin later, so time continues without it. No effect on another life or a begun one.
void osal_lockstep_postpone(osal_lockstep_t* scheduler, unsigned participant, uint32_t life, uint64_t at_ns);
/// For a watchdog: the holder of the grant (OSAL_LOCKSTEP_PARTICIPANTS_MAX: none) and the number of grants so
/// far [wraps].
unsigned osal_lockstep_holder(osal_lockstep_t* scheduler, uint32_t* out_grants);

/// True: the holder of the grant keeps it, simulated time stands still, and a watchdog must accept that.
/// Initially false. Any process may set it to false; the holder then continues.
void osal_lockstep_hold(osal_lockstep_t* scheduler, bool is_held);
bool osal_lockstep_is_held(const osal_lockstep_t* scheduler);

/// Note that octets or datagrams that were announced to a participant have not arrived, so that the run is
/// not reproducible. Any process may call this at any time.
void osal_lockstep_note_loss(osal_lockstep_t* scheduler);
/// True if a process has noted a loss.
bool osal_lockstep_is_lossy(const osal_lockstep_t* scheduler);

/// Set the local TCP port of the stream of a participant that joined through the co-simulation port (0:
/// none). A new port number means a new stream, which no participant serves yet.
void osal_lockstep_set_stream_port(osal_lockstep_t* scheduler, unsigned participant, uint16_t port);
uint16_t osal_lockstep_stream_port(const osal_lockstep_t* scheduler, unsigned participant);
/// Called by the holder of the grant: `server` serves the stream of the participant until its life ends or
/// the stream is cut. The participant is woken as by a delivery. No effect if the stream has another port.
void osal_lockstep_serve_stream(osal_lockstep_t* scheduler, unsigned participant, uint16_t port,
                                unsigned server);
/// Called by the server of the stream, which holds the grant: the stream has ended. The participant has no
/// stream any more, the octets that were not yet reported to it are lost, and it is woken as by a delivery.
/// The end of the server's life does the same. No effect on a stream of another port.
void osal_lockstep_cut_stream(osal_lockstep_t* scheduler, unsigned participant, uint16_t port);
/// Returns the port of the stream of the participant if a participant serves it; else 0.
uint16_t osal_lockstep_served_port(const osal_lockstep_t* scheduler, unsigned participant);

#endif // OSAL_LOCKSTEP_SCHEDULER_H
