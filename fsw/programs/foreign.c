// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/foreign.h"

#include "base/assertion.h"
#include "base/text.h"

#include <string.h>

#define PATIENCE_MS 1000U ///< One round of waiting; the stream shows the end of the stand-in.

/// Wait until the stand-in ends.
static status_t receive(foreign_t* const foreign, const foreign_kind_t kind, octet_reader_t* const out_reader)
{
    status_t status = STATUS_TIMEOUT;
    while (status == STATUS_TIMEOUT) {
        status = foreign_receive(&foreign->wire, kind, PATIENCE_MS, out_reader);
    }
    return status;
}

/// "shm:" and the name of the ring of a bus, distinct for each component.
static bool name_ring(const foreign_t* const foreign, const unsigned bus, char* const out_address,
                      const size_t capacity)
{
    char name[RUN_NAME_MAX];
    const unsigned number = (foreign->component * MISSION_BUSES_MAX) + bus + 1U;
    if (!run_name(&foreign->run, "foreign", number, name, sizeof name)) {
        return false;
    }
    text_t text = text_in(out_address, capacity);
    text_add(&text, "shm:");
    text_add(&text, &name[1]);
    return !text.cut;
}

status_t foreign_join(foreign_t* const foreign, const int descriptor)
{
    FSW_ASSERT(foreign != NULL);
    octet_reader_t reader;
    (void)memset(foreign, 0, sizeof *foreign);
    status_t status = osal_socket_adopt(&foreign->wire.socket, descriptor);
    if (status == STATUS_OK) {
        status = receive(foreign, FOREIGN_RUN, &reader);
    }
    if (status != STATUS_OK) {
        return status;
    }
    bool is_good = foreign_read_run(&reader, &foreign->run, &foreign->component);
    for (unsigned bus = 0U; is_good && (bus < MISSION_BUSES_MAX); bus++) {
        is_good = name_ring(foreign, bus, foreign->run.buses[bus].flight, RUN_NAME_MAX);
    }
    return is_good ? STATUS_OK : STATUS_INVALID;
}

/// Make the ring of a bus and hold its wire end. One that a former start of the program has left is replaced.
static status_t open_ring(foreign_t* const foreign, const unsigned bus)
{
    const char* const address = foreign->run.buses[bus].flight;
    status_t status           = osal_can_create(address);
    if (status == STATUS_EXISTS) {
        (void)osal_can_destroy(address);
        status = osal_can_create(address);
    }
    if (status == STATUS_OK) {
        status = osal_can_open(&foreign->buses.ends[bus], address, OSAL_CAN_WIRE);
    }
    if (status == STATUS_OK) {
        foreign->buses.open |= 1U << bus;
    }
    return status;
}

/// The component opens the bus of this address next.
static status_t resolve(void* const context, const endnode_kind_t kind, const char* const name,
                        endnode_address_t* const out_address)
{
    foreign_t* const foreign = (foreign_t*)context;
    if ((kind == ENDNODE_SHM) || (kind == ENDNODE_MQUEUE)) {
        return STATUS_NOT_FOUND; // A program at the other end has the other byte order.
    }
    status_t status = foreign->inner.resolve(foreign->inner.context, kind, name, out_address);
    for (unsigned bus = 0U; (status == STATUS_OK) && (kind == ENDNODE_CAN) && (bus < MISSION_BUSES_MAX);
         bus++) {
        const bool is_open = ((foreign->buses.open & (1U << bus)) != 0U);
        if (!is_open && (strcmp(foreign->run.buses[bus].flight, out_address->address) == 0)) {
            status = (open_ring(foreign, bus) == STATUS_OK) ? STATUS_OK : STATUS_NOT_FOUND;
        }
    }
    return status;
}

void foreign_serve(foreign_t* const foreign, seat_t* const seat)
{
    FSW_ASSERT((foreign != NULL) && (seat != NULL));
    foreign->seat  = seat;
    foreign->inner = seat->flows;
    seat->flows    = (flow_resolver_t){foreign, resolve};
}

status_t foreign_wait(foreign_t* const foreign, const uint64_t wake_ns)
{
    FSW_ASSERT((foreign != NULL) && (foreign->seat != NULL));
    const foreign_done_t done = {.wake_ns = wake_ns,
                                 .opened  = foreign->buses.open,
                                 .is_lossy =
                                     (__atomic_load_n(&foreign->run.is_lossy, __ATOMIC_RELAXED) != 0U),
                                 .deliveries = foreign->seat->deliveries};
    octet_writer_t writer     = foreign_begin(&foreign->wire, FOREIGN_DONE);
    octet_reader_t reader;
    osal_grant_t grant = {0U, 0U, 0U};
    foreign_write_done(&writer, &done);
    foreign_write_frames(&writer, &foreign->buses);
    status_t status = foreign_send(&foreign->wire, &writer);
    if (status == STATUS_OK) {
        status = receive(foreign, FOREIGN_GRANT, &reader);
    }
    if (status != STATUS_OK) {
        return status;
    }
    // Frames for a controller whose ring is full are lost, as on the bus, and counted there.
    if (!foreign_read_grant(&reader, &grant, &foreign->run) ||
        !foreign_read_frames(&reader, &foreign->buses)) {
        return STATUS_INVALID;
    }
    osal_clock_take_grant(&foreign->seat->clock, &grant);
    return STATUS_OK;
}

void foreign_leave(foreign_t* const foreign)
{
    FSW_ASSERT(foreign != NULL);
    for (unsigned bus = 0U; bus < MISSION_BUSES_MAX; bus++) {
        if ((foreign->buses.open & (1U << bus)) != 0U) {
            osal_can_close(&foreign->buses.ends[bus]);
            (void)osal_can_destroy(foreign->run.buses[bus].flight);
        }
    }
    foreign->buses.open = 0U;
    osal_socket_close(&foreign->wire.socket);
}
