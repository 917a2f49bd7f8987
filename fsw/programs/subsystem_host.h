// SPDX-License-Identifier: Apache-2.0
/// Runs the generic subsystem in every component except the supervisor: loads its descriptor, connects it to
/// the run, and passes received messages to it.
#ifndef FSW_PROGRAMS_SUBSYSTEM_HOST_H
#define FSW_PROGRAMS_SUBSYSTEM_HOST_H

#include "fsw/programs/component_instance.h"
#include "fsw/programs/record_store.h"
#include "fsw/programs/component_runtime.h"
#include "fsw/framework/subsystem/subsystem_core.h"

#ifndef SUBSYSTEM_HOST_RECORDS
#define SUBSYSTEM_HOST_RECORDS 256U ///< Largest number of persistent records of a component's services.
#endif

typedef struct { // Private, except `component`.
    component_runtime_t* runtime;
    subsystem_t subsystem;
    subsystem_descriptor_t* in_force;
    uint64_t interface_hash;
    const subsystem_callbacks_t* callbacks;
    char path[RUN_PATH_MAX];
    uint8_t packet[PUS_PACKET_MAX];
    message_slot_t inbox[1]; // Messages from the supervisor.
    record_store_t records;
    journal_slot_t slots[JOURNAL_SLOTS(SUBSYSTEM_HOST_RECORDS)];
    pus_persistence_t persistence;
    uint32_t records_refused; // Persistent records that no service restored.
    bool has_reported_damage; // Damage of its records was reported.
} subsystem_host_t;

/// Check that the runtime's descriptor matches the program and requires only what the program supports; open
/// the persistent records. False: runtime->error contains file, line, found value and expected value.
bool subsystem_host_load(subsystem_host_t* host, component_runtime_t* runtime, uint64_t interface_hash,
                         const subsystem_callbacks_t* callbacks);
/// Initialise the subsystem in OFFLINE with the loaded descriptor, and restore the persistent records of its
/// services. `self` is the first argument of the callbacks.
void subsystem_host_begin(subsystem_host_t* host, void* self, subsystem_services_t services);
/// Process the messages that have arrived, as long as the subsystem may accept requests.
void subsystem_host_take_in(subsystem_host_t* host, uint64_t now_ns);
/// Take messages in as subsystem_host_take_in does, then step the subsystem. Returns the time of its next
/// wake [ns of the run].
uint64_t subsystem_host_step(subsystem_host_t* host, uint64_t now_ns);
/// Release the system resources of the component, and close its records, without sending a message.
void subsystem_host_close(void* self);
void subsystem_host_link_datagram(void* self, const uint8_t* frame, size_t size);
/// Returns the instance of a component that does no work in addition to its subsystem_host_step; `storage`
/// contains host and subsystem.
component_instance_t subsystem_host_instance(subsystem_host_t* host, void* storage, size_t size);

#endif // FSW_PROGRAMS_SUBSYSTEM_HOST_H
