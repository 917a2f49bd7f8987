// SPDX-License-Identifier: Apache-2.0
#include "fsw/supervisor/link_graph.h"

#include "unity.h"

#include <string.h>

#define APIDS 12U // Members in random graphs: 1..12.

void setUp(void)
{
}

void tearDown(void)
{
}

static uint32_t random_state = 9U;

static uint32_t draw(uint32_t below)
{
    random_state = (random_state * 1664525U) + 1013904223U;
    return (random_state >> 8U) % below;
}

static link_edge_t edge(uint16_t link, uint16_t producer, uint16_t consumer)
{
    return (link_edge_t){link, {producer, (uint16_t)(link + 100U), consumer, (uint16_t)(link + 200U)}, false};
}

static void add(link_graph_t* graph, uint16_t link, uint16_t producer, uint16_t consumer)
{
    const link_edge_t added = edge(link, producer, consumer);
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_link_graph_add(graph, &added));
}

static void an_empty_graph_has_networks_of_one(void)
{
    link_graph_t graph = {0};
    uint16_t members[LINK_GRAPH_MEMBERS];
    TEST_ASSERT_EQUAL(1U, supervisor_link_graph_members(&graph, 16U, members));
    TEST_ASSERT_EQUAL(16U, members[0]);
    TEST_ASSERT_EQUAL(16U, supervisor_link_graph_network(&graph, 16U));
    TEST_ASSERT_NULL(supervisor_link_graph_find(&graph, 1U));
    TEST_ASSERT_NULL(supervisor_link_graph_into(&graph, 16U, 1U));
    TEST_ASSERT_FALSE(supervisor_link_graph_remove(&graph, 1U));
}

static void edges_are_found_replaced_and_removed(void)
{
    link_graph_t graph = {0};
    add(&graph, 1U, 16U, 17U);
    add(&graph, 2U, 17U, 16U);
    add(&graph, 3U, 16U, 18U);
    TEST_ASSERT_EQUAL(3U, graph.count);
    TEST_ASSERT_EQUAL(16U, supervisor_link_graph_find(&graph, 2U)->ends.consumer_apid);
    TEST_ASSERT_EQUAL(3U, supervisor_link_graph_into(&graph, 18U, 203U)->link);
    TEST_ASSERT_NULL(supervisor_link_graph_into(&graph, 18U, 201U));
    TEST_ASSERT_NULL(supervisor_link_graph_into(&graph, 16U, 203U));
    add(&graph, 2U, 17U, 19U); // The edge is replaced in its place.
    TEST_ASSERT_EQUAL(3U, graph.count);
    TEST_ASSERT_EQUAL(19U, graph.edges[1].ends.consumer_apid);
    TEST_ASSERT_TRUE(supervisor_link_graph_remove(&graph, 1U));
    TEST_ASSERT_EQUAL(2U, graph.count);
    TEST_ASSERT_EQUAL(2U, graph.edges[0].link); // In the order of opening.
    TEST_ASSERT_EQUAL(3U, graph.edges[1].link);
    TEST_ASSERT_FALSE(supervisor_link_graph_remove(&graph, 1U));
}

static void a_full_graph_refuses(void)
{
    link_graph_t graph = {0};
    for (uint16_t i = 1U; i <= LINK_GRAPH_EDGES; i++) {
        add(&graph, i, 16U, 17U);
    }
    const link_edge_t more = edge(99U, 16U, 17U);
    TEST_ASSERT_EQUAL(STATUS_EXHAUSTED, supervisor_link_graph_add(&graph, &more));
    add(&graph, 5U, 16U, 18U); // Replacing an edge needs no free slot.
    TEST_ASSERT_TRUE(supervisor_link_graph_remove(&graph, LINK_GRAPH_EDGES));
    TEST_ASSERT_EQUAL(STATUS_OK, supervisor_link_graph_add(&graph, &more));
}

static void a_network_holds_a_bounded_number_of_members(void)
{
    link_graph_t graph = {0};
    uint16_t members[LINK_GRAPH_MEMBERS + 1U];
    members[LINK_GRAPH_MEMBERS] = 0xBEEFU;
    for (uint16_t i = 1U; i < LINK_GRAPH_EDGES; i++) { // A chain longer than the limit of a network.
        add(&graph, i, i, (uint16_t)(i + 1U));
    }
    TEST_ASSERT_EQUAL(LINK_GRAPH_MEMBERS, supervisor_link_graph_members(&graph, 1U, members));
    TEST_ASSERT_EQUAL(0xBEEFU, members[LINK_GRAPH_MEMBERS]);
}

/// Find the connected members by Warshall's algorithm, independently of the search under test.
static void close_naively(const link_graph_t* graph, bool connected[APIDS + 1U][APIDS + 1U])
{
    (void)memset(connected, 0, (APIDS + 1U) * (APIDS + 1U) * sizeof(bool));
    for (unsigned a = 1U; a <= APIDS; a++) {
        connected[a][a] = true;
    }
    for (unsigned i = 0U; i < graph->count; i++) {
        const link_edge_t* const link                                 = &graph->edges[i];
        connected[link->ends.producer_apid][link->ends.consumer_apid] = true;
        connected[link->ends.consumer_apid][link->ends.producer_apid] = true;
    }
    for (unsigned k = 1U; k <= APIDS; k++) {
        for (unsigned a = 1U; a <= APIDS; a++) {
            for (unsigned b = 1U; b <= APIDS; b++) {
                connected[a][b] = connected[a][b] || (connected[a][k] && connected[k][b]);
            }
        }
    }
}

static void check_members(const link_graph_t* graph, uint16_t apid, const bool* connected)
{
    uint16_t members[LINK_GRAPH_MEMBERS];
    const uint16_t count = supervisor_link_graph_members(graph, apid, members);
    unsigned expected    = 0U;
    uint16_t smallest    = 0U;
    for (uint16_t other = APIDS; other >= 1U; other--) {
        unsigned times = 0U;
        for (uint16_t i = 0U; i < count; i++) {
            times += (members[i] == other) ? 1U : 0U;
        }
        TEST_ASSERT_EQUAL(connected[other] ? 1U : 0U, times);
        expected += connected[other] ? 1U : 0U;
        smallest = connected[other] ? other : smallest;
    }
    TEST_ASSERT_EQUAL(expected, count);
    TEST_ASSERT_EQUAL(apid, members[0]);
    TEST_ASSERT_EQUAL(smallest, supervisor_link_graph_network(graph, apid));
}

static void networks_are_the_connected_components(void)
{
    static bool connected[APIDS + 1U][APIDS + 1U];
    for (unsigned trial = 0U; trial < 300U; trial++) {
        link_graph_t graph = {0};
        for (unsigned step = 0U; step < 30U; step++) {
            const uint16_t link = (uint16_t)(1U + draw(20U));
            if (draw(3U) == 0U) {
                (void)supervisor_link_graph_remove(&graph, link);
            } else {
                add(&graph, link, (uint16_t)(1U + draw(APIDS)), (uint16_t)(1U + draw(APIDS)));
            }
            close_naively(&graph, connected);
            for (uint16_t apid = 1U; apid <= APIDS; apid++) {
                check_members(&graph, apid, connected[apid]);
            }
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(an_empty_graph_has_networks_of_one);
    RUN_TEST(edges_are_found_replaced_and_removed);
    RUN_TEST(a_full_graph_refuses);
    RUN_TEST(a_network_holds_a_bounded_number_of_members);
    RUN_TEST(networks_are_the_connected_components);
    return UNITY_END();
}
