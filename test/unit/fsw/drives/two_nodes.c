// SPDX-License-Identifier: Apache-2.0
#include "test/unit/fsw/drives/two_nodes.h"

#include "unity.h"

#include <string.h>

void two_nodes_run(drives_t* drives)
{
    static const canopen_network_config_t config = {.master              = {.node_id              = 1U,
                                                                            .heartbeat_ns         = 1000000U,
                                                                            .heartbeat_timeout_ns = 3000000U,
                                                                            .sdo_timeout_ns       = 1000U},
                                                    .lost_after_syncs    = 3U,
                                                    .boot_retry_ns       = 1U,
                                                    .silence_reported_ns = 1U,
                                                    .selection_ns        = 1U,
                                                    .quick_stop_limit_ns = 1U};
    memset(drives, 0, sizeof *drives);
    canopen_network_t* const network = &drives->buses[0].network;
    canopen_network_init(network, &config);
    TEST_ASSERT_EQUAL(STATUS_OK,
                      canopen_network_add(network, &drives->devices[0], "joint-drive", FIRST_NODE));
    TEST_ASSERT_EQUAL(STATUS_OK,
                      canopen_network_add(network, &drives->devices[1], "joint-drive", SECOND_NODE));
    network->is_running  = true;
    drives->device_count = 2U;
    drives->bus_count    = 1U;
}
