// SPDX-License-Identifier: Apache-2.0
// Requests of ST[03] about structures. Each request has two subtypes: one for housekeeping structures and one
// for diagnostic structures.
#include "generated/pus/st03_request_formats.h"
#include "pus/st03/st03_structures.h"

/// True if a request is about diagnostic structures.
static bool is_diagnostic(const pus_request_t* const request)
{
    static const uint8_t subtypes[] = {2U, 4U, 7U, 8U, 11U, 28U, 30U, 32U, 34U};
    bool is_one                     = false;
    for (size_t i = 0U; i < sizeof subtypes; i++) {
        is_one = is_one || (subtypes[i] == request->token.subtype);
    }
    return is_one;
}

/// Add the parameters and sets of a request to the candidate, which becomes the structure `slot` if all are
/// valid.
static pus_reply_t add_requested(pus_hk_t* const hk, octet_reader_t* const reader,
                                 pus_hk_structure_t* const slot)
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
    hk_candidate_settle(hk, slot);
    return (hk->verdict.code == PUS_FAILURE_NONE) ? pus_done()
                                                  : pus_refused(hk->verdict.code, hk->verdict.detail);
}

static pus_reply_t create(void* const self, pus_request_t* const request)
{
    pus_hk_t* const hk       = self;
    const uint16_t id        = octet_read_u16(&request->reader);
    const uint32_t interval  = octet_read_u32(&request->reader);
    pus_hk_structure_t* slot = NULL;
    hk_candidate_begin(hk, is_diagnostic(request), id, interval, &slot);
    return add_requested(hk, &request->reader, slot);
}

static pus_reply_t append(void* const self, pus_request_t* const request)
{
    pus_hk_t* const hk                  = self;
    const uint16_t id                   = octet_read_u16(&request->reader);
    pus_hk_structure_t* const structure = hk_structure_of(hk, is_diagnostic(request), id);
    if (structure == NULL) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, id);
    }
    if (structure->is_periodic) {
        return pus_refused(PUS_FAILURE_STATE, id);
    }
    hk_candidate_extend(hk, structure);
    return add_requested(hk, &request->reader, structure);
}

/// Properties of a request with a list of structures, and the function that it performs on each of them.
typedef struct {
    bool needs_disabled; // Refused while the periodic generation is enabled.
    bool has_interval;   // An interval follows each id.
    void (*perform)(pus_hk_t*, pus_hk_structure_t*, pus_request_t*, uint32_t interval);
} operation_t;

static pus_reply_t for_each(pus_hk_t* const hk, pus_request_t* const request,
                            const operation_t* const operation)
{
    octet_reader_t* const reader = &request->reader;
    const uint8_t id_count       = octet_read_u8(reader);
    for (uint16_t i = 1U; i <= id_count; i++) {
        const uint16_t id                   = octet_read_u16(reader);
        const uint32_t offset               = (uint32_t)reader->position;
        const uint32_t interval             = operation->has_interval ? octet_read_u32(reader) : 0U;
        pus_hk_structure_t* const structure = hk_structure_of(hk, is_diagnostic(request), id);
        if (structure == NULL) {
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, id);
        } else if (operation->needs_disabled && structure->is_periodic) {
            pus_request_refuse(request, i, PUS_FAILURE_STATE, id);
        } else if (operation->has_interval && (interval < hk_interval_min(structure))) {
            pus_request_refuse(request, i, PUS_FAILURE_OUT_OF_RANGE, offset);
        } else {
            pus_request_perform(request);
            hk_lock(hk);
            operation->perform(hk, structure, request, interval);
            hk_unlock(hk);
        }
    }
    return pus_done();
}

static void remove_one(pus_hk_t* const hk, pus_hk_structure_t* const structure, pus_request_t* const request,
                       const uint32_t interval)
{
    (void)hk;
    (void)request;
    (void)interval;
    structure->in_use = false;
}

static void enable_one(pus_hk_t* const hk, pus_hk_structure_t* const structure, pus_request_t* const request,
                       const uint32_t interval)
{
    (void)hk;
    (void)request;
    (void)interval;
    hk_set_periodic(structure, true);
}

static void disable_one(pus_hk_t* const hk, pus_hk_structure_t* const structure, pus_request_t* const request,
                        const uint32_t interval)
{
    (void)hk;
    (void)request;
    (void)interval;
    hk_set_periodic(structure, false);
}

static void modify_one(pus_hk_t* const hk, pus_hk_structure_t* const structure, pus_request_t* const request,
                       const uint32_t interval)
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

static void report_one(pus_hk_t* const hk, pus_hk_structure_t* const structure, pus_request_t* const request,
                       const uint32_t interval)
{
    (void)hk;
    (void)interval;
    octet_writer_t writer = pus_answer_begin(request, is_diagnostic(request) ? 12U : 10U);
    write_state(&writer, structure);
    write_ids(&writer, structure->entries, structure->simple_count);
    octet_write_u16(&writer, structure->set_count);
    for (uint8_t i = 0U; i < structure->set_count; i++) {
        octet_write_u16(&writer, structure->sets[i].repetitions);
        write_ids(&writer, &structure->entries[structure->sets[i].first], structure->sets[i].count);
    }
    pus_answer_send(request, &writer);
}

static void sample_one(pus_hk_t* const hk, pus_hk_structure_t* const structure, pus_request_t* const request,
                       const uint32_t interval)
{
    (void)interval;
    hk_sample_now(hk, structure, request);
}

/// No effect: the caller only checks that the structure exists.
static void do_nothing(pus_hk_t* const hk, pus_hk_structure_t* const structure, pus_request_t* const request,
                       const uint32_t interval)
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
    static const operation_t operation = {false, false, do_nothing};
    pus_hk_t* const hk                 = self;
    const octet_reader_t list          = request->reader;
    (void)for_each(hk, request, &operation);
    if (request->performed == 0U) {
        return pus_done();
    }
    octet_writer_t writer = pus_answer_begin(request, is_diagnostic(request) ? 36U : 35U);
    octet_write_u16(&writer, request->performed);
    request->reader        = list;
    const uint8_t id_count = octet_read_u8(&request->reader);
    for (uint8_t i = 0U; i < id_count; i++) {
        const pus_hk_structure_t* const structure =
            hk_structure_of(hk, is_diagnostic(request), octet_read_u16(&request->reader));
        if (structure != NULL) {
            write_state(&writer, structure);
        }
    }
    pus_answer_send(request, &writer);
    return pus_done();
}

#define BOTH(housekeeping, diagnostic, execute)                                                              \
    PUS_REQUEST(3, housekeeping, execute), PUS_REQUEST(3, diagnostic, execute)

pus_service_t hk_requests(pus_hk_t* const hk)
{
    static const pus_subtype_t subtypes[] = {
        BOTH(1, 2, create),
        BOTH(3, 4, delete_structures),
        BOTH(5, 7, enable),
        BOTH(6, 8, disable),
        BOTH(9, 11, report_structures),
        BOTH(27, 28, report_once),
        BOTH(29, 30, append),
        BOTH(31, 32, modify_intervals),
        BOTH(33, 34, report_properties),
        PUS_REQUEST(3, 37, hk_functional_apply),
        PUS_REQUEST(3, 38, hk_functional_create),
        PUS_REQUEST(3, 39, hk_functional_delete),
        PUS_REQUEST(3, 40, hk_functional_report),
        PUS_REQUEST(3, 42, hk_functional_add),
        PUS_REQUEST(3, 43, hk_functional_remove),
        PUS_REQUEST(3, 44, hk_functional_modify),
    };
    return pus_service_of(PUS_SERVICE_HOUSEKEEPING, subtypes, sizeof subtypes / sizeof subtypes[0], hk);
}
