// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/remote_endian.h"

#include "base/assertion.h"
#include "base/text.h"

#include <string.h>

/// Length of one wait. The number of waits is not limited, because the stream shows the end of the proxy.
#define TIMEOUT_MS 1000U

/// Wait for a record, until it arrives or the proxy ends.
static status_t receive(remote_endian_t* const remote, const remote_endian_kind_t kind,
                        octet_reader_t* const out_reader)
{
    status_t status = STATUS_TIMEOUT;
    while (status == STATUS_TIMEOUT) {
        status = remote_endian_receive(&remote->wire, kind, TIMEOUT_MS, out_reader);
    }
    return status;
}

/// Write the address of the ring of a bus: "shm:" and a name that is different for each component.
static bool name_ring(const remote_endian_t* const remote, const unsigned bus, char* const out_address,
                      const size_t capacity)
{
    char name[RUN_NAME_MAX];
    const unsigned number = (remote->component * MISSION_BUSES_MAX) + bus + 1U;
    if (!run_name(&remote->run, "remote", number, name, sizeof name)) {
        return false;
    }
    text_t text = text_in(out_address, capacity);
    text_add(&text, "shm:");
    text_add(&text, &name[1]);
    return !text.cut;
}

status_t remote_endian_join(remote_endian_t* const remote, const int descriptor)
{
    FSW_ASSERT(remote != NULL);
    octet_reader_t reader;
    (void)memset(remote, 0, sizeof *remote);
    status_t status = osal_socket_adopt(&remote->wire.socket, descriptor);
    if (status == STATUS_OK) {
        status = receive(remote, REMOTE_ENDIAN_RUN, &reader);
    }
    if (status != STATUS_OK) {
        return status;
    }
    bool is_good = remote_endian_read_run(&reader, &remote->run, &remote->component);
    for (unsigned bus = 0U; is_good && (bus < MISSION_BUSES_MAX); bus++) {
        is_good = name_ring(remote, bus, remote->run.buses[bus].flight, RUN_NAME_MAX);
    }
    return is_good ? STATUS_OK : STATUS_INVALID;
}

/// Create the ring of a bus and open its wire end. A ring that remains from an earlier start of the program
/// is replaced.
static status_t open_ring(remote_endian_t* const remote, const unsigned bus)
{
    const char* const address = remote->run.buses[bus].flight;
    status_t status           = osal_can_create(address);
    if (status == STATUS_EXISTS) {
        (void)osal_can_destroy(address);
        status = osal_can_create(address);
    }
    if (status == STATUS_OK) {
        status = osal_can_open(&remote->buses.ends[bus], address, OSAL_CAN_WIRE);
    }
    if (status == STATUS_OK) {
        remote->buses.open |= 1U << bus;
    }
    return status;
}

/// Get the address of an end node. The ring of a CAN bus is created here, because the component opens it
/// next.
static status_t resolve(void* const context, const flow_endnode_kind_t kind, const char* const name,
                        flow_endnode_address_t* const out_address)
{
    remote_endian_t* const remote = (remote_endian_t*)context;
    if ((kind == ENDNODE_SHM) || (kind == ENDNODE_MQUEUE)) {
        // Shared memory and queues are not supported, because the partner uses the other byte order.
        return STATUS_NOT_FOUND;
    }
    status_t status = remote->inner.resolve(remote->inner.context, kind, name, out_address);
    for (unsigned bus = 0U; (status == STATUS_OK) && (kind == ENDNODE_CAN) && (bus < MISSION_BUSES_MAX);
         bus++) {
        const bool is_open = ((remote->buses.open & (1U << bus)) != 0U);
        if (!is_open && (strcmp(remote->run.buses[bus].flight, out_address->address) == 0)) {
            status = (open_ring(remote, bus) == STATUS_OK) ? STATUS_OK : STATUS_NOT_FOUND;
        }
    }
    return status;
}

void remote_endian_serve(remote_endian_t* const remote, component_runtime_t* const runtime)
{
    FSW_ASSERT((remote != NULL) && (runtime != NULL));
    remote->runtime = runtime;
    remote->inner   = runtime->flows;
    runtime->flows  = (flow_resolver_t){remote, resolve};
}

/// Take the frames of a grant, and those of the records that continue it. Frames for a controller whose ring
/// is full are lost, as on a real bus, and the ring counts them.
static status_t take_frames(remote_endian_t* const remote, octet_reader_t* const reader)
{
    bool has_more   = true;
    status_t status = STATUS_OK;
    while (has_more && (status == STATUS_OK)) {
        if (!remote_endian_read_frames(reader, &remote->buses, &has_more)) {
            return STATUS_INVALID;
        }
        status = has_more ? receive(remote, REMOTE_ENDIAN_GRANT, reader) : STATUS_OK;
    }
    return status;
}

status_t remote_endian_wait(remote_endian_t* const remote, const uint64_t wake_ns)
{
    FSW_ASSERT((remote != NULL) && (remote->runtime != NULL));
    const remote_endian_done_t done = {.wake_ns = wake_ns,
                                       .opened  = remote->buses.open,
                                       .is_lossy =
                                           (__atomic_load_n(&remote->run.is_lossy, __ATOMIC_RELAXED) != 0U),
                                       .deliveries = remote->runtime->deliveries};
    octet_writer_t writer           = remote_endian_begin(&remote->wire, REMOTE_ENDIAN_DONE);
    octet_reader_t reader;
    osal_grant_t grant = {0U, 0U, 0U};
    remote_endian_write_done(&writer, &done);
    status_t status = remote_endian_send_frames(&remote->wire, &writer, &remote->buses);
    if (status == STATUS_OK) {
        status = receive(remote, REMOTE_ENDIAN_GRANT, &reader);
    }
    if (status != STATUS_OK) {
        return status;
    }
    if (!remote_endian_read_grant(&reader, &grant, &remote->run)) {
        return STATUS_INVALID;
    }
    status = take_frames(remote, &reader);
    if (status == STATUS_OK) {
        osal_clock_take_grant(&remote->runtime->clock, &grant);
    }
    return status;
}

void remote_endian_leave(remote_endian_t* const remote)
{
    FSW_ASSERT(remote != NULL);
    for (unsigned bus = 0U; bus < MISSION_BUSES_MAX; bus++) {
        if ((remote->buses.open & (1U << bus)) != 0U) {
            osal_can_close(&remote->buses.ends[bus]);
            (void)osal_can_destroy(remote->run.buses[bus].flight);
        }
    }
    remote->buses.open = 0U;
    osal_socket_close(&remote->wire.socket);
}
