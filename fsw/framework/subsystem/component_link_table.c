// SPDX-License-Identifier: Apache-2.0
// Assignment of a component's links to its ports.
#include "fsw/framework/subsystem/component_internal.h"

static component_link_t* free_link(component_t* const component)
{
    for (component_link_t* link = component->links; link < &component->links[COMPONENT_LINKS]; link++) {
        if (!link->is_used) {
            return link;
        }
    }
    return NULL;
}

component_link_t* component_link_numbered(component_t* const component, const uint16_t number)
{
    for (component_link_t* link = component->links; link < &component->links[COMPONENT_LINKS]; link++) {
        if (link->is_used && (link->link == number)) {
            return link;
        }
    }
    return NULL;
}

component_link_t* component_link_next(component_t* const component, const component_link_t* const previous,
                                      const uint16_t port)
{
    for (component_link_t* link = component->links; link < &component->links[COMPONENT_LINKS]; link++) {
        if (link->is_used && (link->port->id == port) && ((previous == NULL) || (link > previous))) {
            return link;
        }
    }
    return NULL;
}

component_link_t* component_link_of(component_t* const component, const uint16_t port)
{
    return component_link_next(component, NULL, port);
}

component_link_t* component_link_slot(component_t* const component, const descriptor_port_t* const port,
                                      const uint16_t number)
{
    component_link_t* const same = component_link_numbered(component, number);
    if (same != NULL) {
        return (same->port->id == port->id) ? same : NULL;
    }
    uint16_t readers      = 0U;
    component_link_t* its = component_link_of(component, port->id);
    if (!port->is_provided && (its != NULL)) {
        return its;
    }
    for (; its != NULL; its = component_link_next(component, its, port->id)) {
        readers++;
    }
    return (readers < COMPONENT_PORT_LINKS) ? free_link(component) : NULL;
}
