// SPDX-License-Identifier: Apache-2.0
// Linked to the program of a subsystem for a board: counts the instructions of each step of the executive's
// loop, from the intake of messages to the beat, by the states before and after the step. At the end of
// the program it prints
//     STEP <state before> <state after> <steps> <median> <99th percentile> <longest>     [instructions]
//     STACK <task> <octets> <octets used>
// The emulator runs with -icount shift=5: one instruction takes 32 ns.
#include "fsw/framework/subsystem/subsystem_core.h"
#include "fsw/programs/component_runtime.h"
#include "osal/freertos/port.h"
#include "osal/include/osal/clock.h"
#include "test/support/board/numbers.h"

#include <string.h>

#define INSTRUCTION_NS 32U
#define BIN 32U ///< Instructions of one bin of a histogram.
#define BINS 8192U
#define ROWS_MAX 48U

typedef struct {
    uint8_t before;
    uint8_t after;
    uint32_t count;
    uint32_t longest;
    uint32_t bins[BINS]; ///< Number of steps in each bin; the last bin also has all longer steps.
} row_t;

static row_t rows[ROWS_MAX];
static size_t row_count;
static uint64_t begin_ns;
static bool is_in_step;
static state_t before; ///< State after the last step, because a received request may change it before a step.
static state_t after;

void __real_component_runtime_pump(component_runtime_t* runtime, uint32_t messages,
                                   void (*link_datagram)(void* context, const uint8_t*, size_t),
                                   void* context);
void __wrap_component_runtime_pump(component_runtime_t* runtime, uint32_t messages,
                                   void (*link_datagram)(void* context, const uint8_t*, size_t),
                                   void* context);
uint64_t __real_subsystem_step(subsystem_t* subsystem, uint64_t now_ns);
uint64_t __wrap_subsystem_step(subsystem_t* subsystem, uint64_t now_ns);
void __real_run_state_beat(run_state_t* block, unsigned component, uint64_t now_ns, uint64_t wake_ns);
void __wrap_run_state_beat(run_state_t* block, unsigned component, uint64_t now_ns, uint64_t wake_ns);
void __real_port_exit(int code) __attribute__((noreturn));
void __wrap_port_exit(int code) __attribute__((noreturn));

static row_t* row_of(const state_t from, const state_t to)
{
    size_t i = 0U;
    while ((i < row_count) && ((rows[i].before != (uint8_t)from) || (rows[i].after != (uint8_t)to))) {
        i++;
    }
    if ((i == row_count) && (row_count < ROWS_MAX)) {
        rows[i].before = (uint8_t)from;
        rows[i].after  = (uint8_t)to;
        row_count++;
    }
    return (i < ROWS_MAX) ? &rows[i] : &rows[ROWS_MAX - 1U];
}

static void note(const uint32_t instructions)
{
    row_t* const row   = row_of(before, after);
    const uint32_t bin = instructions / BIN;
    row->count++;
    row->longest = (instructions > row->longest) ? instructions : row->longest;
    row->bins[(bin < BINS) ? bin : (BINS - 1U)]++;
}

void __wrap_component_runtime_pump(component_runtime_t* const runtime, const uint32_t messages,
                                   void (*const link_datagram)(void* context, const uint8_t*, size_t),
                                   void* const context)
{
    begin_ns   = osal_clock_monotonic_ns();
    is_in_step = true;
    __real_component_runtime_pump(runtime, messages, link_datagram, context);
}

uint64_t __wrap_subsystem_step(subsystem_t* const subsystem, const uint64_t now_ns)
{
    const uint64_t wake_ns = __real_subsystem_step(subsystem, now_ns);
    after                  = subsystem->machine.state;
    return wake_ns;
}

void __wrap_run_state_beat(run_state_t* const block, const unsigned component, const uint64_t now_ns,
                           const uint64_t wake_ns)
{
    __real_run_state_beat(block, component, now_ns, wake_ns);
    if (is_in_step) { // The first beat comes before the first step and is not counted.
        note((uint32_t)((osal_clock_monotonic_ns() - begin_ns) / INSTRUCTION_NS));
        is_in_step = false;
        before     = after;
    }
}

/// Returns a number of instructions (the upper end of a bin) that this share [percent] of the steps do not
/// exceed.
static uint32_t quantile(const row_t* const row, const uint32_t percent)
{
    uint64_t sum   = 0U;
    uint64_t total = 0U;
    for (size_t i = 0U; i < BINS; i++) {
        total += row->bins[i];
    }
    for (size_t i = 0U; i < BINS; i++) {
        sum += row->bins[i];
        if ((100U * sum) >= (percent * total)) {
            const uint32_t end = (uint32_t)(i + 1U) * BIN;
            return (end < row->longest) ? end : row->longest;
        }
    }
    return row->longest;
}

void __wrap_port_exit(const int code)
{
    port_stack_t stacks[PORT_STACKS_MAX];
    // The use of the stacks is printed only after a normal end.
    const size_t stack_count = (code == 0) ? port_stacks(stacks) : 0U;
    for (size_t i = 0U; i < row_count; i++) {
        const row_t* const row   = &rows[i];
        const uint32_t numbers[] = {row->before,        row->after,         row->count,
                                    quantile(row, 50U), quantile(row, 99U), row->longest};
        print_numbers("STEP", "", numbers, sizeof numbers / sizeof numbers[0]);
    }
    for (size_t i = 0U; i < stack_count; i++) {
        const uint32_t numbers[] = {(uint32_t)stacks[i].size, (uint32_t)stacks[i].used};
        print_numbers("STACK ", stacks[i].name, numbers, 2U);
    }
    __real_port_exit(code);
}
