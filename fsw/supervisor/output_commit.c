// SPDX-License-Identifier: Apache-2.0
// Outputs of a step of the supervisor: frames to subsystems, and orders to their processes. They are part of
// the commit, and are performed after it. If a supervisor dies before the commit, the step had no output and
// the next supervisor repeats it; if it dies later, the next one performs the remaining outputs. One output
// may be performed twice, because it was performed but not noted: the receiver drops a frame with a known
// sequence number, and a repeated order changes nothing.
#include "fsw/supervisor/supervisor_internal.h"

#include "base/assertion.h"
#include "base/octets.h"

#include <string.h>

#define NO_RECEIVER 0U ///< Value instead of a receiver, if the output is an order to a process.
#define HEAD_OCTETS 2U
#define ORDER_OCTETS 15U

typedef enum {
    ORDER_START = 1,
    ORDER_STOP,
    ORDER_KILL,
    ORDER_FINISH
} order_t;

static status_t keep_frame(void* const context, const uint16_t to, const uint8_t* const frame,
                           const size_t size)
{
    supervisor_t* const supervisor = (supervisor_t*)context;
    uint8_t head[HEAD_OCTETS];
    octets_put_u16(head, to);
    return message_ring_put_parts(&supervisor->outputs, head, sizeof head, frame, size);
}

void supervisor_output_commit_init(supervisor_t* const supervisor)
{
    message_ring_init(&supervisor->outputs, supervisor->output_storage, sizeof supervisor->output_storage);
    message_divert(supervisor->config.endpoint, (message_carrier_t){supervisor, keep_frame});
}

static void send_order(supervisor_t* const supervisor, const order_t order, const uint16_t apid,
                       const uint32_t link_floor, const uint64_t boot_ns)
{
    uint8_t octets[ORDER_OCTETS];
    octet_writer_t writer = octet_writer(octets, sizeof octets);
    octet_write_u8(&writer, (uint8_t)order);
    octet_write_u16(&writer, apid);
    octet_write_u32(&writer, link_floor);
    octet_write_u64(&writer, boot_ns);
    const status_t status = keep_frame(supervisor, NO_RECEIVER, octets, writer.position);
    // There is room: the windows limit the number of frames, and the remaining room is for orders.
    FSW_ASSERT(status == STATUS_OK);
}

void supervisor_output_commit_start(supervisor_t* const supervisor, registry_entry_t* const entry)
{
    entry->presumed = PRESUMED_RUNNING;
    send_order(supervisor, ORDER_START, entry->mission->apid, supervisor->link_epoch,
               (uint64_t)entry->mission->boot_time_us * 1000U);
}

void supervisor_output_commit_stop(supervisor_t* const supervisor, registry_entry_t* const entry,
                                   const bool is_hung)
{
    entry->presumed = PRESUMED_GONE;
    send_order(supervisor, is_hung ? ORDER_KILL : ORDER_STOP, entry->mission->apid, 0U, 0U);
}

void supervisor_output_commit_finish(supervisor_t* const supervisor)
{
    send_order(supervisor, ORDER_FINISH, SUPERVISOR_APID, 0U, 0U);
}

bool supervisor_output_commit_is_running(const supervisor_t* const supervisor,
                                         const registry_entry_t* const entry)
{
    const supervisor_platform_t* const platform = &supervisor->config.platform;
    return (entry->presumed == PRESUMED_NOTHING)
               ? platform->is_running(platform->context, entry->mission->apid)
               : (entry->presumed == PRESUMED_RUNNING);
}

/// Perform an order to a process. Returns the entry of a process that could not be started, or null.
static const registry_entry_t* carry_out(supervisor_t* const supervisor, const uint8_t* const octets,
                                         const size_t size)
{
    const supervisor_platform_t* const platform = &supervisor->config.platform;
    octet_reader_t reader                       = octet_reader(octets, size);
    const uint8_t order                         = octet_read_u8(&reader);
    const uint16_t apid                         = octet_read_u16(&reader);
    const uint32_t link_floor                   = octet_read_u32(&reader);
    const uint64_t boot_ns                      = octet_read_u64(&reader);
    registry_entry_t* const entry               = supervisor_registry_find(supervisor, apid);
    if (entry == NULL) {
        return NULL; // Only a damaged commit contains an unknown APID.
    }
    entry->presumed = PRESUMED_NOTHING;
    if (order == (uint8_t)ORDER_START) {
        const status_t status = platform->start(platform->context, apid, link_floor, boot_ns);
        // STATUS_EXISTS: the previous supervisor has performed it.
        return ((status != STATUS_OK) && (status != STATUS_EXISTS)) ? entry : NULL;
    }
    if (order == (uint8_t)ORDER_STOP) {
        platform->stop(platform->context, apid);
    } else if (order == (uint8_t)ORDER_KILL) {
        platform->kill(platform->context, apid);
    } else {
        platform->finished(platform->context);
    }
    return NULL;
}

/// Report the starts that failed. Called after all outputs, because the reports are outputs as well: they
/// must come after the frames that are put back.
static void report_failed_starts(supervisor_t* const supervisor, const bool* const has_failed)
{
    for (uint16_t i = 0U; i < supervisor->mission->subsystem_count; i++) {
        if (has_failed[i]) {
            supervisor_registry_start_failed(supervisor, &supervisor->registry[i]);
        }
    }
}

/// True if the frame was sent. If a peer cannot receive a frame now, its further frames wait as well, so
/// that their order is kept.
static bool is_taken(supervisor_t* const supervisor, bool* const is_full, const uint16_t to,
                     const uint8_t* const frame, const size_t size)
{
    *is_full = *is_full || (message_forward(supervisor->config.endpoint, to, frame, size) == STATUS_FULL);
    return !*is_full;
}

bool supervisor_output_commit_perform(supervisor_t* const supervisor)
{
    message_ring_t* const ring = &supervisor->outputs;
    const uint32_t count       = ring->blocks;
    bool is_full[MISSION_SUBSYSTEMS_MAX];
    bool has_failed[MISSION_SUBSYSTEMS_MAX];
    uint8_t head[HEAD_OCTETS];
    uint8_t frame[MESSAGE_FRAME_MAX];
    size_t size  = 0U;
    bool is_left = false;
    (void)memset(is_full, 0, sizeof is_full);
    (void)memset(has_failed, 0, sizeof has_failed);
    for (uint32_t i = 0U; i < count; i++) {
        status_t status = message_ring_take_parts(ring, head, sizeof head, frame, sizeof frame, &size);
        FSW_ASSERT((status == STATUS_OK) && (size >= sizeof head)); // Each entry begins with its head.
        size -= sizeof head;
        const uint16_t to                   = octets_u16_at(head);
        const registry_entry_t* const entry = supervisor_registry_find(supervisor, to);
        if (to == NO_RECEIVER) {
            const registry_entry_t* const failed = carry_out(supervisor, frame, size);
            if (failed != NULL) {
                has_failed[failed - supervisor->registry] = true;
            }
        } else if ((entry != NULL) &&
                   !is_taken(supervisor, &is_full[entry - supervisor->registry], to, frame, size)) {
            status  = message_ring_put_parts(ring, head, sizeof head, frame, size);
            is_left = (status == STATUS_OK);
        } else {
            // The output was performed.
        }
        // Only outputs before the first one that is left count, because the next life skips outputs from
        // the front.
        supervisor->performed += is_left ? 0U : 1U;
        if (supervisor->config.checkpoint != NULL) {
            supervisor_checkpoint_note_performed(supervisor->config.checkpoint, supervisor->performed);
        }
    }
    report_failed_starts(supervisor, has_failed);
    return is_left;
}

void supervisor_output_commit_resume(supervisor_t* const supervisor)
{
    uint8_t none         = 0U;
    size_t size          = 0U;
    const uint32_t count = supervisor_checkpoint_performed(supervisor->config.checkpoint);
    while ((supervisor->performed < count) &&
           (message_ring_take(&supervisor->outputs, &none, 0U, &size) != STATUS_EMPTY)) {
        supervisor->performed++;
    }
}
