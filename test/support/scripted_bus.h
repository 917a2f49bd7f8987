// SPDX-License-Identifier: Apache-2.0
/// Nodes on a CAN bus for tests of the flight software: they behave as CiA 301 and 402 require, or make the
/// errors that the test requests. There is no bus timing: one call answers all frames of the flight software.
///
/// A node has every object; an object that was not set reads as zero. Its kind determines its process data.
#ifndef TEST_SUPPORT_SCRIPTED_BUS_H
#define TEST_SUPPORT_SCRIPTED_BUS_H

#include "osal/include/osal/can.h"

#include <stdbool.h>
#include <stdint.h>

#define SCRIPTED_NODES 16U
#define SCRIPTED_OBJECTS 64U
#define SCRIPTED_FRAMES 256U
#define SCRIPTED_AXES 2U

typedef enum {
    SCRIPTED_DRIVE,    ///< Process data of the class "joint-drive".
    SCRIPTED_JOYSTICK, ///< Process data of the class "joystick".
    SCRIPTED_VALVES,   ///< Process data of the class "valve-box"; its inputs are its outputs.
    SCRIPTED_GYRO      ///< Process data of the class "gyro".
} scripted_kind_t;

typedef struct {
    uint16_t index;
    uint8_t subindex;
    uint8_t octets;
    uint32_t value;
    uint32_t abort_code; ///< Not 0: abort code of every access.
} scripted_object_t;

typedef struct { // The test may read and write all fields.
    uint8_t id;
    scripted_kind_t kind;
    bool is_plugged;   ///< False: the node neither receives nor sends.
    bool is_boot_mute; ///< The node does not boot.
    bool is_sdo_mute;  ///< The node does not answer SDO requests.
    bool is_pdo_mute;  ///< The node does not answer SYNC.
    bool is_stuck;     ///< The power state does not change.
    uint8_t nmt;       ///< NMT state as in heartbeats.
    unsigned boots;
    uint16_t status[SCRIPTED_AXES]; ///< Statusword.
    uint16_t control[SCRIPTED_AXES];
    int32_t position[SCRIPTED_AXES];
    int16_t torque[SCRIPTED_AXES];
    int32_t target_position;
    int16_t torque_offset;
    int16_t target_torque[SCRIPTED_AXES];
    uint8_t outputs[4]; ///< Process data to a valve box.
    int32_t rate[3];    ///< Rate of a gyro [1e-7 rad/s].
    unsigned pdos_received;
    unsigned last_pdo; ///< Number of the RPDO received last, 1 or 2.
    scripted_object_t objects[SCRIPTED_OBJECTS];
    unsigned object_count;
    unsigned writes; ///< SDO downloads accepted.
} scripted_node_t;

typedef struct {
    osal_can_t wire;
    char address[64]; ///< Address for the flight software.
    scripted_node_t nodes[SCRIPTED_NODES];
    unsigned node_count;
    osal_can_frame_t seen[SCRIPTED_FRAMES]; ///< Frames of the flight software since the last run, in order.
    unsigned seen_count;
    unsigned syncs;
} scripted_bus_t;

/// Make a bus with a name unique to this process, and open its wire end.
void scripted_bus_open(scripted_bus_t* bus, const char* name);
void scripted_bus_close(scripted_bus_t* bus);
/// Add a node with the objects of its kind, plugged and not yet booted.
scripted_node_t* scripted_bus_add(scripted_bus_t* bus, scripted_kind_t kind, uint8_t id);
/// Returns the object of a node; it is made if it does not exist.
scripted_object_t* scripted_object(scripted_node_t* node, uint16_t index, uint8_t subindex);
/// Read the frames of the flight software and answer them. Without a plugged node, the flight software gets
/// the error that no node acknowledged.
void scripted_bus_run(scripted_bus_t* bus);
/// Each plugged node sends a heartbeat.
void scripted_bus_heartbeat(scripted_bus_t* bus);
/// Send any frame to the flight software.
void scripted_bus_deliver(scripted_bus_t* bus, uint32_t id, const uint8_t* octets, uint8_t length);
void scripted_bus_emergency(scripted_bus_t* bus, uint8_t node, uint16_t code);
/// Send an error frame of the flight software's controller; class as in osal/include/osal/can.h, detail in
/// data[1].
void scripted_bus_error(scripted_bus_t* bus, uint32_t class, uint8_t detail);
/// Returns the number of frames seen with an identifier.
unsigned scripted_bus_count(const scripted_bus_t* bus, uint32_t id);

#endif // TEST_SUPPORT_SCRIPTED_BUS_H
