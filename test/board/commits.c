// SPDX-License-Identifier: Apache-2.0
// Linked to the program of the manipulator for a board: instead of a flight, it keeps records on the EEPROM,
// each as the service of a telecommand does: put and commit, with the capacities of the program. The table
// of records is filled, and then records are replaced until a compaction of the journal is complete, and a
// few more after it. It prints the longest request without a part of the compaction, and the longest one with
// a part:
//     COMMIT <octets of a record> <compacts: 0, 1> <instructions> <pages> <octets on the bus>
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
#define RECORD 64U    ///< Octets of each record, about those of a monitoring definition.
#define AFTERWARDS 8U ///< Requests after the compaction.
#define LINE_MAX 128U

typedef struct {
    uint64_t instructions;
    uint32_t pages;
    uint32_t octets; ///< Octets on the bus, with those of addresses.
} work_t;

static component_runtime_t runtime;
static run_state_t run;
static record_store_t store;
static journal_slot_t slots[JOURNAL_SLOTS(SUBSYSTEM_HOST_RECORDS)];
static uint8_t record[RECORD];
static work_t done;       // Since the request began.
static work_t longest[2]; // The longest request without a part of a compaction, and with one.

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
        osal_console_complain(status_text(status));
        port_exit(1);
    }
}

/// Keep a record as the dispatcher does for a telecommand.
static void keep(const uint32_t key)
{
    const bool was_moving   = store.journal.is_moving;
    const uint64_t begin_ns = osal_clock_monotonic_ns();
    done                    = (work_t){0};
    record[0]++;
    must(journal_put(&store.journal, TABLE, key, record, RECORD));
    must(journal_commit(&store.journal));
    done.instructions  = (osal_clock_monotonic_ns() - begin_ns) / INSTRUCTION_NS;
    work_t* const most = &longest[(was_moving || store.journal.is_moving) ? 1U : 0U];
    *most              = (done.instructions > most->instructions) ? done : *most;
}

static void print(void)
{
    for (unsigned i = 0U; i < 2U; i++) {
        const uint64_t numbers[] = {RECORD, i, longest[i].instructions, longest[i].pages, longest[i].octets};
        char line[LINE_MAX];
        text_t text = text_in(line, sizeof line);
        text_add(&text, "COMMIT");
        for (size_t j = 0U; j < (sizeof numbers / sizeof numbers[0]); j++) {
            text_add(&text, " ");
            text_add_unsigned(&text, numbers[j]);
        }
        osal_console_say(line);
    }
}

static void measure(void)
{
    for (uint32_t key = 0U; key < SUBSYSTEM_HOST_RECORDS; key++) {
        keep(key);
    }
    uint32_t next = 0U;
    for (; store.journal.stats.compactions == 0U; next++) {
        keep(next % SUBSYSTEM_HOST_RECORDS);
    }
    for (uint32_t i = 0U; i < AFTERWARDS; i++) {
        keep((next + i) % SUBSYSTEM_HOST_RECORDS);
    }
    print();
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
