// SPDX-License-Identifier: Apache-2.0
// A mission descriptor, which names the real subsystems, is either refused with file and line, or gives a
// model in which every index and range is consistent.
#include "fsw/framework/descriptor/descriptor.h"
#include "test/fuzz/fuzz.h"

#include <stdio.h>
#include <string.h>

static descriptor_loader_t loader;
static subsystem_descriptor_t scratch;
static mission_descriptor_t mission;
static char path[128];

int LLVMFuzzerInitialize(int* const argc, char*** const argv)
{
    (void)argc;
    (void)argv;
    const uint8_t nothing       = 0U;
    const char* const directory = fuzz_directory("mission");
    fuzz_link(directory, "missions", ".");
    fuzz_link(directory, "subsystems", "../../../../descriptors/subsystems");
    fuzz_link(directory, "mission.xml", fuzz_file(&nothing, 0U));
    (void)snprintf(path, sizeof path, "%s/missions/mission.xml", directory);
    return 0;
}

static void check_subsystems(void)
{
    FUZZ_CHECK((mission.subsystem_count >= 1U) && (mission.subsystem_count <= MISSION_SUBSYSTEMS_MAX));
    for (uint16_t i = 0U; i < mission.subsystem_count; i++) {
        const mission_subsystem_t* const subsystem = &mission.subsystems[i];
        FUZZ_CHECK(descriptor_mission_find_subsystem(&mission, subsystem->apid) == subsystem);
        FUZZ_CHECK(subsystem->configuration_count <= MISSION_CONFIGURATIONS_MAX);
        FUZZ_CHECK(subsystem->port_count <= MISSION_PORTS_MAX);
    }
}

static void check_rules(void)
{
    for (uint16_t i = 0U; i < mission.rule_count; i++) {
        const mission_rule_t* const rule = &mission.rules[i];
        FUZZ_CHECK((rule->target == MISSION_ANY_TARGET) ||
                   (descriptor_mission_find_subsystem(&mission, rule->target) != NULL));
    }
    for (uint16_t i = 0U; i < mission.link_count; i++) {
        const mission_link_t* const link = &mission.links[i];
        FUZZ_CHECK(descriptor_mission_find_subsystem(&mission, link->producer_apid) != NULL);
        FUZZ_CHECK(descriptor_mission_find_subsystem(&mission, link->consumer_apid) != NULL);
    }
    for (uint16_t i = 0U; i < mission.plan_count; i++) {
        const mission_plan_t* const plan = &mission.plans[i];
        FUZZ_CHECK((plan->first_action <= mission.action_count) &&
                   (plan->action_count <= (mission.action_count - plan->first_action)));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    (void)fuzz_file(data, size);
    descriptor_loader_init(&loader);
    const status_t status   = descriptor_load_mission(&loader, path, MISSION_ANY_TARGET,
                                                      &descriptor_mission_whole, &mission, &scratch);
    const char* const error = descriptor_error(&loader);
    if (status != STATUS_OK) {
        FUZZ_CHECK((status != STATUS_BUSY) && (status < STATUS_COUNT) && (strchr(error, ':') != NULL));
        FUZZ_CHECK((mission.subsystem_count == 0U) && (mission.name[0] == '\0'));
        return 0;
    }
    FUZZ_CHECK(error[0] == '\0');
    check_subsystems();
    check_rules();
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t* const data, const size_t size, const size_t max_size,
                               const unsigned seed)
{
    return fuzz_mutate_document(data, size, max_size, seed);
}
