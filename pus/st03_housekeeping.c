// SPDX-License-Identifier: Apache-2.0
#include "pus/st03_housekeeping.h"

#include "fsw/framework/base/assertion.h"
#include "pus/st03_structures.h"

#include <string.h>

void pus_hk_init(pus_hk_t* const hk, const pus_hk_config_t* const config)
{
    FSW_ASSERT((hk != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->parameters.find != NULL) && (config->parameters.read != NULL) &&
               (config->structures != NULL) && (config->samples != NULL));
    FSW_ASSERT((config->sample_size + HK_ID_SIZE) <= PUS_TM_DATA_MAX);
    (void)memset(hk, 0, sizeof(*hk));
    hk->config = *config;
    pus_hk_clear(hk);
}

/// No other loop samples while structures change.
static void guard(const pus_hk_t* const hk)
{
    if (hk->config.guard != NULL) {
        (void)osal_mutex_lock(hk->config.guard); // A holder that dies takes this process with it.
    }
}

static void release(const pus_hk_t* const hk)
{
    if (hk->config.guard != NULL) {
        osal_mutex_unlock(hk->config.guard);
    }
}

void pus_hk_clear(pus_hk_t* const hk)
{
    FSW_ASSERT(hk != NULL);
    guard(hk);
    for (uint16_t i = 0U; i < hk->config.structure_count; i++) {
        hk->config.structures[i].in_use = false;
    }
    release(hk);
}

/// The candidate takes its place if nothing speaks against it.
static void settle(const pus_hk_t* const hk, pus_hk_structure_t* const place)
{
    if (hk->verdict.code == PUS_FAILURE_NONE) {
        guard(hk);
        *place = hk->candidate;
        release(hk);
    }
}

/// Begin a collection interval after cycle `start`.
static void restart(pus_hk_structure_t* const structure, const uint32_t start)
{
    structure->start = start;
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        structure->sets[i].taken = 0U;
    }
}

static status_t status_of(const uint16_t code)
{
    switch (code) {
    case PUS_FAILURE_NONE:
        return STATUS_OK;
    case PUS_FAILURE_EXISTS:
        return STATUS_EXISTS;
    case PUS_FAILURE_TABLE_FULL:
        return STATUS_EXHAUSTED;
    case PUS_FAILURE_UNKNOWN_ID:
        return STATUS_NOT_FOUND;
    case PUS_FAILURE_ACCESS:
        return STATUS_FORBIDDEN;
    default:
        return STATUS_INVALID;
    }
}

status_t pus_hk_add(pus_hk_t* const hk, const pus_hk_definition_t* const definition)
{
    FSW_ASSERT((hk != NULL) && (definition != NULL));
    pus_hk_structure_t* place = NULL;
    hk_candidate_begin(hk, definition->id, definition->interval, &place);
    for (uint8_t i = 0U; i < definition->parameter_count; i++) {
        hk_candidate_add(hk, definition->parameters[i]);
    }
    for (uint8_t i = 0U; i < definition->set_count; i++) {
        const pus_hk_set_definition_t* const set = &definition->sets[i];
        hk_candidate_add_set(hk, set->repetitions, set->parameter_count, 0U);
        for (uint8_t k = 0U; k < set->parameter_count; k++) {
            hk_candidate_add_to_set(hk, set->parameters[k]);
        }
    }
    hk_candidate_lay_out(hk, hk->candidate.entry_count, 0U);
    hk->candidate.is_periodic = definition->is_periodic;
    hk->candidate.loop        = definition->loop;
    settle(hk, place);
    return status_of(hk->verdict.code);
}

// Reports.

static void read_entries(const pus_hk_t* const hk, const pus_hk_structure_t* const structure,
                         const uint8_t first, const uint8_t count, octet_writer_t* const writer)
{
    const pus_parameter_port_t* const port = &hk->config.parameters;
    for (uint8_t i = 0U; i < count; i++) {
        const pus_hk_entry_t* const entry = &structure->entries[first + i];
        const size_t end                  = writer->position + entry->size;
        port->read(port->context, entry->handle, writer);
        FSW_ASSERT(writer->position == end); // The port promised this size.
    }
}

/// Take the samples of a set that are due after `elapsed` cycles of the interval.
static void sample_set(const pus_hk_t* const hk, const pus_hk_structure_t* const structure,
                       pus_hk_set_t* const set, const uint32_t elapsed, uint8_t* const samples)
{
    const uint64_t due = ((uint64_t)elapsed * set->repetitions) / structure->interval;
    while ((set->taken < due) && (set->taken < set->repetitions)) {
        octet_writer_t writer =
            octet_writer(&samples[set->offset + ((size_t)set->taken * set->size)], set->size);
        read_entries(hk, structure, set->first, set->count, &writer);
        set->taken++;
    }
}

/// The values of a report at the end of an interval.
static void write_collected(const pus_hk_t* const hk, const pus_hk_structure_t* const structure,
                            const uint8_t* const samples, octet_writer_t* const writer)
{
    read_entries(hk, structure, 0U, structure->simple_count, writer);
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        const pus_hk_set_t* const set = &structure->sets[i];
        octet_write_octets(writer, &samples[set->offset], (size_t)set->size * set->repetitions);
    }
}

/// Begin TM[3,25].
static octet_writer_t begin_report(const pus_hk_t* const hk, const uint16_t id, const uint16_t destination,
                                   const uint64_t now_ns)
{
    octet_writer_t writer =
        pus_tm_begin(hk->config.process, PUS_SERVICE_HOUSEKEEPING, 25U, destination, now_ns);
    octet_write_u16(&writer, id);
    return writer;
}

static void count(pus_hk_t* const hk, const status_t status)
{
    if (status == STATUS_OK) {
        hk->counters.reports++;
    } else {
        hk->counters.dropped++;
    }
}

/// Send TM[3,25], or let the loop of the process send it.
static void hand_over(pus_hk_t* const hk, const pus_hk_structure_t* const structure,
                      const uint8_t* const samples, const uint64_t now_ns,
                      const pus_hk_outlet_t* const outlet)
{
    octet_writer_t writer = (outlet == NULL) ? begin_report(hk, structure->id, PUS_USER_GROUND, now_ns)
                                             : octet_writer(outlet->values, hk->config.sample_size);
    write_collected(hk, structure, samples, &writer);
    if (outlet == NULL) {
        count(hk, pus_tm_send(hk->config.process, &writer));
    } else {
        outlet->put(outlet->context, structure->id, now_ns, outlet->values, writer.position);
    }
}

/// One cycle of a structure whose periodic generation is enabled.
static void collect(pus_hk_t* const hk, pus_hk_structure_t* const structure, uint8_t* const samples,
                    const uint64_t now_ns, const uint32_t cycle, const pus_hk_outlet_t* const outlet)
{
    if (!structure->is_collecting) {
        structure->is_collecting = true;
        restart(structure, cycle - 1U);
    }
    const uint32_t elapsed = cycle - structure->start; // Unsigned: right across the wrap of the counter.
    const bool is_complete = elapsed >= structure->interval;
    for (uint8_t k = 0U; k < structure->set_count; k++) {
        sample_set(hk, structure, &structure->sets[k], is_complete ? structure->interval : elapsed, samples);
    }
    if (is_complete) {
        hand_over(hk, structure, samples, now_ns, outlet);
        restart(structure,
                cycle - (elapsed % structure->interval)); // Keeps the rhythm if cycles were missed.
    }
}

/// One cycle of the structures of a loop.
static void step_loop(pus_hk_t* const hk, const uint8_t loop, const uint64_t now_ns, const uint32_t cycle,
                      const pus_hk_outlet_t* const outlet)
{
    for (uint16_t i = 0U; i < hk->config.structure_count; i++) {
        pus_hk_structure_t* const structure = &hk->config.structures[i];
        if (structure->in_use && structure->is_periodic && (structure->loop == loop)) {
            collect(hk, structure, &hk->config.samples[(size_t)i * hk->config.sample_size], now_ns, cycle,
                    outlet);
        }
    }
}

void pus_hk_step(pus_hk_t* const hk, const uint64_t now_ns, const uint32_t cycle)
{
    FSW_ASSERT(hk != NULL);
    step_loop(hk, 0U, now_ns, cycle, NULL);
}

void pus_hk_loop_step(pus_hk_t* const hk, const uint8_t loop, const uint64_t now_ns, const uint32_t cycle,
                      const pus_hk_outlet_t* const outlet)
{
    FSW_ASSERT((hk != NULL) && (loop >= 1U) && (outlet != NULL) && (outlet->put != NULL) &&
               (outlet->values != NULL));
    step_loop(hk, loop, now_ns, cycle, outlet);
}

void pus_hk_forward(pus_hk_t* const hk, const uint16_t id, const uint64_t taken_ns,
                    const uint8_t* const values, const size_t size)
{
    FSW_ASSERT((hk != NULL) && (values != NULL) && (size <= hk->config.sample_size));
    octet_writer_t writer = begin_report(hk, id, PUS_USER_GROUND, taken_ns);
    octet_write_octets(&writer, values, size);
    count(hk, pus_tm_send(hk->config.process, &writer));
}

void pus_hk_count_lost(pus_hk_t* const hk, const uint32_t reports)
{
    FSW_ASSERT(hk != NULL);
    hk->counters.dropped += reports;
}

// Requests.

/// N1 x {parameter}, NFA x {repetitions, N2 x {parameter}}.
static bool shape_lists(octet_reader_t* const reader)
{
    (void)pus_shape_list(reader, 0U, sizeof(uint32_t));
    const uint8_t set_count = octet_read_u8(reader);
    for (uint8_t i = 0U; i < set_count; i++) {
        (void)octet_read_u16(reader);
        (void)pus_shape_list(reader, 0U, sizeof(uint32_t));
    }
    return true;
}

static bool shape_create(void* const self, octet_reader_t* const reader)
{
    (void)self;
    (void)octet_read_u16(reader);
    (void)octet_read_u32(reader);
    return shape_lists(reader);
}

static bool shape_append(void* const self, octet_reader_t* const reader)
{
    (void)self;
    (void)octet_read_u16(reader);
    return shape_lists(reader);
}

static bool shape_intervals(void* const self, octet_reader_t* const reader)
{
    (void)self;
    return pus_shape_list(reader, 1U, sizeof(uint16_t) + sizeof(uint32_t));
}

/// Add the parameters and sets of a request to the candidate, which takes its place if all of it is good.
static pus_reply_t add_requested(pus_hk_t* const hk, octet_reader_t* const reader,
                                 pus_hk_structure_t* const place)
{
    const uint32_t start_offset = (uint32_t)reader->position;
    const uint8_t simple_count  = octet_read_u8(reader);
    for (uint8_t i = 0U; i < simple_count; i++) {
        hk_candidate_add(hk, octet_read_u32(reader));
    }
    const uint8_t set_count = octet_read_u8(reader);
    for (uint8_t i = 0U; i < set_count; i++) {
        const uint32_t offset      = (uint32_t)reader->position;
        const uint16_t repetitions = octet_read_u16(reader);
        const uint8_t entry_count  = octet_read_u8(reader);
        hk_candidate_add_set(hk, repetitions, entry_count, offset);
        for (uint8_t k = 0U; k < entry_count; k++) {
            hk_candidate_add_to_set(hk, octet_read_u32(reader));
        }
    }
    hk_candidate_lay_out(hk, (unsigned)simple_count + set_count, start_offset);
    settle(hk, place);
    return (hk->verdict.code == PUS_FAILURE_NONE) ? pus_done()
                                                  : pus_refused(hk->verdict.code, hk->verdict.detail);
}

static pus_reply_t create(void* const self, pus_request_t* const request)
{
    pus_hk_t* const hk        = self;
    const uint16_t id         = octet_read_u16(&request->reader);
    const uint32_t interval   = octet_read_u32(&request->reader);
    pus_hk_structure_t* place = NULL;
    hk_candidate_begin(hk, id, interval, &place);
    return add_requested(hk, &request->reader, place);
}

static pus_reply_t append(void* const self, pus_request_t* const request)
{
    pus_hk_t* const hk                  = self;
    const uint16_t id                   = octet_read_u16(&request->reader);
    pus_hk_structure_t* const structure = hk_structure_of(hk, id);
    if (structure == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (structure->is_periodic) {
        return pus_refused(PUS_FAILURE_STATE, id);
    }
    hk_candidate_extend(hk, structure);
    return add_requested(hk, &request->reader, structure);
}

/// What a request does with each structure that it names.
typedef struct {
    bool needs_disabled; // Not while its periodic generation is enabled.
    bool has_interval;   // An interval follows each id.
    void (*perform)(pus_hk_t*, pus_hk_structure_t*, const pus_request_t*, uint32_t interval);
} operation_t;

/// Shortest interval that a structure may have: the largest repetition number of its sets.
static uint32_t interval_min(const pus_hk_structure_t* const structure)
{
    uint32_t interval = 1U;
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        const uint32_t repetitions = structure->sets[i].repetitions;
        interval                   = (repetitions > interval) ? repetitions : interval;
    }
    return interval;
}

static pus_reply_t for_each(pus_hk_t* const hk, pus_request_t* const request,
                            const operation_t* const operation)
{
    octet_reader_t* const reader = &request->reader;
    const uint8_t id_count       = octet_read_u8(reader);
    for (uint16_t i = 1U; i <= id_count; i++) {
        const uint16_t id                   = octet_read_u16(reader);
        const uint32_t offset               = (uint32_t)reader->position;
        const uint32_t interval             = operation->has_interval ? octet_read_u32(reader) : 0U;
        pus_hk_structure_t* const structure = hk_structure_of(hk, id);
        if (structure == NULL) {
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, id);
        } else if (operation->needs_disabled && structure->is_periodic) {
            pus_request_refuse(request, i, PUS_FAILURE_STATE, id);
        } else if (operation->has_interval && (interval < interval_min(structure))) {
            pus_request_refuse(request, i, PUS_FAILURE_OUT_OF_RANGE, offset);
        } else {
            pus_request_perform(request);
            guard(hk);
            operation->perform(hk, structure, request, interval);
            release(hk);
        }
    }
    return pus_done();
}

static void remove_one(pus_hk_t* const hk, pus_hk_structure_t* const structure,
                       const pus_request_t* const request, const uint32_t interval)
{
    (void)hk;
    (void)request;
    (void)interval;
    structure->in_use = false;
}

static void enable_one(pus_hk_t* const hk, pus_hk_structure_t* const structure,
                       const pus_request_t* const request, const uint32_t interval)
{
    (void)hk;
    (void)request;
    (void)interval;
    if (!structure->is_periodic) {
        structure->is_periodic   = true;
        structure->is_collecting = false; // The interval begins with the next step.
    }
}

static void disable_one(pus_hk_t* const hk, pus_hk_structure_t* const structure,
                        const pus_request_t* const request, const uint32_t interval)
{
    (void)hk;
    (void)request;
    (void)interval;
    structure->is_periodic = false;
}

static void modify_one(pus_hk_t* const hk, pus_hk_structure_t* const structure,
                       const pus_request_t* const request, const uint32_t interval)
{
    (void)hk;
    (void)request;
    structure->interval = interval;
}

static void write_ids(octet_writer_t* const writer, const pus_hk_entry_t* const entries, const uint8_t count)
{
    octet_write_u16(writer, count);
    for (uint8_t i = 0U; i < count; i++) {
        octet_write_u32(writer, entries[i].parameter_id);
    }
}

static void write_state(octet_writer_t* const writer, const pus_hk_structure_t* const structure)
{
    octet_write_u16(writer, structure->id);
    octet_write_u8(writer, structure->is_periodic ? 1U : 0U);
    octet_write_u32(writer, structure->interval);
}

static void report_one(pus_hk_t* const hk, pus_hk_structure_t* const structure,
                       const pus_request_t* const request, const uint32_t interval)
{
    (void)interval;
    octet_writer_t writer = pus_answer_begin(request, 10U);
    write_state(&writer, structure);
    write_ids(&writer, structure->entries, structure->simple_count);
    octet_write_u16(&writer, structure->set_count);
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        octet_write_u16(&writer, structure->sets[i].repetitions);
        write_ids(&writer, &structure->entries[structure->sets[i].first], structure->sets[i].count);
    }
    (void)pus_tm_post(hk->config.process, &writer); // What is lost here the process counts.
}

/// Send TM[3,25] with the values of now to the user who asked.
static void sample_one(pus_hk_t* const hk, pus_hk_structure_t* const structure,
                       const pus_request_t* const request, const uint32_t interval)
{
    (void)interval;
    octet_writer_t writer = begin_report(hk, structure->id, request->token.source, request->now_ns);
    read_entries(hk, structure, 0U, structure->simple_count, &writer);
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        const pus_hk_set_t* const set = &structure->sets[i];
        for (uint16_t k = 0U; k < set->repetitions; k++) {
            read_entries(hk, structure, set->first, set->count, &writer);
        }
    }
    count(hk, pus_tm_post(hk->config.process, &writer));
}

/// That the structure is there is all that matters.
static void note_one(pus_hk_t* const hk, pus_hk_structure_t* const structure,
                     const pus_request_t* const request, const uint32_t interval)
{
    (void)hk;
    (void)structure;
    (void)request;
    (void)interval;
}

static pus_reply_t delete_structures(void* const self, pus_request_t* const request)
{
    static const operation_t operation = {true, false, remove_one};
    return for_each(self, request, &operation);
}

static pus_reply_t enable(void* const self, pus_request_t* const request)
{
    static const operation_t operation = {false, false, enable_one};
    return for_each(self, request, &operation);
}

static pus_reply_t disable(void* const self, pus_request_t* const request)
{
    static const operation_t operation = {false, false, disable_one};
    return for_each(self, request, &operation);
}

static pus_reply_t report_structures(void* const self, pus_request_t* const request)
{
    static const operation_t operation = {false, false, report_one};
    return for_each(self, request, &operation);
}

static pus_reply_t report_once(void* const self, pus_request_t* const request)
{
    static const operation_t operation = {false, false, sample_one};
    return for_each(self, request, &operation);
}

static pus_reply_t modify_intervals(void* const self, pus_request_t* const request)
{
    static const operation_t operation = {true, true, modify_one};
    return for_each(self, request, &operation);
}

static pus_reply_t report_properties(void* const self, pus_request_t* const request)
{
    static const operation_t operation = {false, false, note_one};
    pus_hk_t* const hk                 = self;
    const octet_reader_t list          = request->reader;
    (void)for_each(hk, request, &operation);
    if (request->performed == 0U) {
        return pus_done();
    }
    octet_writer_t writer = pus_answer_begin(request, 35U);
    octet_write_u16(&writer, request->performed);
    request->reader        = list;
    const uint8_t id_count = octet_read_u8(&request->reader);
    for (uint8_t i = 0U; i < id_count; i++) {
        const pus_hk_structure_t* const structure = hk_structure_of(hk, octet_read_u16(&request->reader));
        if (structure != NULL) {
            write_state(&writer, structure);
        }
    }
    (void)pus_tm_post(hk->config.process, &writer); // What is lost here the process counts.
    return pus_done();
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    pus_hk_step(self, now_ns, cycle);
}

pus_service_t pus_hk_service(pus_hk_t* const hk)
{
    static const pus_subtype_t subtypes[] = {
        {1U, shape_create, create, NULL},
        {3U, pus_shape_list_u16, delete_structures, NULL},
        {5U, pus_shape_list_u16, enable, NULL},
        {6U, pus_shape_list_u16, disable, NULL},
        {9U, pus_shape_list_u16, report_structures, NULL},
        {27U, pus_shape_list_u16, report_once, NULL},
        {29U, shape_append, append, NULL},
        {31U, shape_intervals, modify_intervals, NULL},
        {33U, pus_shape_list_u16, report_properties, NULL},
    };
    pus_service_t service =
        pus_service_of(PUS_SERVICE_HOUSEKEEPING, subtypes, sizeof(subtypes) / sizeof(subtypes[0]), hk);
    service.step = step;
    return service;
}
