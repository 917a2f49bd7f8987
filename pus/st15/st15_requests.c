// SPDX-License-Identifier: Apache-2.0
// Requests of ST[15], and their answers.
#include "base/assertion.h"
#include "generated/pus/st15_request_formats.h"
#include "pus/st15/st15_internal.h"

#include <string.h>

enum { // Subtypes that the functions of this file distinguish.
    ENABLE              = 1,
    DISABLE             = 2,
    ADD_TYPES           = 3,
    REPORT_TYPES        = 5,
    START_RANGE         = 9,
    DELETE_CONTENT      = 11,
    SUMMARY             = 13,
    CHANGE_TAG          = 14,
    RESUME              = 15,
    SUSPEND             = 16,
    ABORT_RANGE         = 17,
    STATUS              = 19,
    CREATE              = 20,
    DELETE              = 21,
    CONFIGURATION       = 23,
    RESIZE              = 25,
    MAKE_CIRCULAR       = 26,
    MAKE_BOUNDED        = 27,
    CHANGE_CHANNEL      = 28,
    ADD_HOUSEKEEPING    = 29,
    REPORT_HOUSEKEEPING = 35
};

#define ANSWER_OFFSET 1U // Subtype of a content report minus that of its request.
#define PER_CENT 100U

static uint32_t id_of(const uint8_t* const name)
{
    return octets_u32_at(name);
}

// ---- Instructions on stores ----

/// One instruction; fields that the request does not contain are 0.
typedef struct {
    pus_storage_t* storage;
    uint8_t subtype;
    uint8_t number; ///< Number of the store.
    const uint8_t* name;
    bool is_for_all;
    bool has_good_times;
    uint8_t priority;
    uint8_t type;
    uint8_t virtual_channel;
    uint32_t size;
    uint64_t from_ns;
    uint64_t to_ns;
    status_t status; ///< Valid after PUS_FAILURE_IO.
} instruction_t;

static void read_time(instruction_t* const instruction, octet_reader_t* const reader,
                      uint64_t* const out_time_ns)
{
    instruction->has_good_times =
        (pus_time_read(reader, out_time_ns) == STATUS_OK) && instruction->has_good_times;
}

/// Read the fields of an instruction after the name of the store.
static void read_fields(instruction_t* const instruction, octet_reader_t* const reader)
{
    switch (instruction->subtype) {
    case START_RANGE:
        instruction->priority = octet_read_u8(reader);
        read_time(instruction, reader, &instruction->from_ns);
        read_time(instruction, reader, &instruction->to_ns);
        break;
    case RESUME:
        instruction->priority = octet_read_u8(reader);
        break;
    case CREATE:
        instruction->size            = octet_read_u32(reader);
        instruction->type            = octet_read_u8(reader);
        instruction->virtual_channel = octet_read_u8(reader);
        break;
    case RESIZE:
        instruction->size = octet_read_u32(reader);
        break;
    case CHANGE_CHANNEL:
        instruction->virtual_channel = octet_read_u8(reader);
        break;
    default: // The instruction has no further fields.
        break;
    }
}

static bool is_in_use(const instruction_t* const instruction)
{
    return (instruction->storage->stores[instruction->number].state.retrieval !=
            (uint8_t)PUS_RETRIEVAL_NONE) ||
           st15_is_copying(instruction->storage, instruction->number);
}

// ---- Checks of instructions ----

// Each function checks an instruction and computes the next state of the store. PUS_FAILURE_NONE, or the
// failure.
static uint16_t enable(const instruction_t* const instruction, pus_store_state_t* const next)
{
    next->is_enabled = instruction->subtype == (uint8_t)ENABLE;
    return PUS_FAILURE_NONE;
}

static uint16_t start_range(const instruction_t* const instruction, pus_store_state_t* const next)
{
    const pus_packet_store_t* const log = &instruction->storage->stores[instruction->number].log;
    if (!instruction->has_good_times || (instruction->from_ns > instruction->to_ns)) {
        return PUS_FAILURE_OUT_OF_RANGE;
    }
    if (next->retrieval != (uint8_t)PUS_RETRIEVAL_NONE) {
        return PUS_FAILURE_STATE;
    }
    next->retrieval    = (uint8_t)PUS_RETRIEVAL_RANGE;
    next->priority     = instruction->priority;
    next->from_ns      = instruction->from_ns;
    next->to_ns        = instruction->to_ns;
    next->range_cursor = pus_packet_store_tail(log);
    next->range_end    = pus_packet_store_head(log);
    return PUS_FAILURE_NONE;
}

static uint16_t delete_content(const instruction_t* const instruction, pus_store_state_t* const next)
{
    if (is_in_use(instruction)) {
        return PUS_FAILURE_STATE;
    }
    const uint64_t tail = pus_packet_store_find_after(&instruction->storage->stores[instruction->number].log,
                                                      instruction->to_ns);
    next->tail          = (tail > next->tail) ? tail : next->tail;
    return PUS_FAILURE_NONE;
}

static uint16_t change_tag(const instruction_t* const instruction, pus_store_state_t* const next)
{
    if (next->retrieval == (uint8_t)PUS_RETRIEVAL_OPEN) {
        return PUS_FAILURE_STATE;
    }
    next->open_tag_ns = instruction->to_ns;
    next->is_seeking  = true;
    next->open_cursor =
        pus_packet_store_find(&instruction->storage->stores[instruction->number].log, instruction->to_ns);
    return PUS_FAILURE_NONE;
}

static uint16_t resume(const instruction_t* const instruction, pus_store_state_t* const next)
{
    if (next->retrieval == (uint8_t)PUS_RETRIEVAL_RANGE) {
        return PUS_FAILURE_STATE;
    }
    next->retrieval = (uint8_t)PUS_RETRIEVAL_OPEN;
    next->priority  = instruction->is_for_all ? next->priority : instruction->priority;
    return PUS_FAILURE_NONE;
}

/// Suspend an open retrieval, or abort a retrieval by time range; a retrieval of another kind continues.
static uint16_t stop(const instruction_t* const instruction, pus_store_state_t* const next)
{
    const pus_retrieval_t kind =
        (instruction->subtype == (uint8_t)SUSPEND) ? PUS_RETRIEVAL_OPEN : PUS_RETRIEVAL_RANGE;
    if (next->retrieval == (uint8_t)kind) {
        next->retrieval = (uint8_t)PUS_RETRIEVAL_NONE;
    }
    return PUS_FAILURE_NONE;
}

static uint16_t delete_store(const instruction_t* const instruction, pus_store_state_t* const next)
{
    if (next->is_enabled || is_in_use(instruction)) {
        return PUS_FAILURE_STATE;
    }
    next->is_there = false;
    return PUS_FAILURE_NONE;
}

/// Change size, type or virtual channel.
static uint16_t reconfigure(const instruction_t* const instruction, pus_store_state_t* const next)
{
    const bool is_channel = instruction->subtype == (uint8_t)CHANGE_CHANNEL;
    if (is_in_use(instruction) || (next->is_enabled && !is_channel)) {
        return PUS_FAILURE_STATE;
    }
    if (is_channel) {
        next->virtual_channel = instruction->virtual_channel;
    } else if (instruction->subtype == (uint8_t)RESIZE) {
        next->size = instruction->size;
    } else {
        next->type = (uint8_t)((instruction->subtype == (uint8_t)MAKE_CIRCULAR) ? PUS_STORE_CIRCULAR
                                                                                : PUS_STORE_BOUNDED);
    }
    const uint16_t used =
        pus_packet_store_blocks_used(&instruction->storage->stores[instruction->number].log);
    const bool is_good = st15_is_possible(instruction->storage, next) && (st15_blocks_of(next->size) >= used);
    return is_good ? PUS_FAILURE_NONE : PUS_FAILURE_OUT_OF_RANGE;
}

static uint16_t create(const instruction_t* const instruction, pus_store_state_t* const next)
{
    // Packets on the medium have an older generation, so they are not packets of the new store.
    const uint32_t generation = next->generation + 1U;
    *next                     = (pus_store_state_t){.is_there        = true,
                                                    .size            = instruction->size,
                                                    .type            = instruction->type,
                                                    .virtual_channel = instruction->virtual_channel,
                                                    .generation      = generation};
    (void)memcpy(next->name, instruction->name, PUS_NAME_SIZE);
    return st15_is_possible(instruction->storage, next) ? PUS_FAILURE_NONE : PUS_FAILURE_OUT_OF_RANGE;
}

typedef struct {
    uint8_t subtype;
    uint16_t (*decide)(const instruction_t* instruction, pus_store_state_t* next);
} action_t;

static uint16_t decide(const instruction_t* const instruction, pus_store_state_t* const next)
{
    static const action_t actions[] = {
        {ENABLE, enable},
        {DISABLE, enable},
        {START_RANGE, start_range},
        {DELETE_CONTENT, delete_content},
        {CHANGE_TAG, change_tag},
        {RESUME, resume},
        {SUSPEND, stop},
        {ABORT_RANGE, stop},
        {CREATE, create},
        {DELETE, delete_store},
    };
    const uint8_t count = (uint8_t)(sizeof actions / sizeof actions[0]);
    uint8_t i           = 0U;
    while ((i < count) && (actions[i].subtype != instruction->subtype)) {
        i++;
    }
    return (i < count) ? actions[i].decide(instruction, next) : reconfigure(instruction, next);
}

/// Find the store of an instruction. PUS_FAILURE_NONE, or the failure.
static uint16_t find_store(instruction_t* const instruction)
{
    const pus_storage_t* const storage = instruction->storage;
    const uint8_t count                = storage->config.store_count;
    instruction->number                = st15_find(storage, instruction->name);
    const bool is_found                = instruction->number < count;
    if (instruction->subtype != (uint8_t)CREATE) {
        return is_found ? PUS_FAILURE_NONE : PUS_FAILURE_UNKNOWN_ID;
    }
    if (is_found) {
        return PUS_FAILURE_EXISTS;
    }
    instruction->number = 0U;
    while ((instruction->number < count) && storage->stores[instruction->number].state.is_there) {
        instruction->number++;
    }
    return (instruction->number < count) ? PUS_FAILURE_NONE : PUS_FAILURE_TABLE_FULL;
}

/// Perform an instruction whose store has been found.
static uint16_t carry_out(instruction_t* const instruction)
{
    pus_storage_t* const storage = instruction->storage;
    pus_store_t* const store     = &storage->stores[instruction->number];
    pus_store_state_t next       = store->state;
    const uint16_t code          = decide(instruction, &next);
    if (code != PUS_FAILURE_NONE) {
        return code;
    }
    instruction->status = STATUS_OK;
    if (instruction->subtype == (uint8_t)CREATE) { // A new store selects no reports.
        pus_selection_t none = store->selection;
        none.count           = 0U;
        instruction->status =
            pus_selection_put(&storage->editor, &none, PUS_STORE_SELECTION_KEY + instruction->number);
    }
    instruction->status = (instruction->status == STATUS_OK)
                              ? st15_replace(storage, instruction->number, &next)
                              : instruction->status;
    if (instruction->status != STATUS_OK) {
        return PUS_FAILURE_IO;
    }
    if (instruction->subtype == (uint8_t)CREATE) {
        store->selection.count = 0U;
        store->sent            = 0U;
    }
    return PUS_FAILURE_NONE;
}

/// Detail of a refusal. `offset` is the octet offset after the instruction.
static uint32_t detail_of(const instruction_t* const instruction, const uint16_t code, const size_t offset)
{
    switch (code) {
    case PUS_FAILURE_IO:
        return (uint32_t)instruction->status;
    case PUS_FAILURE_OUT_OF_RANGE:
        return (uint32_t)offset;
    case PUS_FAILURE_TABLE_FULL:
        return instruction->storage->config.store_count;
    default:
        return id_of(instruction->name);
    }
}

/// Read and perform the next instruction of a request.
static uint16_t next_instruction(instruction_t* const instruction, octet_reader_t* const reader)
{
    instruction->name = octet_read_octets(reader, PUS_NAME_SIZE);
    read_fields(instruction, reader);
    const uint16_t code = find_store(instruction);
    return (code == PUS_FAILURE_NONE) ? carry_out(instruction) : code;
}

/// Perform a request with a list of stores.
static pus_reply_t execute_list(void* const self, pus_request_t* const request)
{
    octet_reader_t* const reader = &request->reader;
    instruction_t instruction = {.storage = self, .subtype = request->token.subtype, .has_good_times = true};
    if ((instruction.subtype == (uint8_t)DELETE_CONTENT) || (instruction.subtype == (uint8_t)CHANGE_TAG)) {
        read_time(&instruction, reader, &instruction.to_ns);
        if (!instruction.has_good_times) {
            return pus_refused(PUS_FAILURE_OUT_OF_RANGE, (uint32_t)reader->position);
        }
    }
    const uint8_t count = octet_read_u8(reader);
    for (uint16_t i = 1U; i <= count; i++) {
        instruction.has_good_times = true;
        const uint16_t code        = next_instruction(&instruction, reader);
        if (code == PUS_FAILURE_NONE) {
            pus_request_perform(request);
        } else {
            pus_request_refuse(request, i, code, detail_of(&instruction, code, reader->position));
        }
    }
    instruction.is_for_all = count == 0U;
    for (instruction.number = 0U;
         instruction.is_for_all && (instruction.number < instruction.storage->config.store_count);
         instruction.number++) {
        if (instruction.storage->stores[instruction.number].state.is_there &&
            (carry_out(&instruction) == PUS_FAILURE_IO)) {
            return pus_failed(PUS_FAILURE_IO, (uint32_t)instruction.status);
        }
    }
    return pus_done();
}

/// Perform a request for one store.
static pus_reply_t execute_one(void* const self, pus_request_t* const request)
{
    instruction_t instruction = {.storage = self, .subtype = request->token.subtype};
    const uint16_t code       = next_instruction(&instruction, &request->reader);
    return (code == PUS_FAILURE_NONE)
               ? pus_done()
               : pus_refused(code, detail_of(&instruction, code, request->reader.position));
}

// ---- Copy ----

static bool read_window(octet_reader_t* const reader, pus_store_copy_t* const copy)
{
    enum {
        FROM_TO = 1,
        FROM    = 2,
        TO      = 3
    };
    const uint8_t type  = octet_read_u8(reader);
    instruction_t times = {.has_good_times = true};
    if ((type == (uint8_t)FROM_TO) || (type == (uint8_t)FROM)) {
        read_time(&times, reader, &copy->from_ns);
    }
    if ((type == (uint8_t)FROM_TO) || (type == (uint8_t)TO)) {
        read_time(&times, reader, &copy->to_ns);
    }
    return times.has_good_times && (copy->from_ns <= copy->to_ns);
}

static pus_reply_t execute_copy(void* const self, pus_request_t* const request)
{
    pus_storage_t* const storage = self;
    octet_reader_t* const reader = &request->reader;
    const uint8_t count          = storage->config.store_count;
    pus_store_copy_t copy        = {.is_active = true, .token = request->token, .to_ns = UINT64_MAX};
    if (!read_window(reader, &copy)) {
        return pus_refused(PUS_FAILURE_OUT_OF_RANGE, (uint32_t)reader->position);
    }
    const uint8_t* const source = octet_read_octets(reader, PUS_NAME_SIZE);
    const uint8_t* const target = octet_read_octets(reader, PUS_NAME_SIZE);
    copy.source                 = st15_find(storage, source);
    copy.target                 = st15_find(storage, target);
    if ((copy.source == count) || (copy.target == count)) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, id_of((copy.source == count) ? source : target));
    }
    const pus_store_t* const to         = &storage->stores[copy.target];
    const pus_packet_store_t* const log = &storage->stores[copy.source].log;
    if (storage->copy.is_active || to->is_failed || (copy.source == copy.target) ||
        (pus_packet_store_tail(&to->log) != pus_packet_store_head(&to->log))) {
        return pus_refused(PUS_FAILURE_STATE, id_of(target));
    }
    copy.cursor   = pus_packet_store_tail(log);
    copy.end      = pus_packet_store_head(log);
    storage->copy = copy;
    return pus_later();
}

// ---- Selections ----

static pus_selection_list_t list_of(const uint8_t subtype)
{
    if (subtype < (uint8_t)ADD_HOUSEKEEPING) {
        return PUS_SELECTED_TYPES;
    }
    const uint8_t first =
        (subtype < (uint8_t)REPORT_HOUSEKEEPING) ? (uint8_t)ADD_HOUSEKEEPING : (uint8_t)REPORT_HOUSEKEEPING;
    return (pus_selection_list_t)(((subtype - first) / 2U) + 1U); // Each list has two subtypes.
}

/// Read the name of a store. Returns the number of the store, or store_count if there is none.
static uint8_t read_store(const pus_storage_t* const storage, pus_request_t* const request,
                          const uint8_t** const out_name)
{
    *out_name = octet_read_octets(&request->reader, PUS_NAME_SIZE);
    return st15_find(storage, *out_name);
}

static pus_reply_t execute_selection(void* const self, pus_request_t* const request)
{
    pus_storage_t* const storage = self;
    const uint8_t subtype        = request->token.subtype;
    const uint8_t* name          = NULL;
    const uint8_t number         = read_store(storage, request, &name);
    if (number == storage->config.store_count) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, id_of(name));
    }
    // Additions have odd subtypes, except for events, where the subtype of the deletion comes first.
    const pus_selection_list_t list  = list_of(subtype);
    const bool is_addition           = ((subtype % 2U) == 1U) != (list == PUS_BLOCKED_EVENTS);
    pus_selection_t* const selection = &storage->stores[number].selection;
    const uint32_t key               = PUS_STORE_SELECTION_KEY + (uint32_t)number;
    return is_addition ? pus_selection_add(&storage->editor, selection, list, key, request)
                       : pus_selection_delete(&storage->editor, selection, list, key, request);
}

static pus_reply_t report_selection(void* const self, pus_request_t* const request)
{
    const pus_storage_t* const storage = self;
    const uint8_t subtype              = request->token.subtype;
    const uint8_t* name                = NULL;
    const uint8_t number               = read_store(storage, request, &name);
    if (number == storage->config.store_count) {
        return pus_refused(PUS_FAILURE_UNKNOWN_ID, id_of(name));
    }
    pus_request_perform(request);
    pus_selection_report(&storage->stores[number].selection, list_of(subtype), request,
                         (uint8_t)(subtype + ANSWER_OFFSET), name);
    return pus_done();
}

// ---- Reports on stores ----

/// Returns the share of a store that the packets from an address on fill [per cent, rounded up].
static uint8_t filled_from(const pus_packet_store_t* const log, const uint64_t cursor)
{
    const uint64_t address = pus_packet_store_next_address(log, cursor);
    const uint64_t head    = pus_packet_store_head(log);
    const uint64_t size    = (uint64_t)log->limit * PUS_STORE_BLOCK;
    const uint64_t octets  = (address < head) ? (head - address) : 0U;
    return (uint8_t)(((octets * PER_CENT) + (size - 1U)) / size);
}

static void write_summary(octet_writer_t* const writer, pus_store_t* const store)
{
    pus_time_write(writer, pus_packet_store_oldest_ns(&store->log));
    pus_time_write(writer, pus_packet_store_newest_ns(&store->log));
    pus_time_write(writer, store->state.open_tag_ns);
    octet_write_u8(writer, filled_from(&store->log, pus_packet_store_tail(&store->log)));
    octet_write_u8(writer, filled_from(&store->log, store->state.open_cursor));
}

static void write_status(octet_writer_t* const writer, pus_store_t* const store)
{
    const pus_store_state_t* const state = &store->state;
    octet_write_u8(writer, state->is_enabled ? 1U : 0U);
    octet_write_u8(writer, (state->retrieval == (uint8_t)PUS_RETRIEVAL_OPEN) ? 1U : 0U);
    octet_write_u8(writer, (state->retrieval == (uint8_t)PUS_RETRIEVAL_RANGE) ? 1U : 0U);
}

static void write_configuration(octet_writer_t* const writer, pus_store_t* const store)
{
    octet_write_u32(writer, store->state.size);
    octet_write_u8(writer, store->state.type);
    octet_write_u8(writer, store->state.virtual_channel);
}

/// Answer with an entry for each store in `set`, a bit set with one bit per store.
static pus_reply_t report_stores(pus_storage_t* const storage, const pus_request_t* const request,
                                 const uint8_t subtype, const uint32_t set,
                                 void (*const write)(octet_writer_t*, pus_store_t*))
{
    uint16_t count        = 0U;
    octet_writer_t writer = pus_list_begin(request, subtype);
    for (uint8_t i = 0U; i < storage->config.store_count; i++) {
        pus_store_t* const store = &storage->stores[i];
        if (store->state.is_there && ((set & (1UL << i)) != 0U)) {
            octet_write_octets(&writer, store->state.name, PUS_NAME_SIZE);
            write(&writer, store);
            count++;
        }
    }
    return pus_list_end(request, &writer, count);
}

static pus_reply_t report_status(void* const self, pus_request_t* const request)
{
    pus_request_perform(request);
    return report_stores(self, request, STATUS, UINT32_MAX, write_status);
}

static pus_reply_t report_configuration(void* const self, pus_request_t* const request)
{
    pus_request_perform(request);
    return report_stores(self, request, CONFIGURATION, UINT32_MAX, write_configuration);
}

static pus_reply_t report_summary(void* const self, pus_request_t* const request)
{
    pus_storage_t* const storage = self;
    const uint8_t count          = octet_read_u8(&request->reader);
    uint32_t set                 = 0U;
    for (uint16_t i = 1U; i <= count; i++) {
        const uint8_t* name  = NULL;
        const uint8_t number = read_store(storage, request, &name);
        if (number == storage->config.store_count) {
            pus_request_refuse(request, i, PUS_FAILURE_UNKNOWN_ID, id_of(name));
        } else if ((set & (1UL << number)) != 0U) {
            pus_request_refuse(request, i, PUS_FAILURE_DUPLICATE, id_of(name));
        } else {
            set |= (uint32_t)(1UL << number);
            pus_request_perform(request);
        }
    }
    if (count == 0U) {
        set = UINT32_MAX;
        pus_request_perform(request);
    }
    return (set != 0U) ? report_stores(storage, request, SUMMARY, set, write_summary) : pus_done();
}

pus_service_t pus_storage_service(pus_storage_t* const storage)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(15, 1, execute_list),       PUS_REQUEST(15, 2, execute_list),
        PUS_REQUEST(15, 3, execute_selection),  PUS_REQUEST(15, 4, execute_selection),
        PUS_REQUEST(15, 5, report_selection),   PUS_REQUEST(15, 9, execute_list),
        PUS_REQUEST(15, 11, execute_list),      PUS_REQUEST(15, 12, report_summary),
        PUS_REQUEST(15, 14, execute_list),      PUS_REQUEST(15, 15, execute_list),
        PUS_REQUEST(15, 16, execute_list),      PUS_REQUEST(15, 17, execute_list),
        PUS_REQUEST(15, 18, report_status),     PUS_REQUEST(15, 20, execute_list),
        PUS_REQUEST(15, 21, execute_list),      PUS_REQUEST(15, 22, report_configuration),
        PUS_REQUEST(15, 24, execute_copy),      PUS_REQUEST(15, 25, execute_list),
        PUS_REQUEST(15, 26, execute_one),       PUS_REQUEST(15, 27, execute_one),
        PUS_REQUEST(15, 28, execute_one),       PUS_REQUEST(15, 29, execute_selection),
        PUS_REQUEST(15, 30, execute_selection), PUS_REQUEST(15, 31, execute_selection),
        PUS_REQUEST(15, 32, execute_selection), PUS_REQUEST(15, 33, execute_selection),
        PUS_REQUEST(15, 34, execute_selection), PUS_REQUEST(15, 35, report_selection),
        PUS_REQUEST(15, 37, report_selection),  PUS_REQUEST(15, 39, report_selection),
    };
    return pus_service_of(PUS_SERVICE_STORAGE, subtypes, sizeof subtypes / sizeof subtypes[0], storage);
}
