// SPDX-License-Identifier: Apache-2.0
/// Monitoring under test: small tables, events that are noted, and writers of its requests.
#ifndef TEST_UNIT_PUS_MONITORS_H
#define TEST_UNIT_PUS_MONITORS_H

#include "pus/st12_monitoring.h"
#include "test/unit/pus/records.h"
#include "test/unit/pus/reports.h"
#include "test/unit/pus/scalars.h"

#define MONITORS_PMONS 8U
#define MONITORS_FMONS 3U
#define MONITORS_MEMBERS 3U
#define MONITORS_TRANSITIONS 4U
#define MONITORS_DELAY 10U ///< Maximum reporting delay at first [cycles].
#define EVENT_LOW 501U
#define EVENT_HIGH 502U
#define EVENT_UNKNOWN 999U
#define EVENT_OTHER 998U ///< Has auxiliary data of another raiser.

#define LEVEL SCALAR_ID(VALUE_UINT16, 1U) ///< What most PMONs look at.
#define GATE SCALAR_ID(VALUE_UINT8, 2U)   ///< Parameter of validity conditions.

typedef struct {
    pus_monitoring_t service;
    uint32_t cycle; ///< The last.
    struct {
        unsigned count;
        uint16_t id;
        size_t size;
        uint8_t auxiliary[32];
    } events;
    octet_writer_t data; ///< Application data of the next request.
} monitors_t;

extern monitors_t monitors;

/// Begin with nothing: records too.
void monitors_start(void);
/// Begin anew with the records that are lasting.
void monitors_restart(void);
/// One cycle, or several.
void monitors_step(unsigned cycles);

/// Begin application data of `count` instructions, and send it. The reports are those of this request.
void data_begin(unsigned count);
status_t data_send(uint8_t subtype);
/// A request of ids, of one value u32, or without data.
status_t send_ids(uint8_t subtype, unsigned count, uint16_t first);
status_t send_empty(uint8_t subtype);

/// A PMON as in TC[12,5]: no validity condition, interval 1, repetition 1.
void data_limit(uint16_t id, uint32_t parameter, uint64_t low, uint64_t high);
void data_pmon(uint16_t id, uint32_t parameter, uint32_t interval, uint16_t repetition, uint8_t check_type);
/// The criteria behind it.
void data_expected(uint32_t parameter, uint64_t mask, uint64_t expected, uint16_t event);
void data_limits(uint32_t parameter, uint64_t low, uint16_t low_event, uint64_t high, uint16_t high_event);
void data_scalar(uint32_t parameter, uint64_t bits);
/// Add one PMON on `parameter`, enabled, with limits 10..20 and both events.
void limit_added(uint16_t id, uint32_t parameter);

/// Transition `index` of report `report`, which is TM[12,11] or TM[12,12] on UINT16 without masks.
typedef struct {
    uint16_t pmon_id;
    uint32_t parameter_id;
    uint8_t check_type;
    uint16_t value;
    uint16_t limit;
    uint8_t previous;
    uint8_t current;
    uint64_t time_ns;
} transition_t;
transition_t transition_at(size_t report, uint16_t index);
/// Status of a PMON now, as in TM[12,11] by its internals.
uint8_t status_of(uint16_t id);

#endif // TEST_UNIT_PUS_MONITORS_H
