// SPDX-License-Identifier: Apache-2.0
/// What every component but the supervisor needs around its generic subsystem: descriptor, wiring, intake.
#ifndef FSW_PROGRAMS_MEMBER_H
#define FSW_PROGRAMS_MEMBER_H

#include "fsw/programs/program.h"
#include "fsw/programs/record_store.h"
#include "fsw/programs/seat.h"
#include "fsw/framework/descriptor/descriptor.h"
#include "fsw/framework/subsystem/component.h"

#define MEMBER_RECORDS 256U ///< Lasting records of its services.

typedef struct { // Private, except `component`.
    seat_t* seat;
    component_t component;
    subsystem_descriptor_t* in_force;
    uint64_t interface_hash;
    const subsystem_callbacks_t* callbacks;
    char path[RUN_PATH_MAX];
    uint8_t packet[PUS_PACKET_MAX];
    message_place_t inbox[1]; // From the supervisor.
    record_store_t records;
    journal_slot_t slots[JOURNAL_SLOTS(MEMBER_RECORDS)];
    pus_persistence_t persistence;
    uint32_t records_refused; // Lasting records that no service restored.
    bool has_told_damage;     // Damage to its records was reported.
} member_t;

/// Check that the seat's descriptor matches the program and requires only what the program supports; open its
/// lasting records. False: seat->error has file, line, value and the expected value.
bool member_load(member_t* member, seat_t* seat, uint64_t interface_hash,
                 const subsystem_callbacks_t* callbacks);
/// Begin life in OFFLINE with the loaded descriptor, and the services that it lists with their lasting
/// records. `self` is the first argument of the callbacks.
void member_begin(member_t* member, void* self, component_services_t services);
/// Take in all messages, then step.
void member_take_in(member_t* member, uint64_t now_ns);
uint64_t member_step(member_t* member, uint64_t now_ns);
/// Release the system resources of the component and its records, without any message.
void member_close(void* self);
void member_link_datagram(void* self, const uint8_t* frame, size_t size);
/// The program of a member without work around its steps; `storage` contains the member and everything else.
program_t member_program(member_t* member, void* storage, size_t size);

/// Path of a descriptor named relative to the mission's file. False if it does not fit.
bool descriptor_path(const run_block_t* run, const char* relative, char* out_path, size_t capacity);

#endif // FSW_PROGRAMS_MEMBER_H
