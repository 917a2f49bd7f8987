// SPDX-License-Identifier: Apache-2.0
/// Two packet stores on recorded media, reports that are shown to them, and what they send again.
#ifndef TEST_UNIT_PUS_STORES_H
#define TEST_UNIT_PUS_STORES_H

#include "pus/st15_storage.h"
#include "test/support/recorded_media.h"
#include "test/unit/pus/records.h"
#include "test/unit/pus/reports.h"

#define STORES 2U
#define STORE_BLOCKS 7U
#define STORE_ENTRIES 10U
#define STORE_CHANNELS 3U
#define REPORT_SIZE 4000U ///< Of a large report; four fill a block.
#define STEP_PACKETS 3U
#define SENT_MAX 128U
#define SIZE(blocks) ((blocks)*PUS_STORE_BLOCK)

typedef struct {
    size_t count;
    unsigned refusals; ///< Packets the port refuses from now on.
    struct {
        uint8_t channel;
        uint16_t sequence; ///< Of the report, by which it is known.
    } packets[SENT_MAX];
} stores_sent_t;

extern pus_storage_t stores_storage;
extern stores_sent_t stores_sent;
/// Configuration of the next start.
extern pus_storage_config_t stores_config;

/// Begin anew: nothing on the media, nothing kept, no store; the bench serves the service.
void stores_begin(void);
/// Add a store of so many blocks that takes everything of TEST_APID.
void stores_add(const char* name, uint16_t blocks, uint8_t type);
/// Start again with what is kept and on the media, and stores of the configuration as stores_add made them.
status_t stores_restart(void);
/// Cut the power: what is not synced or committed is lost. Then start again.
void stores_cut(void);

/// Show report `sequence` (0..255) of `size` octets at this second of the run.
void stores_report(uint16_t sequence, size_t size, unsigned second);
/// The same for several, at the seconds of their numbers.
void stores_reports(uint16_t first, uint16_t last);
/// Step, once or `steps` times, at this second.
void stores_step(unsigned steps, unsigned second);
/// True if a step has nothing to do, now or later.
bool stores_is_idle(void);
/// Since the last look exactly the reports of these numbers were sent again, each as it was.
void expect_stores_sent(uint16_t first, uint16_t last);
void expect_stores_none_sent(void);

/// Parts of requests.
extern octet_writer_t stores_request;
void stores_begin_request(void);
void stores_put_name(const char* name);
/// Time tag: `second` of the run.
void stores_put_second(unsigned second);
/// Send what was put as a request.
status_t stores_send_request(uint8_t subtype);
/// It is performed, or refused with this as a whole or as instruction `instruction`.
void expect_stores_performed(uint8_t subtype);
void expect_stores_refused(uint8_t subtype, uint16_t code, uint16_t instruction, uint32_t detail);
/// A request with a list of one store, or with the store alone.
void stores_request_store(uint8_t subtype, const char* name);
void stores_request_all(uint8_t subtype);

/// Put the request to create a store; stores_create_ring has it performed: three blocks,
/// circular, channel 2.
void stores_create(const char* name, uint32_t size, uint8_t type, uint8_t channel);
void stores_create_ring(void);
/// Source data of the answer `expected` to the request that was put; it must be the only one.
octet_reader_t stores_answer(uint8_t subtype, uint8_t expected);
void expect_stores_name(octet_reader_t* reader, const char* name);
/// TM[15,13] of one store; times in seconds of the run, 0 for none.
void expect_stores_summary(const char* name, unsigned oldest, unsigned newest, unsigned tag, uint8_t filled,
                           uint8_t from_tag);

/// The first four octets of a name, as refusals tell it.
uint32_t stores_name_of(const char* name);

#endif // TEST_UNIT_PUS_STORES_H
