// SPDX-License-Identifier: Apache-2.0
#include "pus/st02/st02_device_access.h"

#include "base/assertion.h"
#include "generated/pus/st02_request_formats.h"
#include "pus/st01/st01_verification.h"

#include <string.h>

enum { // Reports.
    REGISTERS     = 6,
    PHYSICAL_DATA = 9,
    LOGICAL_DATA  = 12
};

enum { // Phases of a request in progress.
    FREE,
    NEXT,      // The next instruction is to be taken.
    BEGINNING, // The port has not accepted the instruction yet.
    GOING_ON,  // The port performs the instruction.
    REPORTING, // The report of the instruction has to be sent.
    ENDING
};

// Largest number of phases of a request in one step: about 30 instructions that end at once.
#define TRANSITIONS_MAX 96U
#define REGISTER_SIZE 4U
#define LINE_SHIFT 4U // Fields of a pulse: line (12 bits), reserved (1), exponent (3).
#define PULSE_RESERVED 0x8U
#define PULSE_EXPONENT 0x7U

void pus_device_access_init(pus_device_access_t* const access, const pus_device_config_t* const config)
{
    FSW_ASSERT((access != NULL) && (config != NULL) && (config->process != NULL) &&
               (config->port.check != NULL) && (config->port.begin != NULL) && (config->port.poll != NULL) &&
               (config->port.abandon != NULL) && (config->operations != NULL));
    *access = (pus_device_access_t){.config = *config};
    for (uint8_t i = 0U; i < config->operation_count; i++) {
        config->operations[i].phase = FREE;
    }
}

// ---- Instructions ----

static pus_device_cursor_t cursor_of(const octet_reader_t* const reader, const uint8_t kind)
{
    pus_device_cursor_t cursor = {.reader = *reader, .kind = kind};
    cursor.left                = octet_read_u8(&cursor.reader);
    return cursor;
}

static void read_sized(octet_reader_t* const reader, pus_device_action_t* const action)
{
    action->size = octet_read_u16(reader);
    action->data = octet_read_octets(reader, action->size);
}

/// Read a pulse. If the reserved bit is set, the exponent gets an invalid value.
static void read_pulse(pus_device_cursor_t* const cursor, pus_device_action_t* const action)
{
    if (cursor->inner == 0U) {
        cursor->cpdu   = octet_read_u8(&cursor->reader);
        cursor->inner  = octet_read_u8(&cursor->reader);
        cursor->offset = (uint32_t)cursor->reader.position;
    }
    const uint16_t pulse = octet_read_u16(&cursor->reader);
    cursor->inner--;
    // A CPDU is counted in `left` until its last pulse was read.
    cursor->left     = (uint8_t)(cursor->left + ((cursor->inner > 0U) ? 1U : 0U));
    action->device   = cursor->cpdu;
    action->command  = (uint16_t)(pulse >> LINE_SHIFT);
    action->exponent = (uint8_t)(pulse & (PULSE_RESERVED | PULSE_EXPONENT));
}

/// Read the next instruction. False: there is none.
static bool read_next(pus_device_cursor_t* const cursor, pus_device_action_t* const action)
{
    octet_reader_t* const reader = &cursor->reader;
    if (cursor->left == 0U) {
        return false;
    }
    *action        = (pus_device_action_t){.kind = cursor->kind};
    cursor->offset = (uint32_t)reader->position;
    cursor->left--;
    cursor->number++;
    switch (cursor->kind) {
    case PUS_DEVICE_SWITCH:
        action->device = octet_read_u16(reader);
        break;
    case PUS_DEVICE_LOAD_REGISTER:
        action->address = octet_read_u32(reader);
        action->size    = REGISTER_SIZE;
        action->data    = octet_read_octets(reader, REGISTER_SIZE);
        break;
    case PUS_DEVICE_PULSE:
        read_pulse(cursor, action);
        break;
    case PUS_DEVICE_DUMP_REGISTER:
        action->address = octet_read_u32(reader);
        break;
    case PUS_DEVICE_COMMAND:
        action->device   = octet_read_u16(reader);
        action->protocol = octet_read_octets(reader, PUS_DEVICE_PROTOCOL_SIZE);
        read_sized(reader, action);
        break;
    case PUS_DEVICE_ACQUIRE:
        cursor->transaction = octet_read_u16(reader);
        action->device      = octet_read_u16(reader);
        action->protocol    = octet_read_octets(reader, PUS_DEVICE_PROTOCOL_SIZE);
        break;
    case PUS_DEVICE_LOGICAL_COMMAND:
        action->device  = octet_read_u16(reader);
        action->command = octet_read_u16(reader);
        read_sized(reader, action);
        break;
    default: // PUS_DEVICE_LOGICAL_ACQUIRE
        cursor->transaction = octet_read_u16(reader);
        action->device      = octet_read_u16(reader);
        action->address     = octet_read_u32(reader);
        break;
    }
    return true;
}

/// Detail of a failure: the device or register of the instruction.
static uint32_t name_of(const pus_device_action_t* const action)
{
    const bool is_register =
        (action->kind == PUS_DEVICE_LOAD_REGISTER) || (action->kind == PUS_DEVICE_DUMP_REGISTER);
    return is_register ? action->address : action->device;
}

/// Check an instruction. Returns the failure for which it is refused, or PUS_FAILURE_NONE.
static pus_failure_t check_instruction(const pus_device_access_t* const access,
                                       const pus_device_cursor_t* const cursor,
                                       const pus_device_action_t* const action)
{
    const pus_device_port_t* const port = &access->config.port;
    const bool is_malformed             = action->exponent > PULSE_EXPONENT;
    const status_t status = is_malformed ? STATUS_OUT_OF_RANGE : port->check(port->context, action);
    switch (status) {
    case STATUS_OK:
        return pus_no_failure();
    case STATUS_NOT_FOUND:
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, name_of(action));
    case STATUS_FORBIDDEN:
        return pus_failure(PUS_FAILURE_STATE, name_of(action));
    default:
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, cursor->offset);
    }
}

static void leave_out(pus_device_operation_t* const operation, const uint16_t number)
{
    const size_t bit              = (size_t)number - 1U;
    operation->left_out[bit / 8U] = (uint8_t)(operation->left_out[bit / 8U] | (1U << (bit % 8U)));
}

static bool is_left_out(const pus_device_operation_t* const operation, const uint16_t number)
{
    const size_t bit = (size_t)number - 1U;
    return ((operation->left_out[bit / 8U] >> (bit % 8U)) & 1U) != 0U;
}

// ---- Requests ----

static bool is_command(const uint8_t kind)
{
    return (kind == PUS_DEVICE_COMMAND) || (kind == PUS_DEVICE_LOGICAL_COMMAND);
}

/// Check all instructions and refuse the faulty ones. PUS_DONE: all were refused; PUS_LATER: some are to be
/// performed; PUS_REFUSED: the request is refused as a whole.
static pus_reply_t check_all(pus_device_access_t* const access, pus_request_t* const request,
                             pus_device_operation_t* const operation)
{
    const uint8_t kind         = request->token.subtype;
    pus_device_cursor_t cursor = cursor_of(&request->reader, kind);
    pus_device_action_t action;
    while (read_next(&cursor, &action)) {
        pus_reply_t reply = {PUS_REFUSED, check_instruction(access, &cursor, &action)};
        if (reply.failure.code == PUS_FAILURE_NONE) {
            continue;
        }
        access->counters.refused++;
        if (is_command(kind)) {
            reply.failure.instruction = cursor.number;
            return reply;
        }
        pus_request_refuse(request, cursor.number, reply.failure.code, reply.failure.detail);
        leave_out(operation, cursor.number);
        operation->refused++;
    }
    return (operation->refused < cursor.number) ? pus_later() : pus_done();
}

static pus_reply_t take(void* const self, pus_request_t* const request)
{
    pus_device_access_t* const access = self;
    pus_device_operation_t* operation = NULL;
    for (uint8_t i = 0U; (i < access->config.operation_count) && (operation == NULL); i++) {
        operation = (access->config.operations[i].phase == FREE) ? &access->config.operations[i] : NULL;
    }
    if (operation == NULL) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, access->config.operation_count);
    }
    // A request that was transferred in parts (ST[13]) can be longer than a packet.
    if (request->reader.size > sizeof operation->data) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, sizeof operation->data);
    }
    const size_t count = request->reader.octets[0];
    if ((request->token.subtype == PUS_DEVICE_DUMP_REGISTER) && (count > PUS_DEVICE_REGISTERS_MAX)) {
        return pus_refused(PUS_FAILURE_TABLE_FULL, PUS_DEVICE_REGISTERS_MAX);
    }
    operation->refused = 0U;
    operation->failure = pus_no_failure();
    operation->token   = request->token;
    operation->size    = request->reader.size;
    (void)memset(operation->left_out, 0, sizeof operation->left_out);
    (void)memcpy(operation->data, request->reader.octets, operation->size);
    const pus_reply_t reply = check_all(access, request, operation);
    if (reply.kind == PUS_LATER) {
        const octet_reader_t reader = octet_reader(operation->data, operation->size);
        operation->cursor           = cursor_of(&reader, request->token.subtype);
        operation->phase            = NEXT;
        access->running++;
    }
    return reply;
}

/// Report an acquisition. False: the process cannot take the report now.
static bool report_acquired(const pus_device_access_t* const access,
                            const pus_device_operation_t* const operation, const uint64_t now_ns)
{
    const uint8_t subtype = (operation->cursor.kind == PUS_DEVICE_ACQUIRE) ? PHYSICAL_DATA : LOGICAL_DATA;
    octet_writer_t writer = pus_tm_begin(access->config.process, PUS_SERVICE_DEVICE_ACCESS, subtype,
                                         operation->token.source, now_ns);
    octet_write_u16(&writer, operation->cursor.transaction);
    octet_write_u16(&writer, operation->result.return_code);
    if (subtype == PHYSICAL_DATA) {
        octet_write_u16(&writer, operation->result.size);
    }
    octet_write_octets(&writer, operation->result.data, operation->result.size);
    return pus_tm_send(access->config.process, &writer) == STATUS_OK;
}

/// Report registers. False: the process cannot take the report now.
static bool report_registers(const pus_device_access_t* const access,
                             const pus_device_operation_t* const operation, const uint64_t now_ns)
{
    const octet_reader_t reader = octet_reader(operation->data, operation->size);
    pus_device_cursor_t cursor  = cursor_of(&reader, PUS_DEVICE_DUMP_REGISTER);
    octet_writer_t writer       = pus_tm_begin(access->config.process, PUS_SERVICE_DEVICE_ACCESS, REGISTERS,
                                               operation->token.source, now_ns);
    uint8_t* const count        = octet_write_space(&writer, sizeof(uint16_t));
    uint16_t entries            = 0U;
    pus_device_action_t action;
    while (read_next(&cursor, &action)) {
        if (!is_left_out(operation, cursor.number)) {
            octet_write_u32(&writer, action.address);
            octet_write_u32(&writer, operation->values[cursor.number - 1U]);
            entries++;
        }
    }
    octets_put_u16(count, entries);
    return pus_tm_send(access->config.process, &writer) == STATUS_OK;
}

/// End an instruction. An acquisition is reported, even if it failed.
static void end_instruction(pus_device_access_t* const access, pus_device_operation_t* const operation,
                            const status_t status, const uint64_t now_ns)
{
    const uint8_t kind    = operation->cursor.kind;
    const uint16_t number = operation->cursor.number;
    const bool is_read    = (kind == PUS_DEVICE_ACQUIRE) || (kind == PUS_DEVICE_LOGICAL_ACQUIRE);
    operation->phase      = is_read ? REPORTING : NEXT;
    if (status == STATUS_OK) {
        access->counters.performed++;
        operation->result.return_code = 0U;
        if (kind == PUS_DEVICE_DUMP_REGISTER) {
            operation->values[number - 1U] = octets_u32_at(operation->result.data);
        }
        return;
    }
    const bool is_late = (status == STATUS_TIMEOUT);
    access->counters.failed++;
    access->counters.timed_out += is_late ? 1U : 0U;
    leave_out(operation, number);
    operation->result.size = 0U;
    pus_failure_t failure  = is_late ? pus_failure(PUS_FAILURE_NO_ANSWER, name_of(&operation->action))
                                     : pus_failure(PUS_FAILURE_DEVICE, operation->result.detail);
    failure.instruction    = number;
    pus_verify_progress_failed(access->config.process, &operation->token, number, &failure, now_ns);
    if (operation->failure.code == PUS_FAILURE_NONE) {
        operation->failure = failure;
    }
    if (is_command(kind)) {
        operation->cursor.left = 0U; // Later commands may depend on the failed one.
    }
}

static uint8_t slot_of(const pus_device_access_t* const access, const pus_device_operation_t* const operation)
{
    return (uint8_t)(operation - access->config.operations);
}

/// Take the next instruction that was not refused.
static void take_next(pus_device_access_t* const access, pus_device_operation_t* const operation,
                      const uint64_t now_ns)
{
    bool has_next = read_next(&operation->cursor, &operation->action);
    while (has_next && is_left_out(operation, operation->cursor.number)) {
        has_next = read_next(&operation->cursor, &operation->action);
    }
    operation->phase       = has_next ? BEGINNING : ENDING;
    operation->deadline_ns = now_ns + access->config.timeout_ns;
}

/// Begin or poll the present instruction. False: it has to wait for the port.
static bool begin_or_poll(pus_device_access_t* const access, pus_device_operation_t* const operation,
                          const uint64_t now_ns)
{
    const pus_device_port_t* const port = &access->config.port;
    const uint8_t slot                  = slot_of(access, operation);
    const bool is_begun                 = (operation->phase == GOING_ON);
    const status_t status               = is_begun
                                              ? port->poll(port->context, slot, &operation->result)
                                              : port->begin(port->context, slot, &operation->action, &operation->result);
    const bool waits                    = (status == (is_begun ? STATUS_BUSY : STATUS_FULL));
    if (!waits && !is_begun && (status == STATUS_OK)) {
        operation->phase = GOING_ON;
        return true;
    }
    if (!waits) {
        end_instruction(access, operation, status, now_ns);
        return true;
    }
    if (now_ns < operation->deadline_ns) {
        return false;
    }
    if (is_begun) {
        port->abandon(port->context, slot);
    }
    operation->result.return_code = PUS_DEVICE_TIMED_OUT;
    end_instruction(access, operation, STATUS_TIMEOUT, now_ns);
    return true;
}

/// End a request. False: the process cannot take its report now.
static bool end(pus_device_access_t* const access, pus_device_operation_t* const operation,
                const uint64_t now_ns)
{
    pus_failure_t failure = operation->failure;
    if ((operation->cursor.kind == PUS_DEVICE_DUMP_REGISTER) &&
        !report_registers(access, operation, now_ns)) {
        return false;
    }
    if ((failure.code == PUS_FAILURE_NONE) && (operation->refused > 0U)) {
        failure = pus_failure(PUS_FAILURE_SOME_FAILED, operation->refused);
    }
    operation->phase = FREE;
    access->running--;
    pus_verify_ended(access->config.process, &operation->token, failure, now_ns);
    return false;
}

/// Advance a request by one phase. False: the request has to wait, or has ended.
static bool advance(pus_device_access_t* const access, pus_device_operation_t* const operation,
                    const uint64_t now_ns)
{
    switch (operation->phase) {
    case NEXT:
        take_next(access, operation, now_ns);
        return true;
    case BEGINNING:
    case GOING_ON:
        return begin_or_poll(access, operation, now_ns);
    case REPORTING:
        if (!report_acquired(access, operation, now_ns)) {
            return false;
        }
        operation->phase = NEXT;
        return true;
    default: // ENDING
        return end(access, operation, now_ns);
    }
}

void pus_device_access_step(pus_device_access_t* const access, const uint64_t now_ns)
{
    FSW_ASSERT(access != NULL);
    uint8_t left = access->running;
    for (pus_device_operation_t* operation = access->config.operations; left > 0U; operation++) {
        if (operation->phase != FREE) {
            left--;
            for (unsigned i = 0U; (i < TRANSITIONS_MAX) && advance(access, operation, now_ns); i++) {
            }
        }
    }
}

static void step(void* const self, const uint64_t now_ns, const uint32_t cycle)
{
    (void)cycle;
    pus_device_access_step(self, now_ns);
}

pus_service_t pus_device_access_service(pus_device_access_t* const access)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(2, 1, take), PUS_REQUEST(2, 2, take), PUS_REQUEST(2, 4, take),  PUS_REQUEST(2, 5, take),
        PUS_REQUEST(2, 7, take), PUS_REQUEST(2, 8, take), PUS_REQUEST(2, 10, take), PUS_REQUEST(2, 11, take),
    };
    pus_service_t service =
        pus_service_of(PUS_SERVICE_DEVICE_ACCESS, subtypes, sizeof subtypes / sizeof subtypes[0], access);
    service.step = step;
    return service;
}
