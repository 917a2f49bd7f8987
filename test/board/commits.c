// SPDX-License-Identifier: Apache-2.0
// Linked to the program of the manipulator for a board, which then does not fly but keeps records on the
// EEPROM, by puts and a commit, as the packet services do for a telecommand. It fills the table of records.
// Then it replaces records: one in each request until a compaction of the journal is complete, and a few more
// after it; then all records in each request; then one in each request, with records so large that the log
// reaches the end of its medium. It prints the longest request of each kind:
//     COMMIT <octets of a record> <records of the request> <compaction> <instructions> <pages>
//         <octets on the bus>
// Compaction: 0 none, 1 a part of one, 2 all of one, because a put has found no room.
// `pages`: transfers after which a real EEPROM is busy with a write. The emulated one needs no time for it.
// The emulator runs with -icount shift=5: one instruction takes 32 ns.
#include "base/text.h"
#include "fsw/programs/executive.h"
#include "fsw/programs/subsystem_host.h"
#include "osal/freertos/i2c.h"
#include "osal/freertos/port.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"

#include <string.h>

#define INSTRUCTION_NS 32U
#define TABLE 12U
#define RECORD 64U    ///< Octets of a record, about those of a monitoring definition.
#define LARGE 160U    ///< Octets of a record so large that the log is never twice as long as its records.
#define AFTERWARDS 8U ///< Requests after the compaction.
#define TURNS 8U      ///< Requests that replace all records.
#define LINE_MAX 128U

typedef struct {
    uint64_t instructions;
    uint32_t pages;
    uint32_t octets; ///< Octets on the bus, with those of addresses.
} work_t;

enum {
    WITHOUT,
    PART,
    AT_ONCE,
    COMPACTIONS
};

typedef struct { // The longest requests of one kind, by the compaction.
    uint32_t size;
    uint32_t records;
    work_t longest[COMPACTIONS];
} kind_t;

static component_runtime_t runtime;
static run_state_t run;
static record_store_t store;
static journal_slot_t slots[JOURNAL_SLOTS(SUBSYSTEM_HOST_RECORDS)];
static uint8_t record[LARGE];
static work_t done; // Since the request began.
static kind_t single = {.size = RECORD, .records = 1U};
static kind_t whole  = {.size = RECORD, .records = SUBSYSTEM_HOST_RECORDS};
static kind_t large  = {.size = LARGE, .records = 1U};

status_t __real_i2c_write(uint8_t device, const uint8_t* head, size_t head_size, const uint8_t* octets,
                          size_t size);
status_t __wrap_i2c_write(uint8_t device, const uint8_t* head, size_t head_size, const uint8_t* octets,
                          size_t size);
status_t __real_i2c_read(uint8_t device, const uint8_t* head, size_t head_size, uint8_t* octets, size_t size);
status_t __wrap_i2c_read(uint8_t device, const uint8_t* head, size_t head_size, uint8_t* octets, size_t size);
int __wrap_executive_run(int argument_count, char* const arguments[], const char* executable,
                         component_open_t open, const component_descriptors_t* descriptors);

status_t __wrap_i2c_write(const uint8_t device, const uint8_t* const head, const size_t head_size,
                          const uint8_t* const octets, const size_t size)
{
    done.pages += (size > 0U) ? 1U : 0U;
    done.octets += (uint32_t)(1U + head_size + size);
    return __real_i2c_write(device, head, head_size, octets, size);
}

status_t __wrap_i2c_read(const uint8_t device, const uint8_t* const head, const size_t head_size,
                         uint8_t* const octets, const size_t size)
{
    done.octets += (uint32_t)(2U + head_size + size); // The address of the device is sent twice.
    return __real_i2c_read(device, head, head_size, octets, size);
}

static void must(const status_t status)
{
    if (status != STATUS_OK) {
        osal_console_print_error(status_text(status));
        port_exit(1);
    }
}

/// Keep records as the dispatcher does for a telecommand. Returns the compaction of this request.
static unsigned keep(const uint32_t first_key, kind_t* const kind)
{
    const journal_t* const journal = &store.journal;
    const bool was_moving          = journal->is_moving;
    const uint32_t compactions     = journal->stats.compactions;
    const uint64_t begin_ns        = osal_clock_monotonic_ns();
    done                           = (work_t){0};
    for (uint32_t i = 0U; i < kind->records; i++) {
        record[0]++;
        must(
            journal_put(&store.journal, TABLE, (first_key + i) % SUBSYSTEM_HOST_RECORDS, record, kind->size));
    }
    const bool is_at_once = (journal->stats.compactions != compactions);
    must(journal_commit(&store.journal));
    done.instructions   = (osal_clock_monotonic_ns() - begin_ns) / INSTRUCTION_NS;
    const unsigned with = is_at_once ? AT_ONCE : ((was_moving || journal->is_moving) ? PART : WITHOUT);
    work_t* const most  = &kind->longest[with];
    *most               = (done.instructions > most->instructions) ? done : *most;
    return with;
}

static void print(const kind_t* const kind)
{
    for (unsigned i = 0U; i < COMPACTIONS; i++) {
        const work_t* const one  = &kind->longest[i];
        const uint64_t numbers[] = {kind->size, kind->records, i, one->instructions, one->pages, one->octets};
        char line[LINE_MAX];
        text_t text = text_in(line, sizeof line);
        text_add(&text, "COMMIT");
        for (size_t j = 0U; j < (sizeof numbers / sizeof numbers[0]); j++) {
            text_add(&text, " ");
            text_add_unsigned(&text, numbers[j]);
        }
        if (one->instructions > 0U) {
            osal_console_print_line(line);
        }
    }
}

static void measure(void)
{
    kind_t unmeasured = {.size = LARGE, .records = 1U};
    uint32_t next     = 0U;
    for (; next < SUBSYSTEM_HOST_RECORDS; next++) {
        (void)keep(next, &single);
    }
    for (; store.journal.stats.compactions == 0U; next++) {
        (void)keep(next, &single);
    }
    for (uint32_t i = 0U; i < AFTERWARDS; i++, next++) {
        (void)keep(next, &single);
    }
    for (uint32_t i = 0U; i < TURNS; i++) {
        (void)keep(0U, &whole);
    }
    for (uint32_t i = 0U; i < SUBSYSTEM_HOST_RECORDS; i++) {
        (void)keep(i, &unmeasured);
    }
    for (next = 0U; keep(next, &large) != AT_ONCE; next++) {
    }
    print(&single);
    print(&whole);
    print(&large);
}

int __wrap_executive_run(const int argument_count, char* const arguments[], const char* const executable,
                         const component_open_t open, const component_descriptors_t* const descriptors)
{
    (void)argument_count;
    (void)arguments;
    (void)executable;
    (void)open;
    (void)descriptors;
    (void)strcpy(run.storage, "/eeprom");
    (void)strcpy(run.components[0].name, "MANIPULATOR");
    runtime.run = &run;
    must(record_store_open(&store, &runtime, slots, SUBSYSTEM_HOST_RECORDS, false)); // As in real time.
    measure();
    record_store_close(&store);
    return 0;
}
