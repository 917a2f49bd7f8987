// SPDX-License-Identifier: Apache-2.0
// Assignment of a component's links to its ports.
#include "fsw/framework/subsystem/subsystem_internal.h"

static subsystem_link_t* free_link(subsystem_t* const subsystem)
{
    for (subsystem_link_t* link = subsystem->links; link < &subsystem->links[SUBSYSTEM_LINKS]; link++) {
        if (!link->is_used) {
            return link;
        }
    }
    return NULL;
}

subsystem_link_t* subsystem_link_numbered(subsystem_t* const subsystem, const uint16_t number)
{
    for (subsystem_link_t* link = subsystem->links; link < &subsystem->links[SUBSYSTEM_LINKS]; link++) {
        if (link->is_used && (link->link == number)) {
            return link;
        }
    }
    return NULL;
}

subsystem_link_t* subsystem_link_next(subsystem_t* const subsystem, const subsystem_link_t* const previous,
                                      const uint16_t port)
{
    for (subsystem_link_t* link = subsystem->links; link < &subsystem->links[SUBSYSTEM_LINKS]; link++) {
        if (link->is_used && (link->port->id == port) && ((previous == NULL) || (link > previous))) {
            return link;
        }
    }
    return NULL;
}

subsystem_link_t* subsystem_link_of(subsystem_t* const subsystem, const uint16_t port)
{
    return subsystem_link_next(subsystem, NULL, port);
}

subsystem_link_t* subsystem_link_slot(subsystem_t* const subsystem, const descriptor_port_t* const port,
                                      const uint16_t number)
{
    subsystem_link_t* const same = subsystem_link_numbered(subsystem, number);
    if (same != NULL) {
        return (same->port->id == port->id) ? same : NULL;
    }
    uint16_t readers       = 0U;
    subsystem_link_t* link = subsystem_link_of(subsystem, port->id);
    if (!port->is_provided && (link != NULL)) {
        return link;
    }
    for (; link != NULL; link = subsystem_link_next(subsystem, link, port->id)) {
        readers++;
    }
    return (readers < SUBSYSTEM_PORT_LINKS) ? free_link(subsystem) : NULL;
}
