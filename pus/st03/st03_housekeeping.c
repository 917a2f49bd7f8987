// SPDX-License-Identifier: Apache-2.0
#include "pus/st03/st03_housekeeping.h"

#include "base/assertion.h"
#include "pus/st03/st03_structures.h"

#include <string.h>

enum { // Reports.
    HOUSEKEEPING = 25,
    DIAGNOSTIC   = 26
};

void pus_hk_init(pus_hk_t* const hk, const pus_hk_config_t* const config)
{
    FSW_ASSERT((hk != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->parameters.find != NULL) && (config->parameters.read != NULL) &&
               (config->structures != NULL) && (config->samples != NULL) &&
               ((config->functional != NULL) || (config->functional_count == 0U)));
    FSW_ASSERT((config->sample_size + HK_ID_SIZE) <= PUS_TM_DATA_MAX);
    (void)memset(hk, 0, sizeof *hk);
    hk->config = *config;
    pus_hk_clear(hk);
    for (uint16_t i = 0U; i < config->functional_count; i++) {
        config->functional[i].in_use = false;
    }
}

void hk_lock(const pus_hk_t* const hk)
{
    if (hk->config.mutex != NULL) {
        // This cannot fail: a task that dies ends the process, so no other task is left to lock the mutex.
        (void)osal_mutex_lock(hk->config.mutex);
    }
}

void hk_unlock(const pus_hk_t* const hk)
{
    if (hk->config.mutex != NULL) {
        osal_mutex_unlock(hk->config.mutex);
    }
}

void pus_hk_clear(pus_hk_t* const hk)
{
    FSW_ASSERT(hk != NULL);
    hk_lock(hk);
    for (uint16_t i = 0U; i < hk->config.structure_count; i++) {
        hk->config.structures[i].in_use = false;
    }
    hk_unlock(hk);
}

void hk_candidate_settle(const pus_hk_t* const hk, pus_hk_structure_t* const slot)
{
    if (hk->verdict.code == PUS_FAILURE_NONE) {
        hk_lock(hk);
        *slot = hk->candidate;
        hk_unlock(hk);
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
    pus_hk_structure_t* slot = NULL;
    hk_candidate_begin(hk, definition->is_diagnostic, definition->id, definition->interval, &slot);
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
    hk_candidate_settle(hk, slot);
    return status_of(hk->verdict.code);
}

// ---- Reports ----

static void read_entries(const pus_hk_t* const hk, const pus_hk_structure_t* const structure,
                         const uint8_t first, const uint8_t count, octet_writer_t* const writer)
{
    const pus_parameter_port_t* const port = &hk->config.parameters;
    for (uint8_t i = 0U; i < count; i++) {
        const pus_hk_entry_t* const entry = &structure->entries[first + i];
        const size_t end                  = writer->position + entry->size;
        port->read(port->context, entry->handle, writer);
        FSW_ASSERT(writer->position == end); // The port must write exactly the size that it has reported.
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

/// Write the values of a report at the end of an interval.
static void write_collected(const pus_hk_t* const hk, const pus_hk_structure_t* const structure,
                            const uint8_t* const samples, octet_writer_t* const writer)
{
    read_entries(hk, structure, 0U, structure->simple_count, writer);
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        const pus_hk_set_t* const set = &structure->sets[i];
        octet_write_octets(writer, &samples[set->offset], (size_t)set->size * set->repetitions);
    }
}

/// Begin TM[3,25] or [3,26].
static octet_writer_t begin_report(const pus_hk_t* const hk, const bool is_diagnostic, const uint16_t id,
                                   const uint16_t destination, const uint64_t now_ns)
{
    octet_writer_t writer = pus_tm_begin(hk->config.process, PUS_SERVICE_HOUSEKEEPING,
                                         is_diagnostic ? DIAGNOSTIC : HOUSEKEEPING, destination, now_ns);
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

/// Send a report; in a loop of services, pass its values to the outlet, so that the main loop sends it.
static void hand_over(pus_hk_t* const hk, const pus_hk_structure_t* const structure,
                      const uint8_t* const samples, const uint64_t now_ns,
                      const pus_hk_outlet_t* const outlet)
{
    octet_writer_t writer =
        (outlet == NULL) ? begin_report(hk, structure->is_diagnostic, structure->id, PUS_USER_GROUND, now_ns)
                         : octet_writer(outlet->values, hk->config.sample_size);
    write_collected(hk, structure, samples, &writer);
    if (outlet == NULL) {
        count(hk, pus_tm_send(hk->config.process, &writer));
    } else {
        outlet->put(outlet->context, structure->id, now_ns, outlet->values, writer.position);
    }
}

/// Perform one cycle of a structure whose periodic generation is enabled.
static void collect(pus_hk_t* const hk, pus_hk_structure_t* const structure, uint8_t* const samples,
                    const uint64_t now_ns, const uint32_t cycle, const pus_hk_outlet_t* const outlet)
{
    if (!structure->is_collecting) {
        structure->is_collecting = true;
        restart(structure, cycle - 1U);
    }
    // Unsigned subtraction: correct also after the counter has wrapped.
    const uint32_t elapsed = cycle - structure->start;
    const bool is_complete = elapsed >= structure->interval;
    for (uint8_t k = 0U; k < structure->set_count; k++) {
        sample_set(hk, structure, &structure->sets[k], is_complete ? structure->interval : elapsed, samples);
    }
    if (is_complete) {
        hand_over(hk, structure, samples, now_ns, outlet);
        restart(structure,
                // The phase of the intervals is kept if cycles were missed.
                cycle - (elapsed % structure->interval));
    }
}

/// Perform one cycle of the structures of a loop.
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
    octet_writer_t writer = begin_report(hk, false, id, PUS_USER_GROUND, taken_ns);
    octet_write_octets(&writer, values, size);
    count(hk, pus_tm_send(hk->config.process, &writer));
}

void pus_hk_count_lost(pus_hk_t* const hk, const uint32_t reports)
{
    FSW_ASSERT(hk != NULL);
    hk->counters.dropped += reports;
}

void hk_set_periodic(pus_hk_structure_t* const structure, const bool is_periodic)
{
    if (is_periodic && !structure->is_periodic) {
        structure->is_collecting = false; // The next step begins the interval.
    }
    structure->is_periodic = is_periodic;
}

uint32_t hk_interval_min(const pus_hk_structure_t* const structure)
{
    uint32_t interval = 1U;
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        const uint32_t repetitions = structure->sets[i].repetitions;
        interval                   = (repetitions > interval) ? repetitions : interval;
    }
    return interval;
}

void hk_sample_now(pus_hk_t* const hk, const pus_hk_structure_t* const structure,
                   pus_request_t* const request)
{
    octet_writer_t writer =
        begin_report(hk, structure->is_diagnostic, structure->id, request->token.source, request->now_ns);
    read_entries(hk, structure, 0U, structure->simple_count, &writer);
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        const pus_hk_set_t* const set = &structure->sets[i];
        for (uint16_t k = 0U; k < set->repetitions; k++) {
            read_entries(hk, structure, set->first, set->count, &writer);
        }
    }
    const uint32_t out  = request->packets_out;
    const uint32_t lost = request->packets_lost;
    pus_answer_send(request, &writer);
    hk->counters.dropped += request->packets_lost - lost;
    hk->counters.reports += (request->packets_out - out) - (request->packets_lost - lost);
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    pus_hk_step(self, now_ns, cycle);
}

pus_service_t pus_hk_service(pus_hk_t* const hk)
{
    pus_service_t service = hk_requests(hk);
    service.step          = step;
    return service;
}
