// SPDX-License-Identifier: Apache-2.0
#include "pus/st19/st19_event_action.h"

#include "base/assertion.h"
#include "generated/pus/st19_request_formats.h"
#include "pus/st19/st19_definitions.h"

enum {
    STATUS_REPORT     = 7,
    DEFINITION_REPORT = 11
};

// ---- Events ----

/// Release the request of a definition once. False: the port refuses it.
static bool release(event_action_t* const self, const definition_t* const definition)
{
    const size_t size = event_action_request(definition, self->record);
    if (self->config.release.send(self->config.release.context, self->record, size) != STATUS_OK) {
        self->counters.deferred++;
        return false;
    }
    self->counters.released++;
    return true;
}

static void wait(event_action_t* const self, const uint16_t slot)
{
    definition_t* const definition = &self->config.definitions[slot];
    if (definition->waiting == UINT16_MAX) {
        self->counters.dropped++;
        return;
    }
    definition->waiting++;
    if (!definition->is_queued) {
        definition->is_queued = true;
        const uint32_t last =
            ((uint32_t)self->queue_first + self->queue_count) % self->config.definition_count;
        self->config.queue[last] = slot;
        self->queue_count++;
    }
}

void pus_event_action_observe(event_action_t* const self, const uint16_t apid, const uint16_t event)
{
    FSW_ASSERT(self != NULL);
    if (!self->is_enabled) {
        return;
    }
    const uint16_t slot = *event_action_link(self, apid, event);
    if ((slot == NONE) || !self->config.definitions[slot].is_enabled) {
        return;
    }
    self->counters.observed++;
    // If other requests wait, this one waits after them, so that the order of the events is kept.
    if ((self->queue_count > 0U) || !release(self, &self->config.definitions[slot])) {
        wait(self, slot);
    }
}

static void release_waiting(event_action_t* const self)
{
    for (unsigned i = 0U; (i < PUS_EVENT_ACTION_RELEASES) && (self->queue_count > 0U); i++) {
        definition_t* const definition = &self->config.definitions[self->config.queue[self->queue_first]];
        if ((definition->waiting > 0U) && !release(self, definition)) {
            return;
        }
        definition->waiting = (definition->waiting > 0U) ? (uint16_t)(definition->waiting - 1U) : 0U;
        if (definition->waiting == 0U) {
            definition->is_queued = false;
            self->queue_first     = (uint16_t)((self->queue_first + 1U) % self->config.definition_count);
            self->queue_count--;
        }
    }
}

bool pus_event_action_is_waiting(const event_action_t* const self)
{
    FSW_ASSERT(self != NULL);
    return (self->queue_count > 0U) || self->report.is_active;
}

// ---- Requests ----

static pus_reply_t reply_of(const status_t status)
{
    return (status == STATUS_OK) ? pus_done() : pus_failed(PUS_FAILURE_IO, (uint32_t)status);
}

static void refuse(event_action_t* const self, pus_request_t* const request, const uint16_t instruction,
                   const pus_failure_t failure)
{
    self->counters.refused++;
    pus_request_refuse(request, instruction, failure.code, failure.detail);
}

/// Perform an instruction, or refuse it.
static void perform_or_refuse(event_action_t* const self, pus_request_t* const request,
                              const uint16_t instruction, const pus_failure_t failure)
{
    if (failure.code == (uint16_t)PUS_FAILURE_NONE) {
        pus_request_perform(request);
    } else {
        refuse(self, request, instruction, failure);
    }
}

static pus_failure_t no_failure(void)
{
    return pus_no_failure();
}

static pus_failure_t io_failure(const status_t status)
{
    return (status == STATUS_OK) ? no_failure() : pus_failure(PUS_FAILURE_IO, (uint32_t)status);
}

/// Replace the request of an existing disabled definition.
static pus_failure_t replace(event_action_t* const self, const uint16_t slot,
                             const pus_block_chain_t* const request)
{
    definition_t* const definition = &self->config.definitions[slot];
    pus_block_chain_t old          = definition->request;
    definition->request            = *request;
    const status_t status          = event_action_put(self, slot, false);
    if (status != STATUS_OK) {
        pus_block_chain_free(self->config.chains, &definition->request);
        definition->request = old;
    } else {
        pus_block_chain_free(self->config.chains, &old);
    }
    return io_failure(status);
}

static pus_failure_t add(event_action_t* const self, const definition_t* const content)
{
    uint16_t slot = *event_action_link(self, content->apid, content->event);
    if (slot != NONE) {
        return replace(self, slot, &content->request);
    }
    slot = self->free;
    event_action_enter(self, slot, content);
    const status_t status = event_action_put(self, slot, false);
    if (status != STATUS_OK) {
        event_action_leave(self, event_action_link(self, content->apid, content->event));
    }
    return io_failure(status);
}

/// Returns the failure for which a definition is refused. It is called before blocks are allocated for the
/// request.
static pus_failure_t check(const event_action_t* const self, const definition_t* const content,
                           const uint32_t offset, const uint8_t* const octets, const size_t size)
{
    const uint16_t slot = *event_action_link(self, content->apid, content->event);
    if ((content->apid > PUS_APID_MAX) || (content->event == 0U)) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    if (!event_action_is_request(octets, size)) {
        return pus_failure(PUS_FAILURE_EMBEDDED, offset + (2U * (uint32_t)sizeof(uint16_t)));
    }
    if ((slot != NONE) && self->config.definitions[slot].is_enabled) {
        return pus_failure(PUS_FAILURE_STATE, event_action_key(content->apid, content->event));
    }
    return ((slot != NONE) || (self->free != NONE))
               ? no_failure()
               : pus_failure(PUS_FAILURE_TABLE_FULL, self->config.definition_count);
}

static pus_failure_t add_one(event_action_t* const self, octet_reader_t* const reader)
{
    const uint32_t offset = (uint32_t)reader->position;
    definition_t content  = {0};
    content.apid          = octet_read_u16(reader);
    content.event         = octet_read_u16(reader);
    size_t size           = 0U;
    const status_t framed =
        pus_packet_frame(&reader->octets[reader->position], octet_reader_left(reader), &size);
    const uint8_t* const octets = octet_read_octets(reader, size);
    FSW_ASSERT((framed == STATUS_OK) && (octets != NULL)); // The dispatcher has checked the format.
    const pus_failure_t failure = check(self, &content, offset, octets, size);
    if (failure.code != (uint16_t)PUS_FAILURE_NONE) {
        return failure;
    }
    return (pus_block_chain_append(self->config.chains, &content.request, octets, size) == STATUS_OK)
               ? add(self, &content)
               : pus_failure(PUS_FAILURE_TABLE_FULL, self->config.chains->pool.block_count);
}

static pus_reply_t add_definitions(void* const object, pus_request_t* const request)
{
    event_action_t* const self = object;
    const uint8_t count        = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        perform_or_refuse(self, request, i, add_one(self, &request->reader));
    }
    return pus_done();
}

/// Read a key and find its definition. PUS_FAILURE_NONE, or the failure if there is no such definition.
static pus_failure_t find(const event_action_t* const self, octet_reader_t* const reader,
                          uint16_t** const out_link)
{
    const uint16_t apid  = octet_read_u16(reader);
    const uint16_t event = octet_read_u16(reader);
    *out_link            = event_action_link(self, apid, event);
    return (**out_link != NONE) ? no_failure()
                                : pus_failure(PUS_FAILURE_UNKNOWN_ID, event_action_key(apid, event));
}

static pus_failure_t delete_one(event_action_t* const self, octet_reader_t* const reader)
{
    uint16_t* link              = NULL;
    const pus_failure_t failure = find(self, reader, &link);
    if (failure.code != (uint16_t)PUS_FAILURE_NONE) {
        return failure;
    }
    const definition_t* const definition = &self->config.definitions[*link];
    if (definition->is_enabled) {
        return pus_failure(PUS_FAILURE_STATE, event_action_key(definition->apid, definition->event));
    }
    const status_t status = event_action_erase(self, *link);
    if (status == STATUS_OK) {
        event_action_leave(self, link);
    }
    return io_failure(status);
}

static pus_reply_t delete_definitions(void* const object, pus_request_t* const request)
{
    event_action_t* const self = object;
    const uint8_t count        = octet_read_u8(&request->reader);
    for (uint16_t i = 1U; i <= count; i++) {
        perform_or_refuse(self, request, i, delete_one(self, &request->reader));
    }
    return pus_done();
}

static pus_reply_t set_function(event_action_t* const self, const bool is_enabled)
{
    const bool was_enabled = self->is_enabled;
    self->is_enabled       = is_enabled;
    const status_t status  = event_action_put_function(self);
    self->is_enabled       = (status == STATUS_OK) ? is_enabled : was_enabled;
    for (uint16_t i = 0U; !self->is_enabled && (i < self->queue_count); i++) {
        const uint32_t position = ((uint32_t)self->queue_first + i) % self->config.definition_count;
        event_action_drop_waiting(self, &self->config.definitions[self->config.queue[position]]);
    }
    return reply_of(status);
}

static pus_reply_t enable_function(void* const object, pus_request_t* const request)
{
    (void)request;
    return set_function(object, true);
}

static pus_reply_t disable_function(void* const object, pus_request_t* const request)
{
    (void)request;
    return set_function(object, false);
}

static pus_reply_t delete_all(void* const object, pus_request_t* const request)
{
    (void)request;
    event_action_t* const self = object;
    const pus_reply_t reply    = set_function(self, false);
    for (uint16_t i = 0U; i < self->config.definition_count; i++) {
        const definition_t* const definition = &self->config.definitions[i];
        const status_t status                = definition->in_use ? event_action_erase(self, i) : STATUS_OK;
        if (status != STATUS_OK) {
            return reply_of(status);
        }
        if (definition->in_use) {
            event_action_leave(self, event_action_link(self, definition->apid, definition->event));
        }
    }
    return reply;
}

/// Enable or disable one definition.
static status_t set_status(event_action_t* const self, const uint16_t slot, const bool is_enabled)
{
    definition_t* const definition = &self->config.definitions[slot];
    const status_t status =
        (definition->is_enabled != is_enabled) ? event_action_put(self, slot, is_enabled) : STATUS_OK;
    if (status == STATUS_OK) {
        definition->is_enabled = is_enabled;
    }
    if (!definition->is_enabled) {
        event_action_drop_waiting(self, definition);
    }
    return status;
}

static pus_reply_t set_statuses(event_action_t* const self, pus_request_t* const request,
                                const bool is_enabled)
{
    const uint8_t count = octet_read_u8(&request->reader);
    // N = 0 means all definitions.
    for (uint16_t i = 0U; (count == 0U) && (i < self->config.definition_count); i++) {
        const status_t status =
            self->config.definitions[i].in_use ? set_status(self, i, is_enabled) : STATUS_OK;
        if (status != STATUS_OK) {
            return reply_of(status);
        }
    }
    for (uint16_t i = 1U; i <= count; i++) {
        uint16_t* link        = NULL;
        pus_failure_t failure = find(self, &request->reader, &link);
        if (failure.code == (uint16_t)PUS_FAILURE_NONE) {
            failure = io_failure(set_status(self, *link, is_enabled));
        }
        perform_or_refuse(self, request, i, failure);
    }
    return pus_done();
}

static pus_reply_t enable(void* const object, pus_request_t* const request)
{
    return set_statuses(object, request, true);
}

static pus_reply_t disable(void* const object, pus_request_t* const request)
{
    return set_statuses(object, request, false);
}

// ---- Reports ----

/// Write the entry of the first definition at or after the cursor that the report includes.
static bool write_entry(void* const object, pus_report_cursor_t* const cursor, octet_writer_t* const writer)
{
    event_action_t* const self = object;
    uint64_t slot              = cursor->first;
    while (
        (slot < self->config.definition_count) &&
        (!self->config.definitions[slot].in_use ||
         ((self->report_wanted != 0U) && (self->config.definitions[slot].report != self->report_wanted)))) {
        slot++;
    }
    if (slot >= self->config.definition_count) {
        return false;
    }
    const definition_t* const definition = &self->config.definitions[slot];
    octet_write_u16(writer, definition->apid);
    octet_write_u16(writer, definition->event);
    octet_write_u8(writer, definition->is_enabled ? 1U : 0U);
    if (self->report.subtype == (uint8_t)DEFINITION_REPORT) {
        const size_t size = event_action_request(definition, self->record);
        octet_write_octets(writer, self->record, size);
    }
    cursor->first = slot + 1U;
    return true;
}

static pus_report_entries_t entries_of(event_action_t* const self)
{
    return (pus_report_entries_t){.self = self, .write = write_entry};
}

static pus_reply_t begin_report(event_action_t* const self, pus_request_t* const request,
                                const uint8_t subtype, const uint32_t wanted)
{
    static const pus_report_cursor_t start = {0};
    const pus_report_entries_t entries     = entries_of(self);
    self->report_wanted                    = wanted;
    return pus_long_report_begin(&self->report, request, subtype, &entries, &start, NULL, 0U);
}

static pus_reply_t refuse_second(event_action_t* const self)
{
    self->counters.refused++;
    return pus_refused(PUS_FAILURE_STATE, self->report.subtype);
}

static pus_reply_t report_status(void* const object, pus_request_t* const request)
{
    event_action_t* const self = object;
    return self->report.is_active ? refuse_second(self) : begin_report(self, request, STATUS_REPORT, 0U);
}

static pus_reply_t report_definitions(void* const object, pus_request_t* const request)
{
    event_action_t* const self = object;
    const uint8_t count        = octet_read_u8(&request->reader);
    if (self->report.is_active) {
        return refuse_second(self);
    }
    if (count == 0U) {
        return begin_report(self, request, DEFINITION_REPORT, 0U);
    }
    self->report_number++;
    for (uint16_t i = 1U; i <= count; i++) {
        uint16_t* link              = NULL;
        const pus_failure_t failure = find(self, &request->reader, &link);
        perform_or_refuse(self, request, i, failure);
        if (failure.code == (uint16_t)PUS_FAILURE_NONE) {
            self->config.definitions[*link].report = self->report_number;
        }
    }
    return (request->performed > 0U) ? begin_report(self, request, DEFINITION_REPORT, self->report_number)
                                     : pus_done();
}

void pus_event_action_step(event_action_t* const self, const uint64_t now_ns)
{
    FSW_ASSERT(self != NULL);
    release_waiting(self);
    if (self->report.is_active) {
        const pus_report_entries_t entries = entries_of(self);
        pus_long_report_go_on(&self->report, self->config.process, &entries, now_ns);
    }
}

pus_service_t pus_event_action_service(event_action_t* const self)
{
    static const pus_subtype_t subtypes[] = {PUS_REQUEST(19, 1, add_definitions),
                                             PUS_REQUEST(19, 2, delete_definitions),
                                             PUS_REQUEST(19, 3, delete_all),
                                             PUS_REQUEST(19, 4, enable),
                                             PUS_REQUEST(19, 5, disable),
                                             PUS_REQUEST(19, 6, report_status),
                                             PUS_REQUEST(19, 8, enable_function),
                                             PUS_REQUEST(19, 9, disable_function),
                                             PUS_REQUEST(19, 10, report_definitions)};
    return pus_service_of(PUS_SERVICE_EVENT_ACTION, subtypes, sizeof subtypes / sizeof subtypes[0], self);
}
