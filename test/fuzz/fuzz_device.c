// SPDX-License-Identifier: Apache-2.0
// The simulated joint drive receives arbitrary frames from its bus at any time. It sends only
// frames of at most 8 octets, its torque stays finite, and after a reset it boots again.
//
// Records by kind:
//   0..2  the master sends the frame
//   3     the bus runs for argument x 100 us; then a step of the plant ends
//   4     the drive is unplugged, and plugged in again after 1 ms
#include "sim/devices/drive.h"
#include "test/fuzz/can_records.h"

#include <math.h>
#include <string.h>

#define NODE 0x11U
#define STEP_NS 500000U
#define SHEET "descriptors/devices/joint-drive.eds"
#define BOOT_NS 5000000U
#define RESET_TRIES 100U

static bus_t* bus;
static drive_t* drive;
static unsigned master;
// Another node, which acknowledges frames when master and drive send at the same time.
static unsigned listener;
static unsigned boots;

static void hear(void* const context, const osal_can_frame_t* const frame)
{
    (void)context;
    FUZZ_CHECK((frame->id & OSAL_CAN_ERROR) == 0U);
    FUZZ_CHECK(frame->length <= 8U);
    boots += ((frame->id == (0x700U + NODE)) && (frame->length == 1U) && (frame->data[0] == 0U)) ? 1U : 0U;
}

static void read_truth(void* const context, drive_truth_t* const out_truth)
{
    (void)context;
    *out_truth = (drive_truth_t){0.1, 0.0, 1.0};
}

static void begin(void)
{
    const bus_config_t config       = {.nominal_bit_rate = 1000000U, .data_bit_rate = 5000000U, .seed = 1U};
    const bus_callbacks_t callbacks = {.on_frame = hear};
    const drive_config_t drives     = {.seed          = 1U,
                                       .sensor_device = 1U,
                                       .step_ns       = STEP_NS,
                                       .substep_ns    = STEP_NS / 4U,
                                       .torque_sensor = {.noise_rms_nm   = 0.02,
                                                         .offset_max_nm  = 0.2,
                                                         .drift_max_nm_s = 2e-4,
                                                         .range_nm       = 60.0},
                                       .encoder       = {.counts_per_turn = 65536U, .gear_ratio = 160.0},
                                       .read_truth    = read_truth};
    char error[EDS_ERROR_MAX];
    boots = 0U;
    bus   = bus_create(&config);
    FUZZ_CHECK((bus != NULL) && (bus_add_node(bus, &callbacks, &master) == STATUS_OK) &&
               (bus_add_node(bus, &(bus_callbacks_t){.context = NULL}, &listener) == STATUS_OK));
    FUZZ_CHECK(drive_create(bus, SHEET, NODE, &drives, &drive, error) == STATUS_OK);
    node_power_on(drive_node(drive));
    bus_run_until(bus, BOOT_NS);
    FUZZ_CHECK(boots == 1U);
}

static void act(const fuzz_record_t* const record)
{
    const osal_can_frame_t frame = fuzz_can_frame(record);
    switch (record->kind % 5U) {
    case 3U:
        bus_run_until(bus, bus_now_ns(bus) + ((uint64_t)record->argument * 100000U));
        FUZZ_CHECK(isfinite(drive_regulate(drive, 0.1, 0.0)));
        drive_end_step(drive, bus_now_ns(bus));
        break;
    case 4U:
        node_unplug(drive_node(drive));
        bus_run_until(bus, bus_now_ns(bus) + 1000000U);
        node_plug(drive_node(drive));
        break;
    default:
        (void)bus_submit(bus, master, &frame, bus_now_ns(bus));
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    fuzz_input_t input = fuzz_input(data, size);
    fuzz_record_t record;
    begin();
    while (fuzz_next(&input, &record)) {
        act(&record);
    }
    bus_run_until(bus, bus_now_ns(bus) + 20000000U);
    const osal_can_frame_t reset = {.id = 0U, .length = 2U, .data = {129U, NODE}};
    boots                        = 0U;
    if (bus_submit(bus, master, &reset, bus_now_ns(bus)) == STATUS_OK) {
        for (unsigned i = 0U; (i < RESET_TRIES) && (boots == 0U); i++) { // Colliding frames need time.
            bus_run_until(bus, bus_now_ns(bus) + 10000000U);
        }
        FUZZ_CHECK(boots >= 1U);
    }
    drive_destroy(drive);
    bus_destroy(bus);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_records(data, size, max_size, seed, fuzz_repair_can);
}
