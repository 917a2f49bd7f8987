// SPDX-License-Identifier: Apache-2.0
// Checks whether the stream devices of the mission can be reached from the on-board computers of a run.
#include "launcher/launcher_internal.h"

static const char no_host_expected[] =
    "\" of <Endnode>: expected no host with --nodes 2, because the network of the two on-board computers "
    "leads to no device; fly with --nodes 1, or give the device another type of end node";

/// Returns the text for the type of an end node with a host; null for all other types.
static const char* type_with_host(const descriptor_endnode_type_t type)
{
    if (type == DESCRIPTOR_ENDNODE_UDP) {
        return "UDP";
    }
    return (type == DESCRIPTOR_ENDNODE_TCP) ? "TCP" : NULL;
}

/// Refuse the first end node of the descriptor in `scratch` that is on a host.
static bool are_reachable(launcher_t* const launcher)
{
    const subsystem_descriptor_t* const descriptor = &launcher->scratch;
    for (uint16_t i = 0U; i < descriptor->endnode_count; i++) {
        const descriptor_endnode_t* const endnode = &descriptor->endnodes[i];
        const char* const type                    = type_with_host(endnode->type);
        char line[16];
        text_t text = text_in(line, sizeof line);
        text_add_unsigned(&text, endnode->line);
        if (type != NULL) {
            return launcher_refuse(launcher,
                                   (const char* const[]){launcher->loader.path, ":", line, ": type=\"", type,
                                                         no_host_expected, NULL});
        }
    }
    return true;
}

bool launcher_check_streams(launcher_t* const launcher, const char* const mission_path)
{
    bool is_good = true;
    if (launcher->options.computers < 2U) {
        return true;
    }
    for (uint16_t i = 0U; is_good && (i < launcher->mission.subsystem_count); i++) {
        const uint16_t apid = launcher->mission.subsystems[i].apid;
        // The mission is read again, with the descriptor of this subsystem last.
        is_good = (descriptor_load_mission(&launcher->loader, mission_path, apid, &descriptor_mission_whole,
                                           &launcher->mission, &launcher->scratch) == STATUS_OK)
                      ? are_reachable(launcher)
                      : launcher_fail(launcher, descriptor_error(&launcher->loader), "");
    }
    return is_good;
}
