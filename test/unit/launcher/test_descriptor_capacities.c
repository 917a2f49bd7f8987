// SPDX-License-Identifier: Apache-2.0
// Sizes of the storage of a program from its descriptors: each is the largest that one of its missions needs.
#include "launcher/descriptor_capacities.h"

#include "unity.h"

#include <string.h>

static subsystem_descriptor_t model;
static mission_descriptor_t mission;
static descriptor_capacities_t capacities;
static char header[2048];

void setUp(void)
{
    descriptor_subsystem_clear(&model);
    descriptor_mission_clear(&mission);
    (void)memset(&capacities, 0, sizeof capacities);
    model.apid = 16U;
}

void tearDown(void)
{
}

static void write(void)
{
    text_t text = text_in(header, sizeof header);
    descriptor_capacities_add(&capacities, &model, &mission);
    descriptor_capacities_write(&capacities, &text);
    TEST_ASSERT_FALSE(text.cut);
}

static void expect(const char* const line)
{
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(header, line), header);
}

/// An array in C has at least one item. 256 octets are for structures that the ground defines.
static void an_empty_descriptor_needs_the_smallest_capacities(void)
{
    write();
    expect("#define DRIVES_BUSES_MAX 1U\n#define DRIVES_DEVICES_MAX 1U\n#define DRIVES_MAPPINGS_MAX 1U\n");
    expect("#define SUBSYSTEM_PARAMETERS 1U\n");
    expect("#define SUBSYSTEM_STRUCTURES 1U\n#define SUBSYSTEM_SAMPLE_OCTETS 256U\n");
    expect("#define SUBSYSTEM_LOOPS 1U\n#define SUBSYSTEM_LINKS 1U\n");
}

static void add_device(const char* const bus, const uint8_t node, const uint16_t setting)
{
    const uint16_t i          = model.device_count;
    model.storage.endnodes[i] = (descriptor_endnode_t){.bus = bus, .redundant_bus = "", .node = node};
    model.storage.settings[i] = (descriptor_setting_t){.index = setting};
    model.storage.devices[i]  = (descriptor_device_t){.name          = "D",
                                                      .type          = "drive",
                                                      .first_endnode = i,
                                                      .endnode_count = 1U,
                                                      .first_setting = i,
                                                      .setting_count = 1U};
    model.device_count++;
    model.endnode_count++;
    model.setting_count++;
}

static void nodes_of_all_configurations_count_once(void)
{
    add_device("ONE", 1U, 0x1A00U); // A mapping.
    add_device("ONE", 2U, 0x6060U);
    add_device("TWO", 3U, 0x6060U);
    add_device("ONE", 1U, 0x1A00U); // In a second configuration.
    add_device("ONE", 2U, 0x1600U);
    add_device("THREE", 4U, 0x6060U);
    model.storage.endnodes[5].type = DESCRIPTOR_ENDNODE_UDP; // Not on CAN.
    write();
    expect("#define DRIVES_BUSES_MAX 2U\n#define DRIVES_DEVICES_MAX 3U\n#define DRIVES_MAPPINGS_MAX 2U\n");
}

static void lists_have_a_slot_for_each_item(void)
{
    model.storage.parameters[0].field_count         = 3U;
    model.storage.parameters[1].field_count         = 4U;
    model.parameter_count                           = 2U;
    model.event_count                               = 5U;
    model.storage.functions[0].argument_count       = 2U;
    model.storage.functions[0].memory_size          = 17U;
    model.storage.functions[1].argument_count       = 1U;
    model.storage.functions[1].memory_size          = 8U;
    model.function_count                            = 2U;
    model.storage.configurations[0].loop_count      = 1U;
    model.storage.configurations[1].loop_count      = 2U;
    model.storage.configurations[1].structure_count = 3U;
    model.configuration_count                       = 2U;
    model.storage.structures[1].octets              = 300U;
    model.structure_count                           = 3U;
    model.storage.services[0] = (descriptor_service_t){.type = 12U, .capacity = 32U, .functional = 4U};
    model.service_count       = 1U;
    mission.storage.links[0]  = (mission_link_t){.producer_apid = 16U, .consumer_apid = 17U};
    mission.storage.links[1]  = (mission_link_t){.producer_apid = 17U, .consumer_apid = 16U};
    mission.storage.links[2]  = (mission_link_t){.producer_apid = 17U, .consumer_apid = 18U};
    mission.link_count        = 3U;
    write();
    expect("#define SUBSYSTEM_PARAMETERS 2U\n#define SUBSYSTEM_BOUNDS 7U\n#define SUBSYSTEM_EVENTS 5U\n");
    expect("#define SUBSYSTEM_FUNCTIONS 2U\n#define SUBSYSTEM_ARGUMENTS 3U\n#define SUBSYSTEM_ARGUMENT_WORDS "
           "3U\n");
    // The 3 structures of the second configuration, and 2 for the ground.
    expect("#define SUBSYSTEM_STRUCTURES 5U\n#define SUBSYSTEM_SAMPLE_OCTETS 300U\n");
    expect("#define SUBSYSTEM_LOOPS 2U\n#define SUBSYSTEM_LINKS 2U\n");
    // 16 + 2 x 5 structures + 5 events + 2 parameters + 32 and 4 definitions of monitoring.
    expect("#define SUBSYSTEM_HOST_RECORDS 69U\n");
}

static void the_largest_number_of_all_missions_is_the_capacity(void)
{
    model.event_count = 7U;
    write();
    model.event_count     = 3U;
    model.parameter_count = 2U;
    write();
    expect("#define SUBSYSTEM_PARAMETERS 2U\n");
    expect("#define SUBSYSTEM_EVENTS 7U\n");
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_empty_descriptor_needs_the_smallest_capacities);
    RUN_TEST(nodes_of_all_configurations_count_once);
    RUN_TEST(lists_have_a_slot_for_each_item);
    RUN_TEST(the_largest_number_of_all_missions_is_the_capacity);
    return UNITY_END();
}
