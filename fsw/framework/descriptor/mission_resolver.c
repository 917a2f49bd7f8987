// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/descriptor/mission_builder.h"

#include <string.h>

void descriptor_mission_builder_refuse(source_t* const source, const uint32_t line,
                                       const char* const attribute, const char* const words,
                                       const char* const expected)
{
    descriptor_source_refuse(source, line, "%=\"%\" of <", attribute, words, 0U);
    descriptor_source_append(source, "%", expected, NULL, 0U);
}

/// True if the words SUBSYSTEM.PORT begin with the name of this subsystem; the port may be unknown.
static bool is_port_of(const char* const words, const char* const name)
{
    const size_t length = strcspn(words, ".");
    return (words[length] == '.') && (strncmp(name, words, length) == 0) && (name[length] == '\0');
}

/// Set the ids of the ports of this subsystem in all links. The id of a port that does not exist stays 0.
static void find_ports(mission_builder_t* const builder, const mission_subsystem_t* const subsystem,
                       const subsystem_descriptor_t* const descriptor)
{
    for (uint16_t i = 0U; i < builder->mission->link_count; i++) {
        uint16_t* const ids[2] = {&builder->mission->storage.links[i].producer_port,
                                  &builder->mission->storage.links[i].consumer_port};
        for (unsigned end = 0U; end < 2U; end++) {
            const char* const words = builder->link_words[i][end];
            if (is_port_of(words, subsystem->name)) {
                const descriptor_port_t* const port =
                    descriptor_named(descriptor->ports, descriptor->port_count, sizeof descriptor->ports[0],
                                     &words[strcspn(words, ".") + 1U]);
                *ids[end] = (port != NULL) ? port->id : 0U;
            }
        }
    }
}

status_t descriptor_mission_builder_take(mission_builder_t* const builder, const uint16_t index,
                                         const char* const path,
                                         const subsystem_descriptor_t* const descriptor)
{
    mission_subsystem_t* const subsystem = &builder->mission->storage.subsystems[index];
    source_t* const source               = &builder->source;
    source->line                         = subsystem->line;
    if ((strcmp(subsystem->name, descriptor->name) != 0) || (subsystem->apid != descriptor->apid)) {
        descriptor_source_refuse(source, subsystem->line, "%: expected name and id % # as in its descriptor",
                                 subsystem->name, descriptor->name, descriptor->apid);
    }
    find_ports(builder, subsystem, descriptor);
    if (builder->scope != NULL) {
        builder->scope->take(builder, subsystem, path, descriptor);
    }
    return source->status;
}

void descriptor_mission_builder_link(source_t* const source)
{
    mission_link_t* const link = source->item;
    const char** const words   = descriptor_mission_builder_of(source)->link_words[source->order];
    link->number               = (uint16_t)(source->order + 1U);
    words[0] = descriptor_source_text(source, "from", SOURCE_TEXT, 2U * DESCRIPTOR_NAME_MAX);
    words[1] = descriptor_source_text(source, "to", SOURCE_TEXT, 2U * DESCRIPTOR_NAME_MAX);
}

/// Returns the APID of the subsystem in the words SUBSYSTEM.PORT; 0 if there is none.
static uint16_t apid_of_end(const mission_descriptor_t* const mission, const char* const words)
{
    for (uint16_t s = 0U; s < mission->subsystem_count; s++) {
        if (is_port_of(words, mission->subsystems[s].name)) {
            return mission->subsystems[s].apid;
        }
    }
    return 0U;
}

status_t descriptor_mission_builder_resolve(mission_builder_t* const builder)
{
    for (uint16_t i = 0U; i < builder->mission->link_count; i++) {
        mission_link_t* const link = &builder->mission->storage.links[i];
        link->producer_apid        = apid_of_end(builder->mission, builder->link_words[i][0]);
        link->consumer_apid        = apid_of_end(builder->mission, builder->link_words[i][1]);
    }
    if (builder->scope != NULL) {
        builder->scope->resolve(builder);
    }
    return builder->source.status;
}
