// SPDX-License-Identifier: Apache-2.0
/// Internal data of a bus, shared by bus.c (frames on the wire) and bus_faults.c (commanded faults).
#ifndef SIM_BUS_BUS_INTERNAL_H
#define SIM_BUS_BUS_INTERNAL_H

#include "sim/bus/bus.h"
#include "sim/bus/random.h"

typedef struct {
    osal_can_frame_t frame;
    uint64_t ready_ns; // Earliest start of the frame.
    uint32_t key;      // Arbitration field as a number; the lower one wins.
} queued_t;

typedef struct {
    bool is_used;
    bool is_plugged;
    bool is_babbling;
    bool restarts_by_order; // Bus-off ends only after bus_restart.
    unsigned overflows;     // Number of next frames that this node loses, because its receiver has no room.
    controller_t controller;
    bus_callbacks_t callbacks;
    uint64_t wake_ns;    // Time of the next call of on_wake; BUS_NEVER: none.
    uint64_t recover_ns; // Time at which bus-off ends.
    uint64_t suspend_ns; // Earliest start of the next frame of this node.
    uint64_t delay_ns;   // Delay of each frame that the node sends: a fault.
    uint64_t timeout_ns; // A frame that waits longer is reported; 0: no reports.
    uint64_t watch_ns;   // Time of the next check of the oldest frame; BUS_NEVER: no frame waits.
    unsigned head;
    unsigned count;
    queued_t queue[BUS_QUEUE_FRAMES];
} bus_node_t;

typedef enum {
    OUTCOME_DELIVERED,
    OUTCOME_DESTROYED, // All nodes detect a bit error.
    OUTCOME_UNHEARD    // No node acknowledges.
} outcome_t;

struct bus {
    uint64_t nominal_ns; // Duration of one bit.
    uint64_t data_ns;    // Duration of one bit of the data phase; 0 on a classic bus.
    uint64_t now_ns;
    uint64_t idle_ns;       // Time from which the wire is free.
    uint64_t next_wake_ns;  // Next time at which a node or the stuck wire needs work.
    uint64_t stuck_tick_ns; // Time at which a stuck wire counts the next errors; BUS_NEVER: none.
    unsigned stuck_ticks;   // Number of times that the stuck wire has counted errors.
    bool is_stuck;
    bool is_sending;
    outcome_t outcome;
    // Bit sets of nodes, because looking at each node would take longer: nodes are large.
    uint32_t present;   // Plugged and not bus-off.
    uint32_t waiting;   // Has a frame to send, or babbles.
    uint32_t reporting; // Reports lost arbitrations to its software.
    uint32_t senders;   // The frame of the node is on the wire.
    uint64_t start_ns;
    uint64_t event_ns;     // Time at which the frame ends or is destroyed.
    osal_can_frame_t wire; // Frame on the wire.
    double loss;
    double corruption;
    double duplication;
    bus_random_t random;
    bus_tap_t tap;
    void* tap_context;
    unsigned reporter; // Node whose error reports the tap gets.
    bus_statistics_t statistics;
    unsigned node_count;
    bus_node_t node[BUS_NODES_MAX];
};

/// Account for an event in a controller and report it to its software and the tap if necessary.
void bus_account(bus_t* bus, unsigned index, controller_event_t event);
/// Report the state of a controller to its software and to the tap.
void bus_report(bus_t* bus, unsigned index, osal_can_frame_t* report);
/// Destroy the frame on the wire.
void bus_break_frame(bus_t* bus, controller_event_t sender_event);
void bus_find_next_wake(bus_t* bus);
void bus_drop_queue(bus_t* bus, unsigned index);
/// Update `waiting` after a change of a node's queue, or of its babbling.
void bus_note_waiting(bus_t* bus, unsigned index);
/// Update `present` after a node was plugged or unplugged, or after a change of its controller.
void bus_note_presence(bus_t* bus, unsigned index);

#endif // SIM_BUS_BUS_INTERNAL_H
