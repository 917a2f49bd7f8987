// SPDX-License-Identifier: Apache-2.0
#include "fsw/programs/member.h"

#include "base/assertion.h"
#include "base/text.h"
#include "fsw/framework/subsystem/fitting.h"
#include "osal/include/osal/console.h"

#include <string.h>

#define LINE_CHARACTERS (DESCRIPTOR_ERROR_CHARACTERS + 64U)

bool descriptor_path(const run_block_t* const run, const char* const relative, char* const out_path,
                     const size_t capacity)
{
    const char* const slash = strrchr(run->mission_path, '/');
    text_t text             = text_in(out_path, capacity);
    for (const char* next = run->mission_path; (slash != NULL) && (next <= slash); next++) {
        text_add_character(&text, *next);
    }
    text_add(&text, relative);
    return !text.cut;
}

static status_t check(member_t* const member, const subsystem_descriptor_t* const descriptor)
{
    descriptor_loader_t* const loader = &member->seat->reader->loader;
    subsystem_misfit_t misfit         = {0U, ""};
    const status_t status =
        descriptor_check_interface(loader, member->path, descriptor, member->interface_hash);
    if ((status == STATUS_OK) && !subsystem_fits(descriptor, member->callbacks, &misfit)) {
        return descriptor_refuse(loader, member->path, misfit.line, misfit.says);
    }
    return status;
}

bool member_load(member_t* const member, seat_t* const seat, const uint64_t interface_hash,
                 const subsystem_callbacks_t* const callbacks)
{
    FSW_ASSERT((member != NULL) && (seat != NULL) && (callbacks != NULL));
    const mission_subsystem_t* const subsystem = mission_find_subsystem(seat->mission, seat->apid);
    FSW_ASSERT(subsystem != NULL);
    member->seat           = seat;
    member->in_force       = seat->own;
    member->interface_hash = interface_hash;
    member->callbacks      = callbacks;
    if (!descriptor_path(seat->run, subsystem->descriptor, member->path, sizeof member->path) ||
        (check(member, seat->own) != STATUS_OK)) {
        text_t text = text_in(seat->error, sizeof seat->error);
        text_add(&text, descriptor_error(&seat->reader->loader));
        return false;
    }
    return (seat_open_inbox(seat, member->inbox, 1U) == STATUS_OK) &&
           (record_store_open(&member->records, seat, member->slots, MEMBER_RECORDS,
                              seat->clock.mode != OSAL_CLOCK_REAL) == STATUS_OK);
}

/// File, line, value and what was expected: more than the report of a failure can say.
static void tell_refusal(const member_t* const member)
{
    char line[LINE_CHARACTERS];
    text_t text = text_in(line, sizeof line);
    text_add(&text, descriptor_error(&member->seat->reader->loader));
    text_add(&text, " (not reloaded: the descriptor in force stays)");
    osal_console_complain(line);
}

/// TC[129,6]: a descriptor that is refused leaves the old one in force.
static status_t reload(void* const context, const subsystem_descriptor_t** const out_descriptor)
{
    member_t* const member      = (member_t*)context;
    seat_reader_t* const reader = member->seat->reader;
    status_t status             = descriptor_load_subsystem(&reader->loader, member->path, reader->spare);
    if (status == STATUS_OK) {
        status = check(member, reader->spare);
    }
    if (status == STATUS_OK) {
        subsystem_descriptor_t* const old = member->in_force;
        member->in_force                  = reader->spare;
        reader->spare                     = old;
        *out_descriptor                   = member->in_force;
    } else {
        tell_refusal(member);
    }
    return status;
}

/// Records of an earlier life go to the services they belong to.
static void take_back(void* const context, const uint8_t table, const uint32_t key,
                      const uint8_t* const octets, const size_t size)
{
    member_t* const member = (member_t*)context;
    if (component_restore(&member->component, table, key, octets, size) != STATUS_OK) {
        member->records_refused++;
    }
}

void member_begin(member_t* const member, void* const self, const component_services_t services)
{
    seat_t* const seat = member->seat;
    member->persistence =
        (pus_persistence_t){&member->records.journal, journal_put, journal_erase, journal_commit};
    const mission_subsystem_t* const subsystem = mission_find_subsystem(seat->mission, seat->apid);
    const bool is_real                         = (seat->clock.mode == OSAL_CLOCK_REAL);
    const component_config_t config            = {
                   .device_deadline_ns     = is_real ? ((uint64_t)subsystem->device_deadline_us * 1000U) : 0U,
                   .descriptor             = member->in_force,
                   .is_descriptor_valid    = true,
                   .callbacks              = member->callbacks,
                   .self                   = self,
                   .mission_epoch_s        = seat->mission->epoch_s,
                   .start_count            = seat->life,
                   .port                   = seat->uplink,
                   .links                  = &seat->links,
                   .link_methods           = seat->run->link_methods,
                   .supervisor_patience_ns = (uint64_t)subsystem->supervisor_patience_us * 1000U,
                   .status_interval_ns     = COMPONENT_STATUS_INTERVAL_NS,
                   .has_loop_tasks         = (seat->clock.mode == OSAL_CLOCK_REAL),
                   .optional               = services,
                   .persistence            = &member->persistence,
                   .reload                 = reload,
                   .reload_context         = member};
    component_init(&member->component, &config);
    if (journal_replay(&member->records.journal, take_back, member) != STATUS_OK) {
        member->records_refused++;
    }
}

void member_take_in(member_t* const member, const uint64_t now_ns)
{
    uint16_t from   = 0U;
    size_t size     = 0U;
    status_t status = STATUS_OK;
    message_take_control(&member->seat->endpoint); // Credit comes in whether or not requests may.
    while ((status != STATUS_EMPTY) && component_may_accept(&member->component)) {
        status =
            message_receive(&member->seat->endpoint, &from, member->packet, sizeof member->packet, &size);
        if ((status == STATUS_OK) && (size > 0U)) {
            component_accept(&member->component, member->packet, size, now_ns);
        }
    }
}

/// Records that were lost, once it can speak. JOURNAL_DAMAGED is the event's name in every descriptor.
static void tell_damage(member_t* const member)
{
    uint8_t octets[JOURNAL_DAMAGE_SIZE];
    const descriptor_event_t* const event = descriptor_find_event_name(member->in_force, "JOURNAL_DAMAGED");
    if (!member->has_told_damage && (event != NULL) && (event->octets == JOURNAL_DAMAGE_SIZE) &&
        journal_tell_damage(&member->records.journal, member->records_refused, octets)) {
        (void)subsystem_raise(&member->component, event->id, octets, sizeof octets);
    }
    member->has_told_damage = true;
}

uint64_t member_step(member_t* const member, const uint64_t now_ns)
{
    member_take_in(member, now_ns);
    const uint64_t wake_ns = component_step(&member->component, now_ns);
    tell_damage(member);
    return wake_ns;
}

void member_link_datagram(void* const self, const uint8_t* const frame, const size_t size)
{
    component_link_datagram(&((member_t*)self)->component, frame, size);
}

void member_close(void* const self)
{
    FSW_ASSERT(self != NULL);
    member_t* const member = (member_t*)self;
    component_release(&member->component);
    record_store_close(&member->records);
    member->seat->own = member->in_force; // The descriptor may be another one after it was reloaded.
}

static uint64_t step(void* const self, const uint64_t now_ns, const uint32_t octets_due)
{
    (void)octets_due;
    return member_step((member_t*)self, now_ns);
}

program_t member_program(member_t* const member, void* const storage, const size_t size)
{
    FSW_ASSERT((member != NULL) && (storage != NULL));
    return (program_t){.self          = member,
                       .step          = step,
                       .link_datagram = member_link_datagram,
                       .close         = member_close,
                       .component     = &member->component,
                       .storage       = storage,
                       .size          = size};
}
