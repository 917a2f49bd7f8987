// SPDX-License-Identifier: Apache-2.0
// Results of the flight software's reader of descriptors, for comparison with the generator. Built by
// test_descriptors.py.
//   probe subsystem FILE..     one line each: status, both hashes, error
//   probe mission FILE..       the same
//   probe compiled DIRECTORY   generated headers against the descriptors in a directory: prints "agree", or
//                              each difference and then "differ"
#include "base/assertion.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "fsw/framework/parameter/parameter.h"
#include "generated/communication_descriptor.h"
#include "generated/joystick_descriptor.h"
#include "generated/manipulator_descriptor.h"
#include "generated/supervisor_descriptor.h"
#include "test/support/consistent_parameter.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static descriptor_loader_t loader;
static subsystem_descriptor_t descriptor;
static mission_descriptor_t mission;

void fsw_assertion_failed(const char* const file, const int line)
{
    (void)fprintf(stderr, "%s:%d: assertion failed\n", file, line);
    abort();
}

typedef struct {
    const char* file;
    uint64_t hash;
    const parameter_definition_t* definitions;
    const size_t* places;
    uint16_t count;
    size_t storage;
} compiled_t;

#define COMPILED(lower, UPPER)                                                                               \
    {                                                                                                        \
#lower ".xml", UPPER##_INTERFACE_HASH, lower##_definitions, lower##_offsets,                         \
            UPPER##_PARAMETER_COUNT, sizeof(lower##_parameters_t)                                            \
    }

static const compiled_t all[] = {
    COMPILED(manipulator, MANIPULATOR),
    COMPILED(joystick, JOYSTICK),
    COMPILED(supervisor, SUPERVISOR),
    COMPILED(communication, COMMUNICATION),
};

/// True if the layout of a parameter made by the compiler equals the one that the descriptor library
/// computes.
static bool agrees(const parameter_definition_t* const definition)
{
    const descriptor_parameter_t* const found = descriptor_find_parameter(&descriptor, definition->name);
    if ((found == NULL) || (found->id != definition->id) || (found->field_count != definition->field_count) ||
        (found->wire_size != definition->wire_size) || (found->memory_size != definition->memory_size)) {
        return false;
    }
    for (uint16_t i = 0U; i < definition->field_count; i++) {
        const descriptor_field_t* const field = &descriptor.fields[found->first_field + i];
        if ((strcmp(field->name, definition->fields[i].name) != 0) ||
            (field->type != definition->fields[i].type) || (field->count != definition->fields[i].count) ||
            (field->offset != definition->fields[i].offset)) {
            return false;
        }
    }
    return true;
}

/// Publish all parameters and set every initial value, as a subsystem does at its start.
static bool publishes(const compiled_t* const compiled)
{
    static parameter_entry_t entries[DESCRIPTOR_PARAMETERS_MAX];
    static parameter_bounds_t bounds[DESCRIPTOR_FIELDS_MAX];
    static uint64_t storage[1024];
    parameter_dictionary_t dictionary;
    bool is_right = (compiled->storage <= sizeof storage) &&
                    (parameter_init(&dictionary, entries, DESCRIPTOR_PARAMETERS_MAX, bounds,
                                    DESCRIPTOR_FIELDS_MAX) == STATUS_OK);
    for (uint16_t i = 0U; i < compiled->count; i++) {
        is_right = is_right && (parameter_publish(&dictionary, &compiled->definitions[i],
                                                  (uint8_t*)storage + compiled->places[i]) == STATUS_OK);
    }
    for (uint16_t p = 0U; is_right && (p < descriptor.parameter_count); p++) {
        const descriptor_parameter_t* const parameter = &descriptor.parameters[p];
        for (uint16_t f = 0U; f < parameter->field_count; f++) {
            const descriptor_field_t* const field = &descriptor.fields[parameter->first_field + f];
            is_right =
                is_right &&
                (parameter_set_bounds(&dictionary, parameter->id, field->name, field->min, field->max) ==
                 STATUS_OK) &&
                (parameter_set_initial(&dictionary, parameter->id, field->name, field->init) == STATUS_OK);
        }
    }
    return is_right && parameter_is_consistent(&dictionary);
}

static int compare(const char* const directory)
{
    int differences = 0;
    for (size_t i = 0U; i < (sizeof all / sizeof all[0]); i++) {
        char path[512];
        char characters[DESCRIPTOR_ERROR_CHARACTERS];
        text_t error = text_in(characters, sizeof characters);
        (void)snprintf(path, sizeof path, "%s/%s", directory, all[i].file);
        if ((descriptor_load_subsystem(&loader, path, &descriptor) != STATUS_OK) ||
            (descriptor_check_interface(&error, path, &descriptor, all[i].hash) != STATUS_OK)) {
            (void)printf("%s%s\n", descriptor_error(&loader), characters);
            differences++;
            continue;
        }
        for (uint16_t p = 0U; p < all[i].count; p++) {
            if (!agrees(&all[i].definitions[p])) {
                (void)printf("%s: %s\n", path, all[i].definitions[p].name);
                differences++;
            }
        }
        if (!publishes(&all[i])) {
            (void)printf("%s: cannot publish\n", path);
            differences++;
        }
    }
    const bool have_same_size =
        (sizeof(manipulator_move_to_arguments_t) == 24U) &&
        (sizeof(joystick_robot_state_payload_t) == sizeof(manipulator_robot_state_payload_t));
    (void)printf("%s\n", ((differences == 0) && have_same_size) ? "agree" : "differ");
    return differences;
}

int main(const int count, char** const words)
{
    descriptor_loader_init(&loader);
    if ((count == 3) && (strcmp(words[1], "compiled") == 0)) {
        return (compare(words[2]) == 0) ? 0 : 1;
    }
    for (int i = 2; i < count; i++) {
        const bool is_mission = (strcmp(words[1], "mission") == 0);
        const status_t status =
            is_mission ? descriptor_load_mission(&loader, words[i], MISSION_ANY_TARGET,
                                                 &descriptor_mission_whole, &mission, &descriptor)
                       : descriptor_load_subsystem(&loader, words[i], &descriptor);
        (void)printf(
            "%d %016llx %016llx %s\n", (int)status,
            (unsigned long long)(is_mission ? mission.interface_hash : descriptor.interface_hash),
            (unsigned long long)(is_mission ? mission.configuration_hash : descriptor.configuration_hash),
            descriptor_error(&loader));
    }
    return 0;
}
