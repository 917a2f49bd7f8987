// SPDX-License-Identifier: Apache-2.0
/// A CAN bus in simulated time: controllers with transmit queues, arbitration by identifier, exact frame
/// times, acknowledge, error confinement, and seeded faults.
///
/// A node sends its frames in the order of submission. When the bus is idle, the first ready frames of all
/// queues compete, and the lowest arbitration field wins. Frames with equal identifiers become one frame on
/// the wire if their contents are equal; otherwise they destroy each other. A frame is received at the end of
/// its end-of-frame field, by all nodes except the sender; the next frame may start three bits later.
///
/// Callbacks run inside bus_run_until in the order of simulated time, and in the order of nodes at one
/// instant. They may submit frames and set wake times, but not in the past, and must not run or destroy the
/// bus. on_wake may also plug and unplug its own node.
///
/// Ownership  bus_create allocates everything; bus_destroy frees it.
/// Context    One task. Results depend on calls and seed only.
/// Time       About 0.2 us per frame with three nodes.
#ifndef SIM_BUS_BUS_H
#define SIM_BUS_BUS_H

#include "base/status.h"
#include "osal/include/osal/can.h"
#include "sim/bus/controller.h"

#include <stdbool.h>
#include <stdint.h>

#define BUS_NODES_MAX 20U
#define BUS_QUEUE_FRAMES 32U ///< Transmit queue of each controller.
#define BUS_NEVER UINT64_MAX

typedef struct bus bus_t;

typedef struct {
    uint32_t nominal_bit_rate; ///< Divides 10^9, e.g. 1 000 000.
    uint32_t data_bit_rate;    ///< Divides 10^9, e.g. 5 000 000; 0: classic bus.
    uint64_t seed;             ///< Seed of loss, corruption and duplication.
} bus_config_t;

/// Notifications of a node. Each may be null.
typedef struct {
    void (*on_frame)(void* context, const osal_can_frame_t* frame); ///< time_ns: end of frame.
    void (*on_error)(void* context, const osal_can_frame_t* frame); ///< Report of the node's own controller.
    void (*on_wake)(void* context, uint64_t now_ns); ///< The time set by bus_set_wake is reached.
    void* context;
} bus_callbacks_t;

/// Called for every frame on the wire and for the error reports of one node's controller, for logs.
/// `senders`: bit set of the nodes that have sent the frame, 1 << node; 0: an error report.
typedef void (*bus_tap_t)(void* context, uint32_t senders, const osal_can_frame_t* frame);

typedef struct {
    uint64_t frames;  ///< Sent successfully; a frame of the duplication fault counts each time.
    uint64_t errors;  ///< Error frames on the wire, except those of the duplication fault.
    uint64_t busy_ns; ///< Time of all frames and error frames, intermission included.
    uint64_t lost;    ///< Receptions suppressed by the loss fault.
    uint64_t refused; ///< Submissions refused: queue full, bus-off or unplugged.
    uint64_t
        longest_ns; ///< Longest time of a frame from being ready to a start of frame, repetitions included.
} bus_statistics_t;

/// Returns null if there is not enough memory, the nominal bit rate is 0, or a bit rate does not divide 10^9.
bus_t* bus_create(const bus_config_t* config);
void bus_destroy(bus_t* bus);

/// Add a controller. Returns STATUS_OK, STATUS_EXHAUSTED (BUS_NODES_MAX).
MUST_USE status_t bus_add_node(bus_t* bus, const bus_callbacks_t* callbacks, unsigned* out_node);
/// Remove a tool's controller permanently; the slot may be used again.
void bus_remove_node(bus_t* bus, unsigned node);

/// Queue a frame, ready at `time_ns` (at the present time if that is later). On a classic bus FD flags are
/// refused. Returns STATUS_OK, STATUS_FULL, STATUS_CLOSED (the node is unplugged or bus-off), STATUS_INVALID
/// (length, flags, an error frame; not counted in `refused`).
status_t bus_submit(bus_t* bus, unsigned node, const osal_can_frame_t* frame, uint64_t time_ns);
/// Returns the number of frames in the queue of a node, including the frame on the wire.
unsigned bus_queued(const bus_t* bus, unsigned node);
/// Call the node's on_wake at `time_ns`; BUS_NEVER cancels. A new time replaces the earlier time of the node.
void bus_set_wake(bus_t* bus, unsigned node, uint64_t time_ns);

/// Simulate the bus over [present time, time_ns).
void bus_run_until(bus_t* bus, uint64_t time_ns);
uint64_t bus_now_ns(const bus_t* bus);
/// Returns the number of controllers that are bus-off.
unsigned bus_off_count(const bus_t* bus);
/// True on a bus with FD bit timing.
bool bus_is_fd(const bus_t* bus);

/// Disconnect a node: its frame on the wire is destroyed, its queue is lost, and it neither sends nor
/// receives. Its on_wake is still called.
void bus_unplug(bus_t* bus, unsigned node);
/// Connect a node again; its error counters start at zero.
void bus_plug(bus_t* bus, unsigned node);
bool bus_is_plugged(const bus_t* bus, unsigned node);
const controller_t* bus_controller(const bus_t* bus, unsigned node);

/// Faults. Each lasts until it is set to zero or false. Probabilities are per frame, 0..1.
void bus_set_loss(bus_t* bus, double probability);       ///< Drawn for each receiver separately.
void bus_set_corruption(bus_t* bus, double probability); ///< Error frame, then repetition.
void bus_set_duplication(bus_t* bus,
                         double probability); ///< Error in the last bit: sent again, although received.
void bus_set_delay(bus_t* bus, unsigned node, uint64_t delay_ns); ///< Frames of the node are ready later.
void bus_set_babbling(bus_t* bus, unsigned node, bool on);        ///< Sends identifier 0 all the time.
void bus_set_stuck(bus_t* bus, bool on);                          ///< The wire is permanently dominant.
void bus_lose_next(bus_t* bus, unsigned node,
                   unsigned frames);           ///< The receiver of the node loses this number of frames.
void bus_force_off(bus_t* bus, unsigned node); ///< Transmit errors take this node off the bus.

/// Set how a controller's driver ends bus-off: automatically after 128 times 11 bits (the default), or 128
/// times 11 bits after bus_restart.
void bus_set_restart(bus_t* bus, unsigned node, bool is_automatic);
void bus_restart(bus_t* bus, unsigned node);
/// Report each arbitration that the node loses (off by default, as with most drivers).
void bus_set_arbitration_reports(bus_t* bus, unsigned node, bool on);
/// Report a frame that waits longer than this in the transmit queue; 0 (default): none.
void bus_set_transmit_timeout(bus_t* bus, unsigned node, uint64_t timeout_ns);

/// Set the function that gets the frames on the wire and the error reports of node `reporter`; null: none.
void bus_set_tap(bus_t* bus, bus_tap_t tap, void* context, unsigned reporter);
const bus_statistics_t* bus_statistics(const bus_t* bus);

#endif // SIM_BUS_BUS_H
