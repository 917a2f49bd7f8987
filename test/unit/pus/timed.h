// SPDX-License-Identifier: Apache-2.0
/// A time schedule under test (ST[11]), and the requests that its tests send.
#ifndef TEST_UNIT_PUS_TIMED_H
#define TEST_UNIT_PUS_TIMED_H

#include "pus/st11_time_schedule.h"

#define MS 1000000ULL
#define S 1000000000ULL
#define SS 5U // Sub-schedule of the tests that need one,
#define G 40U // and group.

typedef struct {
    pus_time_schedule_t schedule;
    pus_schedule_config_t config;
    uint8_t data[PUS_TC_DATA_MAX]; ///< Application data of the next request,
    octet_writer_t writer;         ///< as written since timed_begin.
} timed_t;

extern timed_t timed;

/// A bench, and an empty schedule of 600 activities without persistence.
void timed_set_up(void);
/// Begin anew with the configuration as it is.
void timed_start(void);
/// An empty schedule of lasting records.
void timed_start_with_records(void);
/// The power goes and comes back: a schedule with what the records hold.
void timed_restart(void);

void timed_begin(void);
/// Send what was written since timed_begin.
status_t timed_request(uint8_t subtype);
/// The same, and expect that it ends well without a report of its own.
void timed_expect_done(uint8_t subtype);
/// The same without application data.
void timed_command(uint8_t subtype);
/// Send N x {u8}.
void timed_command_ids(uint8_t subtype, unsigned count, const uint8_t* ids);
void timed_create_group(uint8_t group, uint8_t status);
/// Everything enabled: group G and sub-schedule SS, which exists by an activity that is gone again.
void timed_enable_all(void);

/// TC[11,4] with `count` activities, each by timed_add.
void timed_begin_insert(uint8_t sub_schedule, unsigned count);
void timed_add(uint8_t group, uint64_t time_ns, uint16_t sequence, size_t size);
/// Insert one activity with a request without data.
void timed_insert(uint8_t sub_schedule, uint8_t group, uint64_t time_ns, uint16_t sequence);
/// Ten activities: sequence count i at 2 + i s, in sub-schedule i % 2 and group G + i % 3.
void timed_insert_ten(void);

/// Begin N x {identifier}, each by timed_write_id.
void timed_begin_ids(unsigned count);
void timed_write_id(uint16_t sequence);
void timed_write_time(uint64_t time_ns);
void timed_write_offset(int64_t milliseconds);
/// Type of a window, and the tags that it has.
void timed_write_window(uint8_t type, uint64_t from_ns, uint64_t to_ns);
/// A filter that selects all.
void timed_write_filter_all(void);

/// The schedule holds exactly these sequence counts, ended by -1, in this order: seen by a summary of all.
void timed_expect_schedule(const int* sequences);
#define EXPECT_SCHEDULE(...) timed_expect_schedule((const int[]){__VA_ARGS__, -1})
void timed_expect_empty(void);

#endif // TEST_UNIT_PUS_TIMED_H
