// SPDX-License-Identifier: Apache-2.0
/// Drives of two nodes without a bus: the test answers for the nodes.
#ifndef TEST_UNIT_FSW_DRIVES_TWO_NODES_H
#define TEST_UNIT_FSW_DRIVES_TWO_NODES_H

#include "fsw/drives/drives.h"

#define FIRST_NODE 0x11U
#define SECOND_NODE 0x12U

/// Clear the drives, and let their network run with both nodes.
void two_nodes_run(drives_t* drives);

#endif // TEST_UNIT_FSW_DRIVES_TWO_NODES_H
