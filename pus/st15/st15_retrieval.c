// SPDX-License-Identifier: Apache-2.0
// Each step performs a slice of the retrievals and of the copy.
#include "base/assertion.h"
#include "pus/st01/st01_verification.h"
#include "pus/st15/st15_internal.h"

/// Packets and octets that the present step may still use.
typedef struct {
    uint16_t packets; ///< Packets that may still be sent or copied.
    uint32_t octets;  ///< Octets that may still be read.
} budget_t;

static void spend(budget_t* const budget, const size_t octets)
{
    budget->octets = (octets < budget->octets) ? (uint32_t)(budget->octets - octets) : 0U;
}

static budget_t budget_of(const pus_storage_t* const storage)
{
    return (budget_t){.packets = storage->config.packets_per_step, .octets = storage->config.octets_per_step};
}

/// A window selects the packets before an address whose storage times are in a range.
typedef struct {
    uint64_t end;
    uint64_t from_ns;
    uint64_t to_ns;
} window_t;

/// Read the next packet in a window. STATUS_OK; STATUS_BUSY (the packet is outside of the window, or the rest
/// of the block is damaged: continue); STATUS_EMPTY (no further packet); STATUS_IO.
static status_t next_in(pus_packet_store_t* const log, const window_t* const window, uint64_t* const cursor,
                        budget_t* const budget, pus_stored_packet_t* const out_packet)
{
    *cursor = pus_packet_store_seek(log, *cursor, window->from_ns, window->to_ns);
    if (*cursor >= window->end) {
        return STATUS_EMPTY;
    }
    const status_t status = pus_packet_store_next(log, cursor, out_packet);
    if (status == STATUS_CHECKSUM) {
        spend(budget, PUS_STORE_BLOCK);
        return STATUS_BUSY;
    }
    if (status == STATUS_OK) {
        spend(budget, out_packet->size);
        const bool is_inside =
            (out_packet->time_ns >= window->from_ns) && (out_packet->time_ns <= window->to_ns);
        return is_inside ? STATUS_OK : STATUS_BUSY;
    }
    return status;
}

// ---- Retrieval ----

/// Returns the store that sends next: among the stores with the lowest priority number, the next one after
/// `last_served`. store_count if no store can send.
static uint8_t next_store(const pus_storage_t* const storage)
{
    const uint8_t count = storage->config.store_count;
    uint8_t best        = count;
    for (uint8_t i = 1U; i <= count; i++) {
        const uint8_t number           = (uint8_t)((storage->last_served + i) % count);
        const pus_store_t* const store = &storage->stores[number];
        const bool is_ready = (store->state.retrieval != (uint8_t)PUS_RETRIEVAL_NONE) && !store->is_waiting;
        if (is_ready && ((best == count) || (store->state.priority < storage->stores[best].state.priority))) {
            best = number;
        }
    }
    return best;
}

/// Note the position of a retrieval after a packet was sent, or was skipped (`packet` is null).
static void advance(pus_store_t* const store, const uint64_t cursor, const pus_stored_packet_t* const packet)
{
    pus_store_state_t* const state = &store->state;
    store->is_moved                = true;
    if (state->retrieval == (uint8_t)PUS_RETRIEVAL_RANGE) {
        state->range_cursor = cursor;
        return;
    }
    state->open_cursor = cursor;
    if (packet != NULL) {
        state->open_tag_ns = packet->time_ns;
        state->is_seeking  = false;
    }
}

/// Pause the retrieval of a store that has no more packets to send; a retrieval by time range ends.
static void pause(pus_storage_t* const storage, pus_store_t* const store)
{
    store->is_waiting = true;
    if (store->state.retrieval == (uint8_t)PUS_RETRIEVAL_RANGE) {
        store->state.retrieval     = (uint8_t)PUS_RETRIEVAL_NONE;
        store->is_moved            = true;
        storage->is_checkpoint_due = true; // Store the end of the retrieval at once.
    }
}

/// Send one packet of a store.
static void serve(pus_storage_t* const storage, const uint8_t number, budget_t* const budget)
{
    pus_store_t* const store               = &storage->stores[number];
    const pus_store_state_t* const state   = &store->state;
    const pus_retrieval_port_t* const port = &storage->config.port;
    window_t window                        = {.end = UINT64_MAX, .from_ns = 0U, .to_ns = UINT64_MAX};
    uint64_t cursor                        = state->open_cursor;
    if (state->retrieval == (uint8_t)PUS_RETRIEVAL_RANGE) {
        window = (window_t){.end = state->range_end, .from_ns = state->from_ns, .to_ns = state->to_ns};
        cursor = state->range_cursor;
    } else if (state->is_seeking) {
        window.from_ns = state->open_tag_ns;
    } else {
        // An open retrieval sends all packets from the cursor on.
    }
    pus_stored_packet_t packet;
    const status_t status = next_in(&store->log, &window, &cursor, budget, &packet);
    switch (status) {
    case STATUS_OK:
        if (port->send(port->context, state->virtual_channel, packet.packet, packet.size) == STATUS_OK) {
            store->sent++;
            storage->last_served = number;
            budget->packets--;
            advance(store, cursor, &packet);
        } else {
            storage->counters.refused++;
            store->is_waiting = true;
        }
        break;
    case STATUS_BUSY:
        advance(store, cursor, NULL);
        break;
    case STATUS_EMPTY:
        pause(storage, store);
        break;
    default: // The medium failed: the next step tries again.
        store->is_waiting = true;
        break;
    }
}

void st15_retrieve(pus_storage_t* const storage)
{
    budget_t budget = budget_of(storage);
    for (uint8_t i = 0U; i < storage->config.store_count; i++) {
        storage->stores[i].is_waiting = false;
    }
    uint8_t number = next_store(storage);
    while ((number < storage->config.store_count) && (budget.packets > 0U) && (budget.octets > 0U)) {
        serve(storage, number, &budget);
        number = next_store(storage);
    }
}

// ---- Copy ----

/// End the copy and report the result.
static void end_copy(pus_storage_t* const storage, const status_t status, const uint64_t now_ns)
{
    pus_store_copy_t* const copy = &storage->copy;
    pus_failure_t failure        = pus_no_failure();
    if (status == STATUS_FULL) {
        failure = pus_failure(PUS_FAILURE_TABLE_FULL, copy->copied);
    } else if (status != STATUS_OK) {
        failure = pus_failure(PUS_FAILURE_IO, (uint32_t)status);
    } else {
        // The copy has succeeded.
    }
    copy->is_active = false;
    pus_verify_ended(storage->config.process, &copy->token, failure, now_ns);
}

/// Copy one packet. STATUS_OK or STATUS_BUSY: continue; STATUS_EMPTY: all packets are copied; STATUS_FULL,
/// STATUS_IO.
static status_t copy_one(pus_storage_t* const storage, budget_t* const budget)
{
    pus_store_copy_t* const copy = &storage->copy;
    const window_t window        = {.end = copy->end, .from_ns = copy->from_ns, .to_ns = copy->to_ns};
    pus_stored_packet_t packet;
    status_t status = next_in(&storage->stores[copy->source].log, &window, &copy->cursor, budget, &packet);
    if (status == STATUS_OK) {
        status = pus_packet_store_append(&storage->stores[copy->target].log, packet.time_ns, packet.packet,
                                         packet.size);
        budget->packets--;
        copy->copied += (status == STATUS_OK) ? 1U : 0U;
    }
    return status;
}

void st15_copy(pus_storage_t* const storage, const uint64_t now_ns)
{
    const pus_store_copy_t* const copy = &storage->copy;
    budget_t budget                    = budget_of(storage);
    status_t status                    = STATUS_BUSY;
    while (copy->is_active && ((status == STATUS_OK) || (status == STATUS_BUSY)) && (budget.packets > 0U) &&
           (budget.octets > 0U)) {
        status = copy_one(storage, &budget);
    }
    if (status == STATUS_EMPTY) {
        end_copy(storage, pus_packet_store_sync(&storage->stores[copy->target].log), now_ns);
    } else if ((status != STATUS_OK) && (status != STATUS_BUSY)) {
        end_copy(storage, status, now_ns);
    } else {
        // Later steps continue the copy.
    }
}
