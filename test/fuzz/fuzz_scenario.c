// SPDX-License-Identifier: Apache-2.0
// Hand, faults and operator read a scenario file. The file is either refused with file and line, or performed
// for two seconds, in which the torques of the hand stay finite.
#include "sim/app/faults.h"
#include "sim/operator/hand.h"
#include "sim/operator/scenario.h"
#include "sim/operator/scene.h"
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
    const double position[HAND_AXES] = {0.1, -0.1};
    const double velocity[HAND_AXES] = {0.0, 0.0};
    double torque[HAND_AXES];
    for (uint64_t i = 0U; i < STEPS; i++) {
        hand_step(hand, i * STEP_NS);
        hand_torque(hand, position, velocity, torque);
        FUZZ_CHECK(isfinite(torque[0]) && isfinite(torque[1]) && (hand_intent(hand)->verb != NULL));
    }
}

static scene_t scene;
static hand_parameters_t grip;
static drive_t* drive; // The scenarios name this drive; the target does not use it.
static fault_world_t targets;

static void begin(void)
{
    static world_t world;
    char error[DOCUMENT_ERROR_MAX];
    char sheet[EDS_ERROR_MAX];
    const bus_config_t config   = {.nominal_bit_rate = 1000000U, .seed = 1U};
    const drive_config_t wanted = {.step_ns = 500000U, .substep_ns = 125000U};
    FUZZ_CHECK(world_read("descriptors/worlds/rokviss.xml", &world, error) == STATUS_OK);
    FUZZ_CHECK(scene_of(&world, &scene, error) == STATUS_OK);
    grip = hand_parameters_of(&world.hand[0]);
    FUZZ_CHECK(drive_create(bus_create(&config), "descriptors/devices/joint-drive.eds", 0x11U, &wanted,
                            &drive, sheet) == STATUS_OK);
    targets = (fault_world_t){
        .channel = {{{.name = "robot"}, {.name = "robot-b"}}, {{.name = "joystick"}, {.name = "joystick-b"}}},
        .device  = {{.name = "JOINT1", .id = 0x11U, .drive = drive},
                    {.name = "JOINT2", .id = 0x12U, .drive = drive},
                    {.name = "STICK", .bus = 1U, .id = 0x21U}},
        .device_count = 3U};
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    static faults_t faults;
    char error[SCENARIO_ERROR_MAX];
    uint64_t latest_ns = 0U;
    if (drive == NULL) {
        begin();
    }
    const char* const path = fuzz_file(data, size);
    status_t status        = scenario_read(path, "operator", take, &latest_ns, error);
    check_error(status, path, error);
    status = faults_load(&faults, &targets, path, error);
    check_error(status, path, error);
    const fault_t* const fault = faults.record;
    for (size_t i = 0U; (status == STATUS_OK) && (i < faults.count); i++) {
        FUZZ_CHECK((fault[i].kind < FAULT_KIND_COUNT) && (fault[i].bus < FAULT_BUSES_MAX));
        FUZZ_CHECK(isfinite(fault[i].value));
    }
    faults_free(&faults);
    hand_t* hand = NULL;
    status       = hand_load(&grip, &scene, path, &hand, error);
    check_error(status, path, error);
    FUZZ_CHECK((status == STATUS_OK) == (hand != NULL));
    if (status == STATUS_OK) {
        play(hand);
    }
    hand_destroy(hand);
    return 0;
}
