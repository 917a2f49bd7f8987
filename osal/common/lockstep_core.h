// SPDX-License-Identifier: Apache-2.0
/// Private to the source files of the scheduler. lockstep_core.c changes the state and never waits;
/// lockstep_scheduler.c calls its functions under the lock. lockstep_port.c of each port waits and wakes.
#ifndef OSAL_COMMON_LOCKSTEP_CORE_H
#define OSAL_COMMON_LOCKSTEP_CORE_H

#include "osal/include/osal/lockstep_scheduler.h"
#include "osal/include/osal/mutex.h"

#define LOCKSTEP_MAGIC 0x6C6F636B73746570ULL // "lockstep" in ASCII.
#define NO_PARTICIPANT UINT32_MAX
#define PARTICIPANTS OSAL_LOCKSTEP_PARTICIPANTS_MAX

typedef struct {
    uint32_t word;        ///< Changes when the participant must check its state.
    uint32_t state;       ///< osal_lockstep_presence_t.
    uint64_t wake_ns;     ///< The earlier of the requested wake time and that of deliveries.
    uint32_t messages;    ///< Deliveries not yet reported.
    uint32_t octets;      ///< Octets on the stream not yet reported.
    uint32_t incarnation; ///< Changes with each join and end; a wait that began with an older value returns.
    bool is_new;          ///< Has joined, but has no position in the order of the present instant yet.
    uint32_t stream_port;
    uint32_t stream_server; ///< Participant that serves the stream, from 1; 0: no participant does.
    int32_t process;        ///< Process that joined last with the number of a life.
    uint32_t life;
    uint64_t begin_ns;      ///< Simulated time at which the life begins; no grant before.
    bool is_begun;          ///< The life has had a grant.
    bool is_failed;         ///< The process died before the life began: the life ends at `begin_ns`.
    bool is_suspended;      ///< The participant gets no grant.
    uint32_t killed_life;   ///< The last life that was killed.
    uint64_t succession_ns; ///< Delay from the end of a life to the start of the next; 0: no next life.
} participant_t;

struct osal_lockstep {
    uint64_t magic;
    uint64_t step_ns;
    uint64_t now_ns;
    /// Holder of the grant, or NO_PARTICIPANT. A write to it commits a hand-over of the grant.
    uint32_t running;
    /// Last holder: at the present instant, only participants with a higher order still have their turn.
    uint32_t last;
    uint32_t is_closed;
    uint32_t is_shared;
    uint32_t leaving;    ///< Participant whose life is being ended, or NO_PARTICIPANT.
    uint32_t left_life;  ///< The life that `leaving` ends.
    uint32_t grants;     ///< Number of grants so far [wraps].
    uint32_t awaited;    ///< Expected participant for which time stands still, or NO_PARTICIPANT.
    uint64_t timeout_ns; ///< A stopped process may block others for this long (osal_lockstep_set_timeout).
    uint32_t is_held;    ///< Simulated time stands still (osal_lockstep_hold).
    uint32_t is_lossy;   ///< The run has lost a message (osal_lockstep_is_lossy).
    uint32_t has_new;    ///< 0: no participant is_new.
    uint32_t used;       ///< Participants from this one on have never been expected and have never joined.
    osal_mutex_t mutex;
    participant_t participants[PARTICIPANTS];
};

typedef char lockstep_fits_its_storage[(sizeof(osal_lockstep_t) <= OSAL_LOCKSTEP_OCTETS) ? 1 : -1];

/// Note that a participant is in use; call it before its state changes from ABSENT.
void lockstep_use(osal_lockstep_t* scheduler, uint32_t participant);
uint64_t lockstep_next_step_ns(const osal_lockstep_t* scheduler);
/// True if the turn of `participant` at the present instant is still to come.
bool lockstep_is_turn_to_come(const osal_lockstep_t* scheduler, uint32_t participant);
uint64_t lockstep_earlier(uint64_t a_ns, uint64_t b_ns);
/// Returns the time at which `participant` is to wake, or OSAL_LOCKSTEP_NEVER. While the participant holds
/// the grant, a wake time after now comes from a delivery to itself and is returned; an earlier wake time has
/// led to the present grant and is not returned.
uint64_t lockstep_pending_wake_ns(const osal_lockstep_t* scheduler, uint32_t participant);
/// End the life of a participant: free its grant and its streams, and expect its next life if it has a
/// succession.
void lockstep_leave(osal_lockstep_t* scheduler, uint32_t participant);
/// Complete the end of a life if the process that called lockstep_leave died before it had completed it.
void lockstep_complete_leave(osal_lockstep_t* scheduler);
/// The stream of the participant has ended: remove it and wake the participant.
void lockstep_cut_stream(osal_lockstep_t* scheduler, uint32_t participant);
/// Wake a joined participant: at the present instant if its turn is still to come, else one time step later.
void lockstep_schedule_wake(osal_lockstep_t* scheduler, uint32_t participant);
/// Give the grant to the participant with the smallest (wake time, order). `running` remains NO_PARTICIPANT
/// if there is none, if an expected participant has not joined, or if the run is over.
void lockstep_grant_next(osal_lockstep_t* scheduler);
/// Returns the later of `wake_ns` and the start of the life: deliveries do not bring a grant before it
/// begins.
uint64_t lockstep_not_before_begin(const participant_t* one, uint64_t wake_ns);
/// The turn of a participant is over, or it joins: note the time at which it wants to run again. False: this
/// life has ended, or has lost its grant.
bool lockstep_end_turn(osal_lockstep_t* scheduler, uint32_t participant, uint32_t life, uint64_t wake_ns);
void lockstep_add_saturating(uint32_t* sum, uint32_t more);
/// Fill `out_grant` with the time and the deliveries, and clear the deliveries.
void lockstep_take_grant(osal_lockstep_t* scheduler, uint32_t participant, osal_grant_t* out_grant);

// ---- Functions of the port (lockstep_port.c), called for a scheduler with is_shared only ----

/// Prepare the lock. False: this system has no lock for it.
bool lockstep_port_prepare(osal_lockstep_t* scheduler);
/// Take the lock, also if its holder has died or was stopped.
void lockstep_port_lock(osal_lockstep_t* scheduler);
void lockstep_port_unlock(osal_lockstep_t* scheduler);
/// Wait until `word` is not `seen`, or return earlier. No wake is lost between the check and the wait.
void lockstep_port_wait(uint32_t* word, uint32_t seen);
/// Wake all that wait for `word`, after its change.
void lockstep_port_wake(uint32_t* word);
/// Number of the process of the caller, which may be killed if a signal stops it inside a call of the
/// scheduler; 0: none.
int32_t lockstep_port_process(void);
/// The life of the caller was killed: it does nothing more, as if the system had killed it at once.
void lockstep_port_end(void);

#endif // OSAL_COMMON_LOCKSTEP_CORE_H
