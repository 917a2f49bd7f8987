// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/run_state.h"

#include "base/assertion.h"
#include "base/text.h"
#include "osal/include/osal/lockstep_scheduler.h"

#include <string.h>

// The scheduler has slots for all subsystems, the simulator, the operator and the relay; the run state has
// a slot for each link of the mission.
CAPACITY_CHECK(all_take_part, (MISSION_SUBSYSTEMS_MAX + 3U) <= OSAL_LOCKSTEP_PARTICIPANTS_MAX);
CAPACITY_CHECK(every_link_has_a_route, RUN_LINKS_MAX >= MISSION_LINKS_MAX);
CAPACITY_CHECK(every_computer_has_an_address, RUN_COMPUTERS_MAX >= MISSION_COMPUTERS_MAX);

// Change this number with the structure, so that a program of another build cannot use the run state.
#define MAGIC 0x48524E36U
#define FLOW_FREE 0U
#define FLOW_TAKEN 1U
#define FLOW_NOTED 2U

bool run_name(const run_state_t* const block, const char* const what, const unsigned number,
              char* const out_name, const size_t capacity)
{
    FSW_ASSERT((block != NULL) && (what != NULL));
    text_t text = text_in(out_name, capacity);
    text_add_character(&text, '/');
    text_add(&text, block->identity);
    text_add_character(&text, '.');
    text_add(&text, what);
    if (number > 0U) {
        text_add_unsigned(&text, number);
    }
    return !text.cut;
}

status_t run_state_create(osal_shm_t* const shm, const char* const identity, run_state_t** const out_block)
{
    FSW_ASSERT((shm != NULL) && (identity != NULL) && (out_block != NULL));
    run_state_t named;
    (void)memset(&named, 0, sizeof named);
    text_t text = text_in(named.identity, sizeof named.identity);
    text_add(&text, identity);
    char name[RUN_NAME_MAX];
    FSW_ASSERT(!text.cut && run_name(&named, "run", 0U, name, sizeof name));
    const status_t status = osal_shm_create(shm, name, sizeof(run_state_t));
    if (status != STATUS_OK) {
        return (status == STATUS_INVALID) ? STATUS_IO : status;
    }
    *out_block          = (run_state_t*)osal_shm_address(shm);
    **out_block         = named;
    (*out_block)->magic = MAGIC;
    return STATUS_OK;
}

status_t run_state_attach(osal_shm_t* const shm, const char* const name, run_state_t** const out_block)
{
    FSW_ASSERT((shm != NULL) && (name != NULL) && (out_block != NULL));
    const status_t status = osal_shm_open(shm, name);
    if (status != STATUS_OK) {
        return (status == STATUS_INVALID) ? STATUS_NOT_FOUND : status;
    }
    *out_block = (run_state_t*)osal_shm_address(shm);
    if ((osal_shm_size(shm) < sizeof(run_state_t)) || ((*out_block)->magic != MAGIC)) {
        osal_shm_close(shm);
        return STATUS_INVALID;
    }
    return STATUS_OK;
}

void run_state_beat(run_state_t* const block, const unsigned component, const uint64_t now_ns,
                    const uint64_t wake_ns)
{
    FSW_ASSERT((block != NULL) && (component < MISSION_SUBSYSTEMS_MAX));
    // A reader that reads the new promise also reads its step.
    __atomic_store_n(&block->beats[component].step_ns, now_ns, __ATOMIC_RELAXED);
    __atomic_store_n(&block->beats[component].wake_ns, wake_ns, __ATOMIC_RELEASE);
}

void run_state_wake(run_state_t* const block, const unsigned component, const uint64_t now_ns)
{
    static const uint64_t limits_ns[RUN_LATENESS - 1U] = {100000U, 1000000U, 10000000U, 100000000U};
    FSW_ASSERT((block != NULL) && (component < MISSION_SUBSYSTEMS_MAX));
    run_beat_t* const beat = &block->beats[component];
    if (now_ns < beat->wake_ns) {
        return; // The component was woken by a message before the promised time.
    }
    unsigned class = 0U;
    while ((class < (RUN_LATENESS - 1U)) && ((now_ns - beat->wake_ns) >= limits_ns[class])) {
        class ++;
    }
    beat->late[class]++;
}

run_beat_t run_state_last_beat(const run_state_t* const block, const unsigned component)
{
    FSW_ASSERT((block != NULL) && (component < MISSION_SUBSYSTEMS_MAX));
    const uint64_t wake_ns = __atomic_load_n(&block->beats[component].wake_ns, __ATOMIC_ACQUIRE);
    return (run_beat_t){.step_ns = __atomic_load_n(&block->beats[component].step_ns, __ATOMIC_RELAXED),
                        .wake_ns = wake_ns};
}

bool run_state_find(const run_state_t* const block, const uint16_t apid, unsigned* const out_index)
{
    FSW_ASSERT((block != NULL) && (out_index != NULL));
    for (unsigned i = 0U; i < block->component_count; i++) {
        if (block->components[i].apid == apid) {
            *out_index = i;
            return true;
        }
    }
    return false;
}

status_t run_state_note_flow(run_state_t* const block, const char* const name)
{
    FSW_ASSERT((block != NULL) && (name != NULL));
    if (strlen(name) >= RUN_NAME_MAX) {
        return STATUS_EXHAUSTED;
    }
    for (unsigned i = 0U; i < RUN_FLOWS_MAX; i++) {
        run_flow_t* const flow = &block->flows[i];
        uint32_t state         = __atomic_load_n(&flow->state, __ATOMIC_ACQUIRE);
        if ((state == FLOW_NOTED) && (strcmp(flow->name, name) == 0)) {
            return STATUS_OK;
        }
        // Several components note flows at the same time: the slot is reserved before the name is written.
        if ((state == FLOW_FREE) && __atomic_compare_exchange_n(&flow->state, &state, FLOW_TAKEN, false,
                                                                __ATOMIC_ACQUIRE, __ATOMIC_RELAXED)) {
            (void)memcpy(flow->name, name, strlen(name) + 1U);
            __atomic_store_n(&flow->state, FLOW_NOTED, __ATOMIC_RELEASE);
            return STATUS_OK;
        }
    }
    return STATUS_EXHAUSTED;
}
