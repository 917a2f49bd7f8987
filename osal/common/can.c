// SPDX-License-Identifier: Apache-2.0
// Implements osal/can.h: selects the carrier from the address, checks lengths and applies filters; the
// carrier transfers the frames.
#include "osal/include/osal/can.h"

#include "base/assertion.h"
#include "osal/include/osal/can_interface.h"
#include "osal/include/osal/shm.h"
#include "osal/common/can_port.h"

#include <string.h>

#define ADDRESS_LENGTH_MAX 64U
#define CLASSIC_LENGTH_MAX 8U

typedef struct {                          // Parts of an address; "" for a part that it does not have.
    char shared[ADDRESS_LENGTH_MAX + 1U]; ///< Name of the shared memory, "/NAME".
    char interface[OSAL_CAN_INTERFACE_NAME_MAX + 1U];
} address_parts_t;

/// Split an address into its parts. STATUS_OK, STATUS_INVALID.
static status_t split_address(const char* const address, address_parts_t* const out_parts)
{
    *out_parts          = (address_parts_t){.shared = ""};
    const bool is_shm   = (strncmp(address, "shm:", 4U) == 0);
    const size_t length = strlen(address);
    if ((length > ADDRESS_LENGTH_MAX) || (!is_shm && (strncmp(address, "can:", 4U) != 0))) {
        return STATUS_INVALID;
    }
    const char* const rest = &address[4];
    const char* const at   = is_shm ? rest : strchr(rest, '@');
    const char* const name = is_shm ? rest : ((at != NULL) ? &at[1] : NULL);
    if (name != NULL) {
        out_parts->shared[0] = '/';
        (void)memcpy(&out_parts->shared[1], name, strlen(name) + 1U);
    }
    if (!is_shm) {
        const size_t size = (at != NULL) ? (size_t)(at - rest) : strlen(rest);
        if ((size == 0U) || (size > OSAL_CAN_INTERFACE_NAME_MAX)) {
            return STATUS_INVALID;
        }
        (void)memcpy(out_parts->interface, rest, size);
    }
    return STATUS_OK;
}

status_t osal_can_create(const char* const address)
{
    FSW_ASSERT(address != NULL);
    address_parts_t parts;
    if ((split_address(address, &parts) != STATUS_OK) || (strlen(parts.shared) == 0U)) {
        return STATUS_INVALID;
    }
    return (strlen(parts.interface) == 0U) ? can_shm_create(parts.shared)
                                           : can_counted_create(parts.shared, parts.interface);
}

status_t osal_can_destroy(const char* const address)
{
    FSW_ASSERT(address != NULL);
    address_parts_t parts;
    if ((split_address(address, &parts) != STATUS_OK) || (strlen(parts.shared) == 0U) ||
        (osal_shm_remove(parts.shared) != STATUS_OK)) {
        return STATUS_NOT_FOUND;
    }
    return STATUS_OK;
}

status_t osal_can_hand_over(const char* const address, osal_can_hand_over_t* const out_counts)
{
    FSW_ASSERT((address != NULL) && (out_counts != NULL));
    address_parts_t parts;
    if ((split_address(address, &parts) != STATUS_OK) || (strlen(parts.shared) == 0U) ||
        (strlen(parts.interface) == 0U)) {
        return STATUS_NOT_FOUND;
    }
    return can_counted_look(parts.shared, out_counts);
}

void osal_can_add_external(osal_can_t* const can, const uint32_t frames)
{
    FSW_ASSERT(can != NULL);
    if ((can->shared != NULL) && (can->descriptor >= 0)) {
        can_counted_add_external(can, frames);
    }
}

status_t osal_can_open(osal_can_t* const can, const char* const address, const osal_can_end_t end)
{
    FSW_ASSERT((can != NULL) && (address != NULL));
    address_parts_t parts;
    *can            = (osal_can_t){.shared = NULL, .descriptor = -1, .end = end};
    status_t status = split_address(address, &parts);
    if (status != STATUS_OK) {
        return status;
    }
    if (strlen(parts.interface) == 0U) {
        status = can_shm_open(can, parts.shared);
    } else if (strlen(parts.shared) == 0U) {
        status = can_socket_open(can, parts.interface);
    } else {
        status = can_counted_open(can, parts.shared, parts.interface);
    }
    return status;
}

void osal_can_close(osal_can_t* const can)
{
    FSW_ASSERT(can != NULL);
    if ((can->shared != NULL) && (can->descriptor >= 0)) {
        can_counted_close(can);
    } else if (can->shared != NULL) {
        can_shm_close(can);
    } else if (can->descriptor >= 0) {
        can_socket_close(can);
    } else {
        // The end is already closed.
    }
    can->shared     = NULL;
    can->descriptor = -1;
}

status_t osal_can_filter(osal_can_t* const can, const osal_can_filter_t* const filters, const size_t count)
{
    FSW_ASSERT((can != NULL) && ((filters != NULL) || (count == 0U)));
    if (count > OSAL_CAN_FILTERS_MAX) {
        return STATUS_INVALID;
    }
    if ((can->shared == NULL) && (can->descriptor < 0)) {
        return STATUS_CLOSED;
    }
    for (size_t i = 0U; i < count; i++) {
        can->filters[i] = filters[i];
    }
    can->filter_count = (uint8_t)count;
    can->is_filtered  = true;
    // A counted bus must receive every frame to count it, so the kernel filters only on a bus without counts.
    return (can->shared == NULL) ? can_socket_filter(can) : STATUS_OK;
}

static bool passes(const osal_can_t* const can, const osal_can_frame_t* const frame)
{
    if (!can->is_filtered || ((frame->id & OSAL_CAN_ERROR) != 0U)) {
        return true;
    }
    for (uint8_t i = 0U; i < can->filter_count; i++) {
        const osal_can_filter_t* const filter = &can->filters[i];
        if ((frame->id & filter->mask) == (filter->id & filter->mask)) {
            return true;
        }
    }
    return false;
}

/// True if the frame has a length that is possible on the bus.
static bool has_possible_length(const osal_can_frame_t* const frame)
{
    if ((frame->flags & OSAL_CAN_FLAG_FD) == 0U) {
        return frame->length <= CLASSIC_LENGTH_MAX;
    }
    const uint8_t length = frame->length;
    return (length <= 8U) || (length == 12U) || (length == 16U) || (length == 20U) || (length == 24U) ||
           (length == 32U) || (length == 48U) || (length == 64U);
}

status_t osal_can_send(osal_can_t* const can, const osal_can_frame_t* const frame)
{
    FSW_ASSERT((can != NULL) && (frame != NULL));
    if (!has_possible_length(frame)) {
        return STATUS_INVALID;
    }
    if (can->descriptor < 0) {
        return (can->shared != NULL) ? can_shm_send(can, frame) : STATUS_CLOSED;
    }
    return (can->shared != NULL) ? can_counted_send(can, frame) : can_socket_send(can, frame);
}

static status_t receive(osal_can_t* const can, osal_can_frame_t* const out_frame)
{
    if (can->descriptor < 0) {
        return (can->shared != NULL) ? can_shm_receive(can, out_frame) : STATUS_CLOSED;
    }
    return (can->shared != NULL) ? can_counted_receive(can, out_frame) : can_socket_receive(can, out_frame);
}

status_t osal_can_receive(osal_can_t* const can, osal_can_frame_t* const out_frame)
{
    FSW_ASSERT((can != NULL) && (out_frame != NULL));
    for (unsigned i = 0U; i < OSAL_CAN_RING_FRAMES; i++) { // Bounded, even if frames keep arriving.
        const status_t status = receive(can, out_frame);
        if ((status != STATUS_OK) || passes(can, out_frame)) {
            return status;
        }
        can->filtered++;
    }
    return STATUS_EMPTY;
}
