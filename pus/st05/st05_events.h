// SPDX-License-Identifier: Apache-2.0
/// ST[05] events: TM 1..4 by severity, TC 5 enable, TC 6 disable, TC 7 and TM 8 list of disabled events. The
/// reports go to all ground users; the process keeps them while the port refuses. The supervisor gets a
/// notice (TM[129,7]) of a disabled event instead, because on-board reactions depend on the event, not on its
/// report.
///
/// Each event has a limiter, which passes `burst` occurrences at once and then one in each interval. A HIGH
/// event passes unless its last report still waits for the port. Suppressed occurrences are counted, and an
/// event {event u16, count u32} reports them, for at most one event in a second. Recovery plans, ST[12] and
/// ST[19] get the events that pass; the reaction of the subsystem itself does not depend on the limiter.
///
/// Ownership  The caller provides definitions and state.
#ifndef PUS_ST05_ST05_EVENTS_H
#define PUS_ST05_ST05_EVENTS_H

#include "pus/core/service.h"

typedef enum {
    PUS_SEVERITY_INFORMATIVE = 1,
    PUS_SEVERITY_LOW         = 2,
    PUS_SEVERITY_MEDIUM      = 3,
    PUS_SEVERITY_HIGH        = 4
} pus_severity_t;

typedef struct {
    uint16_t id;
    uint8_t severity;     ///< pus_severity_t.
    uint8_t burst;        ///< Number of occurrences that pass at once.
    uint16_t aux_size;    ///< Size of the auxiliary data [octets].
    uint16_t interval_ms; ///< After a burst, one occurrence passes in this time; 0: no limit.
} pus_event_definition_t;

typedef struct {
    bool is_disabled;
    uint32_t raised;     ///< Number of occurrences, reported or not [wraps].
    uint32_t suppressed; ///< Private: occurrences that the limiter suppressed and that are not reported yet.
    // Limiter: time at which the mean rate has fallen to one occurrence per interval [ms, wraps].
    uint32_t due_ms;
} pus_event_state_t;

#define PUS_EVENT_BURST 20U        ///< Default of `burst`.
#define PUS_EVENT_INTERVAL_MS 100U ///< Default of `interval_ms`.
/// Shortest time between two reports of suppressed occurrences [ns].
#define PUS_SUPPRESSED_REPORT_NS 1000000000ULL
/// Auxiliary data of the event that reports suppressed occurrences: event u16, count u32.
#define PUS_SUPPRESSED_AUX 6U

typedef struct { // Private, except `counters`: read-only, for telemetry.
    pus_app_process_t* process;
    const pus_event_definition_t* definitions;
    pus_event_state_t* states;
    uint16_t count;
    uint16_t last_reported; // Index of the event whose suppressed occurrences were reported last.
    uint16_t unreported;    // Events with suppressed occurrences that were not reported yet.
    uint16_t reporter_id;   // Event that reports suppressed occurrences; 0: none.
    uint64_t next_report_ns;
    struct {
        uint32_t suppressed; ///< Occurrences that the limiter did not let pass.
        uint32_t reported;   ///< TM[5,1..4] sent or kept.
        uint32_t disabled;   ///< TM[129,7] sent or kept for a disabled event.
        uint32_t refused;    ///< Events refused: unknown id, wrong auxiliary data, or no room.
    } counters;
} pus_events_t;

/// `states` has `count` entries like `definitions`; all are enabled and cleared. Ids are unique.
void pus_events_init(pus_events_t* events, pus_app_process_t* process,
                     const pus_event_definition_t* definitions, pus_event_state_t* states, uint16_t count);
pus_service_t pus_events_service(pus_events_t* events);
/// Set the event that reports suppressed occurrences; its auxiliary data have PUS_SUPPRESSED_AUX octets. 0:
/// none.
void pus_events_report_suppressed_by(pus_events_t* events, uint16_t event_id);
/// Report suppressed occurrences of one event, at most once in a second; to be called once per step. True if
/// more must be reported later.
bool pus_events_step(pus_events_t* events, uint64_t now_ns);
/// Raise an event. STATUS_OK (reported; or disabled, with a notice; or suppressed and counted),
/// STATUS_NOT_FOUND, STATUS_INVALID (auxiliary data of another size), STATUS_EXHAUSTED (there was no room to
/// report it; counted).
status_t pus_event_raise(pus_events_t* events, uint16_t event_id, const uint8_t* aux, size_t aux_size,
                         uint64_t now_ns);

/// An event, decoded from a report or a notice.
typedef struct {
    uint16_t apid;
    uint16_t event;
    uint8_t severity; ///< pus_severity_t.
} pus_event_occurrence_t;

/// Read the event from a TM[5,1..4] or a TM[129,7]. STATUS_OK, STATUS_NOT_FOUND (another message),
/// STATUS_INVALID (octets missing or left over, severity unknown).
MUST_USE status_t pus_event_occurrence_read(const pus_tm_t* tm, pus_event_occurrence_t* out_occurrence);

#endif // PUS_ST05_ST05_EVENTS_H
