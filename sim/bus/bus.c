// SPDX-License-Identifier: Apache-2.0
#include "sim/bus/bus.h"

#include "sim/bus/bus_internal.h"
#include "sim/bus/frame_length.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_S 1000000000U
#define ERROR_FLAG_BITS 12U // Longest superposition of the error flags of all nodes.
#define ERROR_DELIMITER_BITS 8U
#define REPORT_RECEIVE_OVERFLOW 0x01U // data[1] of a SocketCAN controller report.
#define SUSPEND_BITS 8U               // An error-passive transmitter waits, so that others can start first.
#define STUCK_TICKS 600U // Octets of dominant bits after which every counter has its final value.

/// Copy the significant part of a frame.
static void copy_frame(osal_can_frame_t* const to, const osal_can_frame_t* const from)
{
    const size_t head = offsetof(osal_can_frame_t, data);
    if (from->length <= 8U) { // Nearly all frames: a copy of constant size is faster.
        memcpy(to, from, head + 8U);
    } else {
        memcpy(to, from, head + from->length);
    }
}

static const osal_can_frame_t babble = {.id = 0U, .length = 8U};

bus_t* bus_create(const bus_config_t* const config)
{
    const uint32_t nominal = config->nominal_bit_rate;
    const uint32_t data    = config->data_bit_rate;
    if ((nominal == 0U) || ((NS_PER_S % nominal) != 0U) || ((data != 0U) && ((NS_PER_S % data) != 0U))) {
        return NULL;
    }
    bus_t* bus = calloc(1U, sizeof *bus);
    if (bus == NULL) {
        return NULL;
    }
    bus->nominal_ns    = NS_PER_S / nominal;
    bus->data_ns       = (data != 0U) ? (NS_PER_S / data) : 0U;
    bus->next_wake_ns  = BUS_NEVER;
    bus->stuck_tick_ns = BUS_NEVER;
    bus->reporter      = BUS_NODES_MAX;
    bus_random_seed(&bus->random, config->seed);
    return bus;
}

void bus_destroy(bus_t* const bus)
{
    free(bus);
}

void bus_find_next_wake(bus_t* const bus)
{
    uint64_t next = bus->stuck_tick_ns;
    for (unsigned i = 0U; i < bus->node_count; i++) {
        const bus_node_t* node = &bus->node[i];
        next                   = (node->wake_ns < next) ? node->wake_ns : next;
        next                   = (node->recover_ns < next) ? node->recover_ns : next;
        next                   = (node->watch_ns < next) ? node->watch_ns : next;
    }
    bus->next_wake_ns = next;
}

status_t bus_add_node(bus_t* const bus, const bus_callbacks_t* const callbacks, unsigned* const out_node)
{
    unsigned index = 0U;
    while ((index < bus->node_count) && bus->node[index].is_used) {
        index++;
    }
    if (index == BUS_NODES_MAX) {
        return STATUS_EXHAUSTED;
    }
    if (index == bus->node_count) {
        bus->node_count++;
    }
    bus_node_t* node = &bus->node[index];
    memset(node, 0, sizeof *node);
    node->is_used    = true;
    node->is_plugged = true;
    node->callbacks  = *callbacks;
    node->wake_ns    = BUS_NEVER;
    node->recover_ns = BUS_NEVER;
    node->watch_ns   = BUS_NEVER;
    controller_reset(&node->controller);
    bus->reporting &= ~(1U << index);
    bus_note_presence(bus, index);
    bus_note_waiting(bus, index);
    *out_node = index;
    return STATUS_OK;
}

void bus_remove_node(bus_t* const bus, const unsigned node)
{
    bus_unplug(bus, node);
    bus->node[node].is_used = false;
    bus->node[node].wake_ns = BUS_NEVER;
    bus_find_next_wake(bus);
}

static bool is_member(const uint32_t set, const unsigned index)
{
    return ((set >> index) & 1U) != 0U;
}

void bus_note_presence(bus_t* const bus, const unsigned index)
{
    const bus_node_t* node = &bus->node[index];
    const uint32_t bit     = 1U << index;
    const bool is_present  = node->is_plugged && (node->controller.state != CONTROLLER_STATE_BUS_OFF);
    bus->present           = is_present ? (bus->present | bit) : (bus->present & ~bit);
}

/// Arbitration field, most significant bit first: 11 bits, RTR or SRR, IDE, 18 bits, RTR.
static uint32_t arbitration_key(const osal_can_frame_t* const frame)
{
    const uint32_t id     = frame->id & OSAL_CAN_ID_MASK;
    const uint32_t remote = ((frame->id & OSAL_CAN_REMOTE) != 0U) ? 1U : 0U;
    if ((frame->id & OSAL_CAN_EXTENDED) == 0U) {
        return ((id & 0x7FFU) << 21) | (remote << 20);
    }
    return ((id >> 18) << 21) | (3U << 19) | ((id & 0x3FFFFU) << 1) | remote;
}

static bool is_valid(const bus_t* const bus, const osal_can_frame_t* const frame)
{
    if ((frame->id & OSAL_CAN_ERROR) != 0U) {
        return false;
    }
    if ((frame->flags & OSAL_CAN_FLAG_FD) == 0U) {
        return frame->length <= 8U;
    }
    return (bus->data_ns != 0U) && ((frame->id & OSAL_CAN_REMOTE) == 0U) &&
           (frame->length <= OSAL_CAN_DATA_MAX) && (frame->length == frame_fd_length(frame->length));
}

status_t bus_submit(bus_t* const bus, const unsigned index, const osal_can_frame_t* const frame,
                    const uint64_t time_ns)
{
    bus_node_t* node = &bus->node[index];
    if (!is_valid(bus, frame)) {
        return STATUS_INVALID;
    }
    if (!is_member(bus->present, index)) {
        bus->statistics.refused++;
        return STATUS_CLOSED;
    }
    if (node->count == BUS_QUEUE_FRAMES) {
        bus->statistics.refused++;
        return STATUS_FULL;
    }
    queued_t* entry = &node->queue[(node->head + node->count) % BUS_QUEUE_FRAMES];
    copy_frame(&entry->frame, frame);
    entry->ready_ns = ((time_ns > bus->now_ns) ? time_ns : bus->now_ns) + node->delay_ns;
    entry->key      = arbitration_key(frame);
    node->count++;
    bus_note_waiting(bus, index);
    if ((node->timeout_ns != 0U) && (node->watch_ns == BUS_NEVER)) {
        node->watch_ns    = entry->ready_ns + node->timeout_ns;
        bus->next_wake_ns = (node->watch_ns < bus->next_wake_ns) ? node->watch_ns : bus->next_wake_ns;
    }
    return STATUS_OK;
}

unsigned bus_queued(const bus_t* const bus, const unsigned node)
{
    return bus->node[node].count;
}

void bus_set_wake(bus_t* const bus, const unsigned node, const uint64_t time_ns)
{
    bus->node[node].wake_ns = time_ns;
    bus_find_next_wake(bus);
}

void bus_note_waiting(bus_t* const bus, const unsigned index)
{
    const bus_node_t* node = &bus->node[index];
    const uint32_t bit     = 1U << index;
    bus->waiting = ((node->count != 0U) || node->is_babbling) ? (bus->waiting | bit) : (bus->waiting & ~bit);
}

static void pop(bus_t* const bus, const unsigned index)
{
    bus_node_t* node = &bus->node[index];
    node->head       = (node->head + 1U) % BUS_QUEUE_FRAMES;
    node->count--;
    bus_note_waiting(bus, index);
}

void bus_drop_queue(bus_t* const bus, const unsigned index)
{
    bus_node_t* node = &bus->node[index];
    node->head       = 0U;
    node->count      = 0U;
    bus_note_waiting(bus, index);
}

void bus_report(bus_t* const bus, const unsigned index, osal_can_frame_t* const report)
{
    const bus_node_t* node = &bus->node[index];
    report->time_ns        = bus->now_ns;
    if (node->callbacks.on_error != NULL) {
        node->callbacks.on_error(node->callbacks.context, report);
    }
    if ((bus->tap != NULL) && (index == bus->reporter)) {
        bus->tap(bus->tap_context, 0U, report);
    }
}

/// Report an event that does not change the controller's state.
static void report_event(bus_t* const bus, const unsigned index, const uint32_t class, const uint8_t position,
                         const uint8_t detail)
{
    osal_can_frame_t report = controller_report(&bus->node[index].controller, class);
    report.data[0]          = position;
    report.data[1]          = detail;
    bus_report(bus, index, &report);
}

void bus_account(bus_t* const bus, const unsigned index, const controller_event_t event)
{
    bus_node_t* node = &bus->node[index];
    osal_can_frame_t report;
    if (!controller_apply(&node->controller, event, &report)) {
        return;
    }
    bus_note_presence(bus, index);
    if ((node->controller.state == CONTROLLER_STATE_BUS_OFF) && (event != CONTROLLER_RECOVERED)) {
        bus_drop_queue(bus, index);
        node->recover_ns = node->restarts_by_order
                               ? BUS_NEVER
                               : (bus->now_ns + (CONTROLLER_RECOVERY_BITS * bus->nominal_ns));
        bus_find_next_wake(bus);
    }
    bus_report(bus, index, &report);
}

static void account_all(bus_t* const bus, const controller_event_t sender_event,
                        const controller_event_t receiver_event)
{
    for (unsigned i = 0U; i < bus->node_count; i++) {
        if (is_member(bus->present, i)) {
            bus_account(bus, i, is_member(bus->senders, i) ? sender_event : receiver_event);
        }
    }
}

/// Returns the earliest start of the next frame of a node that has one to send; BUS_NEVER if the node is off
/// the bus.
static uint64_t ready_ns(const bus_t* const bus, const unsigned index)
{
    const bus_node_t* node = &bus->node[index];
    if (!is_member(bus->present, index)) {
        return BUS_NEVER;
    }
    const uint64_t ready = node->is_babbling ? bus->idle_ns : node->queue[node->head].ready_ns;
    return (ready > node->suspend_ns) ? ready : node->suspend_ns;
}

static uint64_t next_start_ns(const bus_t* const bus)
{
    uint64_t earliest = BUS_NEVER;
    for (unsigned i = 0U; (bus->waiting >> i) != 0U; i++) {
        if (!is_member(bus->waiting, i)) {
            continue;
        }
        const uint64_t ready = ready_ns(bus, i);
        earliest             = (ready < earliest) ? ready : earliest;
    }
    return (earliest > bus->idle_ns) ? earliest : bus->idle_ns;
}

static const osal_can_frame_t* head_frame(const bus_node_t* const node)
{
    return node->is_babbling ? &babble : &node->queue[node->head].frame;
}

static bool is_equal(const osal_can_frame_t* const a, const osal_can_frame_t* const b)
{
    return (a->id == b->id) && (a->length == b->length) && (a->flags == b->flags) &&
           (memcmp(a->data, b->data, a->length) == 0);
}

/// Find the nodes with the lowest arbitration field (several if their fields are equal). Sets senders and
/// outcome.
static const bus_node_t* arbitrate(bus_t* const bus, const uint64_t start_ns)
{
    const bus_node_t* winner = NULL;
    uint32_t lowest          = UINT32_MAX;
    bus->outcome             = OUTCOME_DELIVERED;
    bus->senders             = 0U;
    for (unsigned i = 0U; (bus->waiting >> i) != 0U; i++) {
        const bus_node_t* node = &bus->node[i];
        if (!is_member(bus->waiting, i) || (ready_ns(bus, i) > start_ns)) {
            continue;
        }
        const uint32_t key = node->is_babbling ? 0U : node->queue[node->head].key;
        if ((winner == NULL) || (key < lowest)) {
            winner       = node;
            lowest       = key;
            bus->senders = 1U << i;
            bus->outcome = OUTCOME_DELIVERED;
        } else if (key == lowest) {
            bus->senders |= 1U << i;
            if (!is_equal(head_frame(winner), head_frame(node))) {
                bus->outcome = OUTCOME_DESTROYED;
            }
        }
    }
    return winner;
}

static bool has_receiver(const bus_t* const bus)
{
    return (bus->present & ~bus->senders) != 0U;
}

/// Report a lost arbitration to each node that had a frame ready, with the first bit that differs from the
/// winner's frame.
static void report_lost_arbitration(bus_t* const bus, const uint64_t start_ns, const uint32_t winning_key)
{
    for (unsigned i = 0U; (bus->reporting >> i) != 0U; i++) {
        if (is_member(bus->reporting & ~bus->senders & bus->waiting, i) && (ready_ns(bus, i) <= start_ns)) {
            const bus_node_t* node    = &bus->node[i];
            const uint32_t difference = node->queue[node->head].key ^ winning_key;
            uint8_t bit               = 0U;
            while ((bit < 31U) && ((difference & (0x80000000U >> bit)) == 0U)) {
                bit++;
            }
            report_event(bus, i, OSAL_CAN_ERROR_LOST_ARBITRATION, bit, 0U);
        }
    }
}

static void start_frame(bus_t* const bus, const uint64_t start_ns)
{
    const bus_node_t* winner     = arbitrate(bus, start_ns);
    const osal_can_frame_t* head = head_frame(winner);
    copy_frame(&bus->wire, head);
    report_lost_arbitration(bus, start_ns, arbitration_key(head));
    if ((winner->controller.state == CONTROLLER_STATE_PASSIVE) && ((head->flags & OSAL_CAN_FLAG_FD) != 0U)) {
        bus->wire.flags |= OSAL_CAN_FLAG_ESI;
    }
    const frame_length_t length = frame_length(&bus->wire);
    const uint64_t duration     = (length.nominal_bits * bus->nominal_ns) + (length.data_bits * bus->data_ns);
    bus->is_sending             = true;
    bus->start_ns               = start_ns;
    bus->event_ns               = start_ns + duration;
    if (!winner->is_babbling) {
        const uint64_t waited = start_ns - winner->queue[winner->head].ready_ns;
        bus->statistics.longest_ns =
            (waited > bus->statistics.longest_ns) ? waited : bus->statistics.longest_ns;
    }
    if ((bus->outcome != OUTCOME_DESTROYED) && !has_receiver(bus)) {
        bus->outcome  = OUTCOME_UNHEARD;
        bus->event_ns = start_ns + duration - (CAN_TAIL_BITS * bus->nominal_ns);
    } else if (bus_random_chance(&bus->random, bus->corruption)) {
        const uint64_t bits = (duration / bus->nominal_ns) - 1U;
        bus->outcome        = OUTCOME_DESTROYED;
        bus->event_ns       = start_ns + ((1U + (bus_random_next(&bus->random) % bits)) * bus->nominal_ns);
    }
}

/// Make the wire free `bits` after now; error-passive senders must wait longer.
static void end_frame(bus_t* const bus, const uint64_t bits)
{
    bus->is_sending = false;
    bus->idle_ns    = bus->now_ns + (bits * bus->nominal_ns);
    bus->statistics.busy_ns += bus->idle_ns - bus->start_ns;
    for (unsigned i = 0U; (bus->senders >> i) != 0U; i++) {
        if (is_member(bus->senders, i) && (bus->node[i].controller.state == CONTROLLER_STATE_PASSIVE)) {
            bus->node[i].suspend_ns = bus->idle_ns + (SUSPEND_BITS * bus->nominal_ns);
        }
    }
}

void bus_break_frame(bus_t* const bus, const controller_event_t sender_event)
{
    bus->statistics.errors++;
    account_all(bus, sender_event, CONTROLLER_RECEIVE_ERROR);
    end_frame(bus, ERROR_FLAG_BITS + ERROR_DELIMITER_BITS + CAN_INTERMISSION_BITS);
}

static void deliver(bus_t* const bus, const unsigned index)
{
    bus_node_t* node = &bus->node[index];
    if (bus_random_chance(&bus->random, bus->loss)) {
        bus->statistics.lost++;
        return;
    }
    if (node->controller.receive_errors != 0U) {
        bus_account(bus, index, CONTROLLER_RECEIVED);
    }
    if (node->overflows != 0U) { // The frame is acknowledged on the wire, but the receiver has no room.
        node->overflows--;
        report_event(bus, index, OSAL_CAN_ERROR_CONTROLLER, 0U, REPORT_RECEIVE_OVERFLOW);
        return;
    }
    if (node->callbacks.on_frame != NULL) {
        node->callbacks.on_frame(node->callbacks.context, &bus->wire);
    }
}

static void deliver_frame(bus_t* const bus)
{
    bus->wire.time_ns = bus->now_ns;
    bus->statistics.frames++;
    if (bus->tap != NULL) {
        bus->tap(bus->tap_context, bus->senders, &bus->wire);
    }
    // A sender that detects an error in the last bit repeats a frame that all receivers have taken already.
    const bool is_repeated = bus_random_chance(&bus->random, bus->duplication);
    const uint32_t senders = bus->senders;
    for (unsigned i = 0U; !is_repeated && ((senders >> i) != 0U); i++) {
        if (is_member(senders, i) && !bus->node[i].is_babbling) {
            pop(bus, i);
        }
    }
    end_frame(bus, is_repeated ? (ERROR_FLAG_BITS + ERROR_DELIMITER_BITS + CAN_INTERMISSION_BITS)
                               : CAN_INTERMISSION_BITS);
    for (unsigned i = 0U; i < bus->node_count; i++) {
        if (is_member(senders, i)) {
            bus_account(bus, i, is_repeated ? CONTROLLER_TRANSMIT_ERROR : CONTROLLER_TRANSMITTED);
        } else if (is_member(bus->present, i)) {
            deliver(bus, i);
        }
    }
}

static void finish_frame(bus_t* const bus)
{
    if (bus->outcome == OUTCOME_DESTROYED) {
        bus_break_frame(bus, CONTROLLER_TRANSMIT_ERROR);
    } else if ((bus->outcome == OUTCOME_UNHEARD) || !has_receiver(bus)) {
        bus_break_frame(bus, CONTROLLER_NO_ACK);
    } else {
        deliver_frame(bus);
    }
}

/// Eight dominant bits of a stuck wire have passed: count one error in every sender and receiver.
static void tick_stuck(bus_t* const bus)
{
    bus->stuck_ticks++;
    bus->stuck_tick_ns =
        (bus->stuck_ticks < STUCK_TICKS) ? (bus->now_ns + (8U * bus->nominal_ns)) : BUS_NEVER;
    account_all(bus, CONTROLLER_TRANSMIT_ERROR, CONTROLLER_RECEIVE_ERROR);
}

/// Check whether the oldest frame has waited too long. Since the check was set, another frame may have become
/// the oldest.
static void watch_queue(bus_t* const bus, const unsigned index, const uint64_t now_ns)
{
    bus_node_t* node = &bus->node[index];
    node->watch_ns   = BUS_NEVER;
    if ((node->count == 0U) || (node->timeout_ns == 0U)) {
        return;
    }
    const uint64_t limit_ns = node->queue[node->head].ready_ns + node->timeout_ns;
    if (limit_ns > now_ns) {
        node->watch_ns = limit_ns;
    } else { // One report for this wait. The next submitted frame sets the time of the check.
        report_event(bus, index, OSAL_CAN_ERROR_TX_TIMEOUT, 0U, 0U);
    }
}

static void wake_node(bus_t* const bus, const unsigned index, const uint64_t now_ns)
{
    bus_node_t* node = &bus->node[index];
    if (node->watch_ns <= now_ns) {
        watch_queue(bus, index, now_ns);
    }
    if (node->recover_ns <= now_ns) {
        if (bus->is_stuck) { // A stuck wire has no recessive bits to count.
            node->recover_ns = now_ns + (CONTROLLER_RECOVERY_BITS * bus->nominal_ns);
        } else {
            node->recover_ns = BUS_NEVER;
            bus_account(bus, index, CONTROLLER_RECOVERED);
        }
    }
    if (node->wake_ns <= now_ns) {
        node->wake_ns = BUS_NEVER;
        if (node->callbacks.on_wake != NULL) {
            node->callbacks.on_wake(node->callbacks.context, now_ns);
        }
    }
}

static void wake_nodes(bus_t* const bus)
{
    const uint64_t now_ns = bus->now_ns;
    if (bus->stuck_tick_ns <= now_ns) {
        tick_stuck(bus);
    }
    for (unsigned i = 0U; i < bus->node_count; i++) {
        wake_node(bus, i, now_ns);
    }
    bus_find_next_wake(bus);
}

void bus_run_until(bus_t* const bus, const uint64_t time_ns)
{
    for (;;) {
        uint64_t wire_ns = bus->event_ns;
        if (!bus->is_sending) {
            wire_ns = bus->is_stuck ? BUS_NEVER : next_start_ns(bus);
        }
        const uint64_t next_ns = (bus->next_wake_ns <= wire_ns) ? bus->next_wake_ns : wire_ns;
        if (next_ns >= time_ns) {
            break;
        }
        bus->now_ns = (next_ns > bus->now_ns) ? next_ns : bus->now_ns;
        if (bus->next_wake_ns <= wire_ns) {
            wake_nodes(bus);
        } else if (bus->is_sending) {
            finish_frame(bus);
        } else {
            start_frame(bus, bus->now_ns);
        }
    }
    bus->now_ns = (time_ns > bus->now_ns) ? time_ns : bus->now_ns;
}

uint64_t bus_now_ns(const bus_t* const bus)
{
    return bus->now_ns;
}

unsigned bus_off_count(const bus_t* const bus)
{
    unsigned count = 0U;
    for (unsigned i = 0U; i < bus->node_count; i++) {
        count += (bus->node[i].controller.state == CONTROLLER_STATE_BUS_OFF) ? 1U : 0U;
    }
    return count;
}

bool bus_is_fd(const bus_t* const bus)
{
    return bus->data_ns != 0U;
}

void bus_set_tap(bus_t* const bus, const bus_tap_t tap, void* const context, const unsigned reporter)
{
    bus->tap         = tap;
    bus->tap_context = context;
    bus->reporter    = reporter;
}

const bus_statistics_t* bus_statistics(const bus_t* const bus)
{
    return &bus->statistics;
}
