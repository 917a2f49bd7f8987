// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/link_graph.h"

#include "base/assertion.h"

#include <stddef.h>

link_edge_t* supervisor_link_graph_find(link_graph_t* const graph, const uint16_t link)
{
    FSW_ASSERT(graph != NULL);
    for (uint16_t i = 0U; i < graph->count; i++) {
        if (graph->edges[i].link == link) {
            return &graph->edges[i];
        }
    }
    return NULL;
}

status_t supervisor_link_graph_add(link_graph_t* const graph, const link_edge_t* const edge)
{
    FSW_ASSERT(edge != NULL);
    link_edge_t* const present = supervisor_link_graph_find(graph, edge->link);
    if (present != NULL) {
        *present = *edge;
        return STATUS_OK;
    }
    if (graph->count == LINK_GRAPH_EDGES) {
        return STATUS_EXHAUSTED;
    }
    graph->edges[graph->count] = *edge;
    graph->count++;
    return STATUS_OK;
}

bool supervisor_link_graph_remove(link_graph_t* const graph, const uint16_t link)
{
    link_edge_t* const edge = supervisor_link_graph_find(graph, link);
    if (edge == NULL) {
        return false;
    }
    for (link_edge_t* next = edge; next < &graph->edges[graph->count - 1U]; next++) {
        *next = next[1]; // The order of opening is kept, so that the order in reports does not change.
    }
    graph->count--;
    return true;
}

const link_edge_t* supervisor_link_graph_into(const link_graph_t* const graph, const uint16_t consumer_apid,
                                              const uint16_t consumer_port)
{
    FSW_ASSERT(graph != NULL);
    for (uint16_t i = 0U; i < graph->count; i++) {
        const link_edge_t* const edge = &graph->edges[i];
        if ((edge->ends.consumer_apid == consumer_apid) && (edge->ends.consumer_port == consumer_port)) {
            return edge;
        }
    }
    return NULL;
}

static bool contains(const uint16_t* const members, const uint16_t count, const uint16_t apid)
{
    for (uint16_t i = 0U; i < count; i++) {
        if (members[i] == apid) {
            return true;
        }
    }
    return false;
}

uint16_t supervisor_link_graph_members(const link_graph_t* const graph, const uint16_t apid,
                                       uint16_t out_members[LINK_GRAPH_MEMBERS])
{
    FSW_ASSERT((graph != NULL) && (out_members != NULL));
    uint16_t count = 1U;
    out_members[0] = apid;
    for (uint16_t next = 0U; next < count; next++) { // Breadth-first search.
        for (uint16_t i = 0U; i < graph->count; i++) {
            const link_edge_t* const edge = &graph->edges[i];
            const bool is_out             = (edge->ends.producer_apid == out_members[next]);
            const bool is_in              = (edge->ends.consumer_apid == out_members[next]);
            const uint16_t other          = is_out ? edge->ends.consumer_apid : edge->ends.producer_apid;
            if ((is_out || is_in) && !contains(out_members, count, other) && (count < LINK_GRAPH_MEMBERS)) {
                out_members[count] = other;
                count++;
            }
        }
    }
    return count;
}

uint16_t supervisor_link_graph_network(const link_graph_t* const graph, const uint16_t apid)
{
    uint16_t members[LINK_GRAPH_MEMBERS];
    const uint16_t count = supervisor_link_graph_members(graph, apid, members);
    uint16_t smallest    = members[0];
    for (uint16_t i = 1U; i < count; i++) {
        smallest = (members[i] < smallest) ? members[i] : smallest;
    }
    return smallest;
}

bool supervisor_link_graph_is_first(const link_graph_t* const graph, const uint16_t index)
{
    FSW_ASSERT((graph != NULL) && (index < graph->count));
    const uint16_t network = supervisor_link_graph_network(graph, graph->edges[index].ends.producer_apid);
    for (uint16_t i = 0U; i < index; i++) {
        if (supervisor_link_graph_network(graph, graph->edges[i].ends.producer_apid) == network) {
            return false;
        }
    }
    return true;
}
