// SPDX-License-Identifier: Apache-2.0
/// The calendar of stepped time: grants the processor to one participant at a time, at the simulated time
/// each asked for, in participant order within one instant. Nothing runs outside its grant.
///
/// Time stands in slots of `slot_ns`; a participant asks for its next wake time when it is done. A delivery
/// (osal_calendar_deliver) wakes the receiver in the current slot if its turn is still to come (its order is
/// higher than the running one's), else at the start of the next slot. The number of deliveries since its
/// last grant tells a participant exactly how much to take in before it runs.
///
/// The storage is plain memory: in shared memory with one process per participant (futex hand-off), or inside
/// one program that calls osal_calendar_next in a loop (image form). Both give the same sequence of grants.
///
/// A participant has lives: each start of its process is a new one, with a number of its own. A life is
/// EXPECTED from an instant on (time does not reach that instant before it has joined), JOINED, and then
/// ended. Start, stop and death are operations of the calendar, so that they happen at a defined simulated
/// time; the processes behind them follow in wall-clock time. What is said in the name of an ended life
/// changes nothing.
#ifndef OSAL_CALENDAR_H
#define OSAL_CALENDAR_H

#include "fsw/framework/base/capacities.h"
#include "fsw/framework/base/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OSAL_CALENDAR_PARTICIPANTS_MAX CAPACITY_PARTICIPANTS
#define OSAL_CALENDAR_NEVER UINT64_MAX ///< "Wake me only for a delivery."
#define OSAL_CALENDAR_ANY_LIFE 0U      ///< As a life: whichever the participant has. Lives are 1, 2, ...
#define OSAL_CALENDAR_BYTES 4096U      ///< Storage of one calendar.

typedef struct osal_calendar osal_calendar_t;

typedef enum {
    OSAL_CALENDAR_ABSENT = 0, ///< Never there, or its life has ended.
    OSAL_CALENDAR_EXPECTED,
    OSAL_CALENDAR_JOINED
} osal_calendar_presence_t;

typedef struct {
    uint64_t now_ns;   ///< Simulated time of this grant [ns].
    uint32_t messages; ///< Deliveries of whole messages since the last grant.
    uint32_t octets;   ///< Octets delivered on the participant's stream since the last grant.
} osal_grant_t;

/// Make a calendar in `storage` (aligned to 64, OSAL_CALENDAR_BYTES). All participants are ABSENT; time is 0.
/// slot_ns >= 1. `is_shared`: participants live in tasks or processes of their own and use
/// osal_calendar_wait; else one loop uses osal_calendar_next and _done. Null if the system has no lock for
/// it.
osal_calendar_t* osal_calendar_create(void* storage, uint64_t slot_ns, bool is_shared);
/// The calendar in storage that another process made. Null if there is none.
osal_calendar_t* osal_calendar_attach(void* storage);

/// Life `life` of the participant begins at `at_ns`, or now if that is past: it is first granted then, and
/// simulated time does not reach `at_ns` before it has joined by its first wait. Deliveries to that life
/// count from here on. No effect on a participant whose life has not ended.
void osal_calendar_expect(osal_calendar_t* calendar, unsigned participant, uint32_t life, uint64_t at_ns);
/// The process of that life has died; if it held the grant, the grant goes on to the next. A wait of its own
/// returns STATUS_CLOSED. Callable by anybody at any time, and to be called for every process that dies: it
/// may have been killed anywhere, even while it handed the grant over. A life whose first grant is still to
/// come ends at that instant of simulated time. No effect on another life.
void osal_calendar_end(osal_calendar_t* calendar, unsigned participant, uint32_t life);
/// By the holder of the grant: that life gets no further grant from here on. Its wait returns STATUS_CLOSED.
void osal_calendar_dismiss(osal_calendar_t* calendar, unsigned participant, uint32_t life);
/// As dismiss, but the process that waits as that life is killed: it does nothing more.
void osal_calendar_kill(osal_calendar_t* calendar, unsigned participant, uint32_t life);
/// From here on the end of a life of the participant is the start of its next one, whose number is the next
/// and which begins `delay_ns` later: in one operation, so that nobody is granted anything in between.
/// Deliveries that the ended life has not been told of are told to the next. 0: an end is an end again.
void osal_calendar_succeed(osal_calendar_t* calendar, unsigned participant, uint64_t delay_ns);
/// The participant is granted nothing until it is resumed; deliveries and its wake time are kept. If it held
/// the grant, the grant goes on, and what it does later is done as an ended life. No effect on one that is
/// absent.
void osal_calendar_suspend(osal_calendar_t* calendar, unsigned participant);
/// What was due meanwhile wakes it at once.
void osal_calendar_resume(osal_calendar_t* calendar, unsigned participant);
/// End the run: every present and later wait returns STATUS_CLOSED at once.
void osal_calendar_close(osal_calendar_t* calendar);
bool osal_calendar_is_closed(const osal_calendar_t* calendar);

/// Done: give the grant back, ask for `wake_ns` (or earlier by a delivery), block until granted again. A
/// wake time that is not after now means the next slot. The first call joins: the participant takes its place
/// when the present grant ends, in the same instant if its turn is still to come. `life`: its own; one that
/// was not expected joins as OSAL_CALENDAR_ANY_LIFE. Returns STATUS_OK, STATUS_CLOSED.
MUST_USE status_t osal_calendar_wait(osal_calendar_t* calendar, unsigned participant, uint32_t life,
                                     uint64_t wake_ns, osal_grant_t* out_grant);

/// Image form: set the running participant's next wake time (first call joins) without blocking.
void osal_calendar_done(osal_calendar_t* calendar, unsigned participant, uint64_t wake_ns);
/// Image form: choose and grant the next participant. Returns STATUS_OK, STATUS_EMPTY (nobody wants to wake),
/// STATUS_BUSY (this expected participant has not joined), STATUS_CLOSED.
MUST_USE status_t osal_calendar_next(osal_calendar_t* calendar, unsigned* out_participant,
                                     osal_grant_t* out_grant);

/// Tell of a delivery to `receiver` by the running participant `sender`: `messages` whole messages and
/// `octets` on its stream (both counts saturate), meant for that life of it. A receiver that is absent, or in
/// another life, takes no notice.
void osal_calendar_deliver(osal_calendar_t* calendar, unsigned sender, unsigned receiver, uint32_t life,
                           uint32_t messages, uint32_t octets);

uint64_t osal_calendar_now_ns(const osal_calendar_t* calendar);
/// Presence of a participant, and its life: the present or, if it is absent, the last one (0: it had none).
osal_calendar_presence_t osal_calendar_presence(const osal_calendar_t* calendar, unsigned participant,
                                                uint32_t* out_life);
/// True if the participant has joined and not ended.
bool osal_calendar_is_present(const osal_calendar_t* calendar, unsigned participant);
/// The expected participant for which time stands still now (PARTICIPANTS_MAX: none).
unsigned osal_calendar_awaited(const osal_calendar_t* calendar);
/// An expected life begins later: time goes on without it. No effect on another life, or one that has begun.
void osal_calendar_postpone(osal_calendar_t* calendar, unsigned participant, uint32_t life, uint64_t at_ns);
/// For who watches over the hand-over: the holder of the grant (PARTICIPANTS_MAX: nobody) and the number of
/// grants so far [wraps].
unsigned osal_calendar_holder(const osal_calendar_t* calendar, uint32_t* out_grants);

/// The local TCP port of the stream of a participant that joined through the door (0: none).
void osal_calendar_set_stream_port(osal_calendar_t* calendar, unsigned participant, uint16_t port);
uint16_t osal_calendar_stream_port(const osal_calendar_t* calendar, unsigned participant);

#endif // OSAL_CALENDAR_H
