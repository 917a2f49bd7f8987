// SPDX-License-Identifier: Apache-2.0
/// What the tests of schedules and of other services that release requests share: requests to be released,
/// the port that takes them, and room for a schedule.
#ifndef TEST_UNIT_PUS_SCHEDULES_H
#define TEST_UNIT_PUS_SCHEDULES_H

#include "pus/schedule.h"

#define RELEASED_MAX 12000U
#define ACTIVITIES 10000U
#define BLOCKS 20000U
#define RELEASE_APID 17U
#define RELEASE_SOURCE 9U

typedef struct {
    unsigned accepts;  ///< Requests the port takes before it refuses.
    unsigned refusals; ///< Requests it refuses then; after that it takes all.
    size_t count;      ///< Requests taken.
    pus_activity_id_t ids[RELEASED_MAX];
    size_t sizes[RELEASED_MAX];
    size_t lost_count; ///< Calls of `lost`.
    pus_activity_id_t lost[PUS_SCHEDULE_BATCH];
} released_t;

extern released_t released;

/// Forget what was released; the port takes all.
void released_clear(void);
pus_port_t released_port(void);
/// A whole request of `sequence` with `size` octets of data, 0..PUS_TC_DATA_MAX. Returns its size.
size_t request_make(uint16_t sequence, size_t size, uint8_t* out_octets);
/// The same at the end of application data.
void request_write(octet_writer_t* writer, uint16_t sequence, size_t size);
/// Exactly these sequence counts were released since the last clear, ended by -1.
void expect_released(const int* sequences);
#define EXPECT_RELEASED(...) expect_released((const int[]){__VA_ARGS__, -1})

/// Configuration of a schedule of up to ACTIVITIES in static arrays, without persistence.
pus_schedule_config_t schedule_config(uint16_t activities, uint16_t blocks);

#endif // TEST_UNIT_PUS_SCHEDULES_H
