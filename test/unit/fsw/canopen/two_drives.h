// SPDX-License-Identifier: Apache-2.0
/// A network of two scripted drives, and the common steps of the tests: cycles, settings, goals, faults.
#ifndef TEST_UNIT_FSW_CANOPEN_TWO_DRIVES_H
#define TEST_UNIT_FSW_CANOPEN_TWO_DRIVES_H

#include "fsw/canopen/network.h"
#include "test/support/scripted_bus.h"

#include <stdint.h>

#define CYCLE_NS 500000U

extern scripted_bus_t bus;
extern canopen_network_t network;
extern scripted_node_t* joints[2];
extern uint64_t now_ns;
extern const flow_resolver_t resolver;
extern const canopen_network_config_t config;

/// One cycle of a transition: STATUS_BUSY until it is complete.
typedef status_t (*action_t)(canopen_network_t* network, uint64_t now_ns);

/// Add a device to the network.
status_t add_device(const char* type, uint8_t node);
/// Put both drives on the bus and into the network; no frame is sent yet.
void two_drives_open(void);
void two_drives_close(void);

/// Run one cycle of 0.5 ms: sense, the action (may be null), emit, then the drives answer. Returns the status
/// of the action.
status_t cycle(action_t action);
/// Run cycles until the action ends. Returns its status.
status_t run_action(action_t action);
/// Run cycles without an action.
void idle(unsigned cycles);
/// Set one setting of the device at `index`.
void set(uint8_t index, uint16_t object, uint8_t subindex, uint8_t octets, uint32_t value);
/// Set the settings of torque mode as a descriptor contains them.
void set_torque_mode(void);
/// Action that ends when all axes have reached their goal.
status_t at_goal(canopen_network_t* self, uint64_t time_ns);
/// Command a goal to the running network, and run cycles until all axes have reached it.
void go(canopen_cia402_goal_t goal);
/// Boot, configure and start the network, then go to a goal.
void run_to(canopen_cia402_goal_t goal);
void expect_no_fault(void);
/// Expect this refusal of a device as the only fault.
void expect_refusal(uint8_t node, canopen_network_refusal_t refusal, uint32_t object, uint32_t detail);
/// Expect this fault of a device as the next one.
void expect_fault(canopen_network_fault_kind_t kind, uint8_t node, uint16_t code);

#endif // TEST_UNIT_FSW_CANOPEN_TWO_DRIVES_H
