// SPDX-License-Identifier: Apache-2.0
// Scenario files, read by the hand, by the faults and for the operator: refused with file and line, or
// played: the hand's torques stay finite for two seconds of any script.
#include "sim/app/faults.h"
#include "sim/operator/hand.h"
#include "sim/operator/scenario.h"
#include "sim/parameters/rokviss.h"
#include "test/fuzz/fuzz.h"

#include <math.h>
#include <string.h>

#define STEPS 40U
#define STEP_NS 50000000U

static status_t take(void* const context, const scenario_line_t* const line, char error[SCENARIO_ERROR_MAX])
{
    uint64_t* const latest_ns = (uint64_t*)context;
    (void)error;
    FUZZ_CHECK((line->word_count >= 1U) && (line->word_count <= SCENARIO_WORDS_MAX) && (line->line >= 1U));
    FUZZ_CHECK(line->time_ns >= *latest_ns);
    for (size_t i = 0U; i < line->word_count; i++) {
        FUZZ_CHECK((line->word[i] >= line->text) && (line->word[i] < &line->text[SCENARIO_LINE_MAX]));
    }
    *latest_ns = line->time_ns;
    return STATUS_OK;
}

static void check_error(const status_t status, const char* const path, const char* const error)
{
    if (status != STATUS_OK) {
        FUZZ_CHECK(strncmp(error, path, strlen(path)) == 0);
        FUZZ_CHECK(memchr(error, '\0', SCENARIO_ERROR_MAX) != NULL);
    }
}

static void play(hand_t* const hand)
{
    const double position[PLANT_AXES] = {0.1, -0.1};
    const double velocity[PLANT_AXES] = {0.0, 0.0};
    double torque[PLANT_AXES];
    for (uint64_t i = 0U; i < STEPS; i++) {
        hand_step(hand, i * STEP_NS);
        hand_torque(hand, position, velocity, torque);
        FUZZ_CHECK(isfinite(torque[0]) && isfinite(torque[1]) && (hand_intent(hand)->verb != NULL));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    static faults_t faults;
    char error[SCENARIO_ERROR_MAX];
    uint64_t latest_ns     = 0U;
    const char* const path = fuzz_file(data, size);
    status_t status        = scenario_read(path, "operator", take, &latest_ns, error);
    check_error(status, path, error);
    status = faults_load(&faults, path, error);
    check_error(status, path, error);
    FUZZ_CHECK(faults.count <= FAULTS_MAX);
    for (size_t i = 0U; (status == STATUS_OK) && (i < faults.count); i++) {
        FUZZ_CHECK((faults.fault[i].kind < FAULT_KIND_COUNT) && (faults.fault[i].bus < FAULT_BUSES));
        FUZZ_CHECK(isfinite(faults.fault[i].value));
    }
    hand_t* hand = NULL;
    status       = hand_load(&rokviss_hand, &rokviss_plant, path, &hand, error);
    check_error(status, path, error);
    FUZZ_CHECK((status == STATUS_OK) == (hand != NULL));
    if (status == STATUS_OK) {
        play(hand);
    }
    hand_destroy(hand);
    return 0;
}
