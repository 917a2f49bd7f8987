// SPDX-License-Identifier: Apache-2.0
// TC[129,6] loads arbitrary configurations: the interface of the manipulator is fixed, and the input is the
// rest of the document. After a refused document the old one is in force, with its configuration hash. An
// accepted document is flown: each of its first three configurations is selected and brought up as far as
// possible with drives on the bus; then the subsystem returns to OFFLINE, where it accepts the next document.
#include "fsw/framework/subsystem/subsystem_core.h"
#include "fsw/subsystems/manipulator/manipulator.h"
#include "generated/manipulator_descriptor.h"
#include "pus/core/packet.h"
#include "test/fuzz/fuzz.h"
#include "test/fuzz/memory_socket.h"
#include "test/support/scripted_bus.h"

#include <stdio.h>
#include <string.h>

#define DESCRIPTOR "descriptors/subsystems/manipulator.xml"
#define FIRST_CONFIGURATION "  <Configuration "
#define DOCUMENT_MAX 65536U
#define END "</Subsystem>\n"
#define STEPS_OF_A_STATE 200U
#define STEPS_TO_OFFLINE 100000U
#define CONFIGURATIONS_FLOWN 3U

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptors[2];
static unsigned in_force;
static bool was_taken;
static subsystem_t component;
static manipulator_t manipulator;
static scripted_bus_t bus;
static uint64_t now_ns;
static uint16_t sequence;
static char document[DOCUMENT_MAX];
static size_t interface_size; // Part of the document before its first configuration.
static size_t document_size;

static status_t take_report(void* const context, const uint8_t* const packet, const size_t size)
{
    (void)context;
    pus_tm_t tm;
    pus_failure_t failure;
    FUZZ_CHECK(pus_tm_decode(packet, size, &tm, &failure) == STATUS_OK);
    FUZZ_CHECK(tm.apid == MANIPULATOR_APID);
    return STATUS_OK;
}

static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    (void)context;
    (void)kind;
    (void)name;
    (void)strcpy(out_address->address, "shm:fuzz");
    return STATUS_OK;
}

/// Read the document again into the model that is not in force, as a program does.
static status_t reload(void* const context, const subsystem_descriptor_t** const out_descriptor)
{
    (void)context;
    subsystem_descriptor_t* const other = &descriptors[1U - in_force];
    char characters[DESCRIPTOR_ERROR_CHARACTERS];
    text_t error    = text_in(characters, sizeof characters);
    status_t status = descriptor_parse_subsystem(&loader, "manipulator.xml", document, document_size, other);
    if (status == STATUS_OK) {
        status = descriptor_check_interface(&error, "manipulator.xml", other, MANIPULATOR_INTERFACE_HASH);
    }
    was_taken = (status == STATUS_OK);
    FUZZ_CHECK(was_taken == ((descriptor_error(&loader)[0] == '\0') && (characters[0] == '\0')));
    if (was_taken) {
        in_force        = 1U - in_force;
        *out_descriptor = other;
    }
    return status;
}

int LLVMFuzzerInitialize(int* const argc, char*** const argv)
{
    (void)argc;
    (void)argv;
    FILE* const file = fopen(DESCRIPTOR, "rb");
    FUZZ_CHECK(file != NULL);
    const size_t size = fread(document, 1U, sizeof document - 1U, file);
    (void)fclose(file);
    document[size]          = '\0';
    const char* const found = strstr(document, FIRST_CONFIGURATION);
    FUZZ_CHECK(found != NULL);
    interface_size = (size_t)(found - document);
    return 0;
}

static void step(const unsigned count)
{
    for (unsigned i = 0U; i < count; i++) {
        const uint64_t wake_ns = subsystem_step(&component, now_ns);
        FUZZ_CHECK(wake_ns > now_ns);
        scripted_bus_run(&bus);
        scripted_bus_heartbeat(&bus);
        now_ns = wake_ns;
    }
}

static void request(const uint8_t subtype, const uint8_t* const data, const size_t size)
{
    uint8_t packet[32];
    size_t octets     = 0U;
    const pus_tc_t tc = {.apid     = MANIPULATOR_APID,
                         .sequence = sequence,
                         .ack      = PUS_ACK_ALL,
                         .service  = PUS_SERVICE_MANAGEMENT,
                         .subtype  = subtype,
                         .source   = 1U,
                         .data     = data,
                         .size     = size};
    sequence++;
    FUZZ_CHECK(pus_tc_encode(&tc, packet, sizeof packet, &octets) == STATUS_OK);
    subsystem_accept(&component, packet, octets, now_ns);
}

static void go(const state_t state, const unsigned steps)
{
    const uint8_t data[] = {(uint8_t)state};
    request(PUS_MANAGEMENT_REQUEST_STATE, data, sizeof data);
    for (unsigned i = 0U; (i < steps) && (subsystem_state(&component) != state); i++) {
        step(1U);
    }
}

static void go_offline(void)
{
    (void)subsystem_request(&component, STATE_OFFLINE, CAUSE_SHUTDOWN);
    for (unsigned i = 0U; (i < STEPS_TO_OFFLINE) && (subsystem_state(&component) != STATE_OFFLINE); i++) {
        if ((i % 1000U) == 999U) { // An action that failed may have left the component in ERROR_OPERATIONAL.
            (void)subsystem_request(&component, STATE_OFFLINE, CAUSE_SHUTDOWN);
        }
        step(1U);
    }
    FUZZ_CHECK(subsystem_state(&component) == STATE_OFFLINE);
}

static void fly(const uint16_t configuration)
{
    const uint8_t data[] = {(uint8_t)(configuration >> 8U), (uint8_t)(configuration & 0xFFU)};
    go(STATE_PRE_OPERATIONAL, STEPS_OF_A_STATE);
    request(PUS_MANAGEMENT_SELECT, data, sizeof data);
    step(STEPS_OF_A_STATE);
    go(STATE_SAFE_OPERATIONAL, STEPS_OF_A_STATE);
    request(PUS_MANAGEMENT_RELOAD, NULL, 0U); // The reload waits for a rest state.
    step(20U);
    go_offline();
}

static void begin(void)
{
    static const flow_resolver_t flows = {NULL, resolve};
    const subsystem_config_t config    = {.descriptor            = &descriptors[0],
                                          .is_descriptor_valid   = true,
                                          .callbacks             = manipulator_callbacks(),
                                          .self                  = &manipulator,
                                          .mission_epoch_s       = 1000U,
                                          .start_count           = 1U,
                                          .port                  = {NULL, take_report},
                                          .supervisor_timeout_ns = 3000000000U,
                                          .status_interval_ns    = SUBSYSTEM_STATUS_INTERVAL_NS,
                                          .reload                = reload};
    memory_sockets_reset();
    descriptor_loader_init(&loader);
    FUZZ_CHECK(descriptor_load_subsystem(&loader, DESCRIPTOR, &descriptors[0]) == STATUS_OK);
    in_force = 0U;
    now_ns   = 0U;
    sequence = 0U;
    scripted_bus_open(&bus, "shm:fuzz");
    (void)scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x11U);
    (void)scripted_bus_add(&bus, SCRIPTED_DRIVE, 0x12U);
    manipulator_init(&manipulator, &component, &flows);
    subsystem_init(&component, &config);
    step(1U);
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    if ((size + interface_size + sizeof END) > sizeof document) {
        return 0;
    }
    (void)memcpy(&document[interface_size], data, size);
    (void)memcpy(&document[interface_size + size], END, sizeof END);
    document_size = interface_size + size + (sizeof END - 1U);
    begin();
    const uint64_t before = component.descriptor->configuration_hash;
    request(PUS_MANAGEMENT_RELOAD, NULL, 0U);
    step(2U);
    FUZZ_CHECK(component.descriptor == &descriptors[in_force]);
    if (was_taken) {
        const subsystem_descriptor_t* const model = component.descriptor;
        uint16_t ids[CONFIGURATIONS_FLOWN];
        uint16_t count = 0U;
        while ((count < model->configuration_count) && (count < CONFIGURATIONS_FLOWN)) {
            ids[count] = model->configurations[count].id;
            count++;
        }
        for (uint16_t i = 0U; i < count; i++) {
            fly(ids[i]);
            FUZZ_CHECK(component.descriptor == &descriptors[in_force]);
        }
    } else {
        FUZZ_CHECK(component.descriptor->configuration_hash == before);
        go(STATE_PRE_OPERATIONAL, STEPS_OF_A_STATE);
        FUZZ_CHECK(subsystem_state(&component) == STATE_PRE_OPERATIONAL);
        go_offline();
    }
    scripted_bus_close(&bus);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_document(data, size, max_size, seed);
}
