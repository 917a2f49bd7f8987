// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/ground_key.h"
#include "fsw/programs/subsystem_host.h"
#include "fsw/programs/component_instance.h"
#include "fsw/subsystems/communication/communication.h"
#include "generated/communication_services.h"
#include "osal/include/osal/console.h"

#define ANNOUNCED_TIMEOUT_MS 100U ///< Time of one wait for announced octets, divided among the sockets.
#define ANNOUNCED_TRIES 50U       ///< Waits for announced octets: together five seconds of wall-clock time.

typedef struct {
    subsystem_host_t host;
    communication_t communication;
    communication_services_t services;
    ground_key_t key;
    bool has_key; // The program has tried to open the key, possibly without success.
} communication_program_t;

static communication_program_t storage;

/// Announce octets to the operator that takes part in the scheduler.
static void sent(void* const context, const uint16_t peer_port, const uint32_t octets)
{
    component_runtime_t* const runtime = (component_runtime_t*)context;
    const unsigned operator= run_operator(runtime->run);
    if ((runtime->clock.mode == OSAL_CLOCK_STEPPED) &&
        (osal_lockstep_stream_port(runtime->clock.scheduler, operator) == peer_port)) {
        osal_clock_deliver(&runtime->clock, operator, OSAL_LOCKSTEP_ANY_LIFE, 0U, octets);
    }
}

static uint16_t participant_port(void* const context)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    return (runtime->clock.mode == OSAL_CLOCK_STEPPED)
               ? osal_lockstep_stream_port(runtime->clock.scheduler, run_operator(runtime->run))
               : 0U;
}

static void served(void* const context, const uint16_t port)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    osal_lockstep_serve_stream(runtime->clock.scheduler, run_operator(runtime->run), port,
                               runtime->clock.participant);
}

static void cut_stream(void* const context, const uint16_t port)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    osal_lockstep_cut_stream(runtime->clock.scheduler, run_operator(runtime->run), port);
}

static void note_intrusion(void* const context)
{
    const component_runtime_t* const runtime = (const component_runtime_t*)context;
    __atomic_store_n(&runtime->run->is_intruded, 1U, __ATOMIC_RELAXED);
}

/// Wait for a short wall-clock time, or until packets arrive.
static void await(communication_program_t* const self)
{
    osal_socket_t* sockets[COMPONENT_RUNTIME_SOCKETS_MAX];
    const size_t count = communication_sockets(&self->communication, sockets, COMPONENT_RUNTIME_SOCKETS_MAX);
    for (size_t i = count; i > 0U; i--) { // The listener is the first socket; clients are checked before it.
        if (osal_socket_wait_readable(sockets[i - 1U], ANNOUNCED_TIMEOUT_MS / (uint32_t)count) == STATUS_OK) {
            break;
        }
    }
}

/// Receive the announced octets. They, the connection itself or its end may still be on their way through
/// the kernel, so wait for them.
static void take_in(communication_program_t* const self, const uint32_t octets_due)
{
    bool is_missing = communication_take_in(&self->communication, octets_due);
    for (unsigned attempt = 0U; is_missing && (attempt < ANNOUNCED_TRIES); attempt++) {
        await(self);
        is_missing = communication_take_in(&self->communication, 0U);
    }
    if (is_missing) {
        communication_stop_waiting(&self->communication);
        osal_console_print_error(
            "octets or the connection of the operator have not arrived; the run is not reproducible");
    }
}

static uint64_t step(void* const context, const uint64_t now_ns, const uint32_t octets_due)
{
    communication_program_t* const self = (communication_program_t*)context;
    subsystem_set_time(&self->host.subsystem, now_ns);
    take_in(self, octets_due);
    const uint64_t wake_ns = subsystem_host_step(&self->host, now_ns);
    communication_send_out(&self->communication);
    return wake_ns;
}

static size_t sockets_of(void* const context, osal_socket_t** const out_sockets, const size_t capacity)
{
    return communication_sockets(&((communication_program_t*)context)->communication, out_sockets, capacity);
}

/// Open the key. The launcher has checked it before the run began. If the key was removed since then,
/// telemetry is sent, but every telecommand is refused; an event reports this.
static void secure(communication_program_t* const self, const char* const path)
{
    char error[GROUND_KEY_ERROR_MAX];
    if (path[0] == '\0') {
        return;
    }
    if (!ground_key_open(&self->key, path, error)) {
        osal_console_print_error(error);
    }
    self->has_key = true;
    communication_secure(&self->communication, &self->key.receiver);
}

static void close_program(void* const context)
{
    communication_program_t* const self = (communication_program_t*)context;
    if (self->has_key) {
        ground_key_close(&self->key);
    }
    subsystem_host_close(&self->host);
}

bool communication_open(component_runtime_t* const runtime, component_instance_t* const out_instance)
{
    const communication_hooks_t hooks = {runtime, sent, participant_port, served, cut_stream, note_intrusion};
    if (!subsystem_host_load(&storage.host, runtime, COMMUNICATION_INTERFACE_HASH,
                             communication_callbacks())) {
        return false;
    }
    communication_init(&storage.communication, &storage.host.subsystem, &runtime->uplink, &hooks,
                       runtime->run->ground_descriptor);
    secure(&storage, runtime->run->key);
    subsystem_host_begin(&storage.host, &storage.communication,
                         (subsystem_services_t){&storage.services, communication_add_services});
    *out_instance = (component_instance_t){.self          = &storage,
                                           .step          = step,
                                           .sockets       = sockets_of,
                                           .link_datagram = subsystem_host_link_datagram,
                                           .close         = close_program,
                                           .component     = &storage.host.subsystem,
                                           .storage       = &storage,
                                           .size          = sizeof storage};
    return true;
}
