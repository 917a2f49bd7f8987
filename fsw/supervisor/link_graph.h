// SPDX-License-Identifier: Apache-2.0
/// Graph of the open real-time links: each link is an edge, each connected component a real-time network.
///
/// Ownership  The caller provides link_graph_t.
/// Context    One loop.
/// Time       O(links^2), links <= LINK_GRAPH_EDGES.
#ifndef FSW_SUPERVISOR_LINK_GRAPH_H
#define FSW_SUPERVISOR_LINK_GRAPH_H

#include "base/status.h"
#include "pus/private/st130_rtlink.h"

#include <stdbool.h>
#include <stdint.h>

#define LINK_GRAPH_EDGES 32U
#define LINK_GRAPH_MEMBERS 16U

typedef struct {
    uint16_t link;
    pus_link_ends_t ends;
    bool is_stale; ///< The consumer's last report says that the link is stale.
} link_edge_t;

typedef struct {
    link_edge_t edges[LINK_GRAPH_EDGES];
    uint16_t count;
} link_graph_t;

/// Add or replace the edge of a link. STATUS_OK, STATUS_EXHAUSTED.
MUST_USE status_t supervisor_link_graph_add(link_graph_t* graph, const link_edge_t* edge);
/// Remove the edge of a link. True if there was one.
bool supervisor_link_graph_remove(link_graph_t* graph, uint16_t link);
/// Returns the edge of a link, or null.
link_edge_t* supervisor_link_graph_find(link_graph_t* graph, uint16_t link);
/// Returns the edge that ends at a port of a consumer, or null.
const link_edge_t* supervisor_link_graph_into(const link_graph_t* graph, uint16_t consumer_apid,
                                              uint16_t consumer_port);
/// List all members of the network of `apid`, `apid` first. Returns their number, >= 1, <=
/// LINK_GRAPH_MEMBERS.
uint16_t supervisor_link_graph_members(const link_graph_t* graph, uint16_t apid,
                                       uint16_t out_members[LINK_GRAPH_MEMBERS]);
/// True if the edge with this index (below `count`) is the first of its network, in the order of opening.
bool supervisor_link_graph_is_first(const link_graph_t* graph, uint16_t index);
/// Returns the number of the network of `apid`, which is the smallest id of its members.
uint16_t supervisor_link_graph_network(const link_graph_t* graph, uint16_t apid);

#endif // FSW_SUPERVISOR_LINK_GRAPH_H
