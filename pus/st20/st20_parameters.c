// SPDX-License-Identifier: Apache-2.0
#include "pus/st20/st20_parameters.h"

#include "base/assertion.h"
#include "base/value.h"
#include "generated/pus/st20_request_formats.h"

enum {
    VALUES      = 2,
    SET         = 3,
    DEFINITIONS = 7
};

#define ID_SIZE 4U // Size of a parameter id before its value [octets].
#define LAYOUT_SHIFT 16U
#define LAYOUT_MASK 0x1FU
#define PTC_OCTETS 7U

void pus_parameters_init(pus_parameters_t* const parameters, const pus_parameter_port_t* const port)
{
    FSW_ASSERT((parameters != NULL) && (port != NULL) && (port->find != NULL) && (port->read != NULL));
    *parameters = (pus_parameters_t){.definer = {.port = *port}};
}

static void refuse(pus_parameters_t* const parameters, pus_request_t* const request,
                   const uint16_t instruction, const uint16_t code, const uint32_t detail)
{
    parameters->counters.refused++;
    pus_request_refuse(request, instruction, code, detail);
}

static uint16_t code_of_find(const status_t status)
{
    return (status == STATUS_FORBIDDEN) ? PUS_FAILURE_ACCESS : PUS_FAILURE_UNKNOWN_ID;
}

/// Accept or refuse the instruction for one id of a request for values.
static void decide(pus_parameters_t* const parameters, pus_request_t* const request,
                   const uint16_t instruction, const uint32_t id, const status_t status, const bool is_good)
{
    if (is_good) {
        pus_request_perform(request);
    } else if (status == STATUS_OK) {
        refuse(parameters, request, instruction, PUS_FAILURE_TABLE_FULL,
               (uint32_t)pus_tm_data_max(request->process));
    } else {
        refuse(parameters, request, instruction, code_of_find(status), id);
    }
}

/// Read the ids of a request. Without a writer: refuse each id that cannot be reported or does not fit, and
/// accept the others. With a writer: write {id, value} for each accepted id. Returns the size of the source
/// data of the accepted ids [octets].
static size_t report_or_write_values(pus_parameters_t* const parameters, pus_request_t* const request,
                                     octet_writer_t* const writer)
{
    const pus_parameter_port_t* const port = &parameters->definer.port;
    const uint8_t count                    = octet_read_u8(&request->reader);
    const size_t most                      = pus_tm_data_max(request->process);
    size_t room                            = most - sizeof(uint16_t);
    for (uint16_t i = 1U; i <= count; i++) {
        const uint32_t id     = octet_read_u32(&request->reader);
        uint16_t handle       = 0U;
        uint16_t size         = 0U;
        const status_t status = port->find(port->context, id, &handle, &size);
        const size_t needed   = ID_SIZE + (size_t)size;
        const bool is_good    = (status == STATUS_OK) && (needed <= room);
        room -= is_good ? needed : 0U;
        if (writer == NULL) {
            decide(parameters, request, i, id, status, is_good);
        } else if (is_good) {
            octet_write_u32(writer, id);
            const size_t end = writer->position + size;
            port->read(port->context, handle, writer);
            FSW_ASSERT(writer->position == end); // The port must write exactly the size that it has reported.
            parameters->counters.read++;
        } else {
            // The pass without a writer has refused this id.
        }
    }
    return most - room;
}

static pus_reply_t report_values(void* const self, pus_request_t* const request)
{
    pus_parameters_t* const parameters = self;
    const octet_reader_t list          = request->reader;
    const size_t size                  = report_or_write_values(parameters, request, NULL);
    if (request->performed > 0U) {
        octet_writer_t writer;
        if (pus_tm_begin_sized(request->process, request->token.service, VALUES, request->token.source,
                               request->now_ns, size, &writer) != STATUS_OK) {
            return pus_failed(PUS_FAILURE_IO, (uint32_t)STATUS_FULL);
        }
        octet_write_u16(&writer, request->performed);
        request->reader = list;
        (void)report_or_write_values(parameters, request, &writer);
        (void)pus_tm_post_sized(request->process, &writer); // The process counts lost reports.
    }
    return pus_done();
}

/// Returns the size of the value that follows an id: the size of the parameter. If the parameter is unknown:
/// the size of the type in the layout bits of the id; 0 if this is not a scalar type.
static uint16_t size_of_value(const pus_parameters_t* const parameters, const uint32_t id,
                              uint16_t* const out_handle, status_t* const out_status)
{
    uint16_t size   = 0U;
    *out_status     = parameters->definer.port.find(parameters->definer.port.context, id, out_handle, &size);
    const bool good = (*out_status == STATUS_OK) && (size > 0U);
    if (!good) {
        const uint32_t layout = (id >> LAYOUT_SHIFT) & LAYOUT_MASK;
        size                  = (layout < VALUE_SCALARS) ? (uint16_t)value_size((value_type_t)layout) : 0U;
    }
    return size;
}

static bool format_set(void* const self, octet_reader_t* const reader)
{
    const pus_parameters_t* const parameters = self;
    const uint8_t count                      = octet_read_u8(reader);
    for (uint8_t i = 0U; (i < count) && !reader->failed; i++) {
        uint16_t handle     = 0U;
        status_t status     = STATUS_OK;
        const uint32_t id   = octet_read_u32(reader);
        const uint16_t size = size_of_value(parameters, id, &handle, &status);
        const bool is_open  = !reader->failed && (size == 0U);
        // The end of a value of unknown size cannot be found, so the next values cannot be read: `execute`
        // refuses the rest.
        (void)octet_read_octets(reader, is_open ? octet_reader_left(reader) : size);
        if (is_open) {
            return true;
        }
    }
    return count > 0U;
}

static void refuse_write(pus_parameters_t* const parameters, pus_request_t* const request,
                         const uint16_t instruction, const uint32_t id, const status_t status,
                         const size_t offset)
{
    switch (status) {
    case STATUS_READ_ONLY:
        refuse(parameters, request, instruction, PUS_FAILURE_ACCESS, id);
        break;
    case STATUS_FORBIDDEN:
    case STATUS_BUSY:
        refuse(parameters, request, instruction, PUS_FAILURE_STATE, id);
        break;
    default:
        refuse(parameters, request, instruction, PUS_FAILURE_OUT_OF_RANGE, (uint32_t)offset);
        break;
    }
}

static void set_one(pus_parameters_t* const parameters, pus_request_t* const request,
                    const uint16_t instruction, const uint32_t id, const uint16_t handle,
                    const uint8_t* const value, const uint16_t size)
{
    const pus_parameter_port_t* const port = &parameters->definer.port;
    const status_t status =
        (port->write != NULL) ? port->write(port->context, handle, value, size) : STATUS_READ_ONLY;
    if (status == STATUS_OK) {
        parameters->counters.set++;
        pus_request_perform(request);
    } else {
        refuse_write(parameters, request, instruction, id, status, request->reader.position - size);
    }
}

static pus_reply_t set_values(void* const self, pus_request_t* const request)
{
    pus_parameters_t* const parameters = self;
    const uint8_t count                = octet_read_u8(&request->reader);
    bool is_open                       = false; // The end of the value of an instruction could not be found.
    for (uint16_t i = 1U; i <= count; i++) {
        uint16_t handle            = 0U;
        status_t status            = STATUS_NOT_FOUND;
        const uint32_t id          = is_open ? 0U : octet_read_u32(&request->reader);
        const uint16_t size        = is_open ? 0U : size_of_value(parameters, id, &handle, &status);
        is_open                    = is_open || (size == 0U);
        const uint8_t* const value = octet_read_octets(&request->reader, size);
        if (status != STATUS_OK) {
            refuse(parameters, request, i, code_of_find(status), id);
        } else {
            FSW_ASSERT(value != NULL); // format_set has checked the format.
            set_one(parameters, request, i, id, handle, value, size);
        }
    }
    return pus_done();
}

void pus_parameters_define(pus_parameters_t* const parameters, const pus_parameter_definer_t* const definer)
{
    FSW_ASSERT((parameters != NULL) && (definer != NULL) && (definer->define != NULL));
    parameters->definer = *definer;
}

status_t pus_parameters_restore(pus_parameters_t* const parameters, const uint32_t key,
                                const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((parameters != NULL) && (octets != NULL));
    const pus_parameter_definer_t* const definer = &parameters->definer;
    return (definer->restore != NULL) ? definer->restore(definer->port.context, key, octets, size)
                                      : STATUS_UNSUPPORTED;
}

pus_parameter_code_t pus_parameter_code_of(const uint32_t id)
{
    static const pus_parameter_code_t codes[VALUE_SCALARS] = {
        [VALUE_UINT8] = {3U, 4U},   [VALUE_UINT16] = {3U, 12U}, [VALUE_UINT32] = {3U, 14U},
        [VALUE_UINT64] = {3U, 16U}, [VALUE_INT8] = {4U, 4U},    [VALUE_INT16] = {4U, 12U},
        [VALUE_INT32] = {4U, 14U},  [VALUE_INT64] = {4U, 16U},  [VALUE_FLOAT] = {5U, 1U},
        [VALUE_DOUBLE] = {5U, 2U},  [VALUE_BOOL] = {1U, 0U},
    };
    const uint32_t layout = (id >> LAYOUT_SHIFT) & LAYOUT_MASK;
    return (layout < (uint32_t)VALUE_SCALARS) ? codes[layout] : (pus_parameter_code_t){.ptc = PTC_OCTETS};
}

static pus_reply_t define(pus_parameters_t* const parameters, pus_request_t* const request,
                          const bool is_object)
{
    const pus_parameter_definer_t* const definer = &parameters->definer;
    const uint8_t count                          = octet_read_u8(&request->reader);
    if (definer->define == NULL) {
        return pus_refused(PUS_FAILURE_ACCESS, octet_read_u32(&request->reader));
    }
    for (uint16_t i = 1U; i <= count; i++) {
        const pus_failure_t failure = definer->define(definer->port.context, &request->reader, is_object);
        if (failure.code == PUS_FAILURE_NONE) {
            pus_request_perform(request);
        } else {
            refuse(parameters, request, i, failure.code, failure.detail);
        }
    }
    return pus_done();
}

static pus_reply_t define_raw(void* const self, pus_request_t* const request)
{
    return define(self, request, false);
}

static pus_reply_t define_object(void* const self, pus_request_t* const request)
{
    return define(self, request, true);
}

static pus_reply_t report_definitions(void* const self, pus_request_t* const request)
{
    pus_parameters_t* const parameters     = self;
    const pus_parameter_port_t* const port = &parameters->definer.port;
    const uint8_t count                    = octet_read_u8(&request->reader);
    octet_reader_t list                    = request->reader;
    uint16_t handle                        = 0U;
    uint16_t size                          = 0U;
    for (uint16_t i = 1U; i <= count; i++) {
        const uint32_t id     = octet_read_u32(&request->reader);
        const status_t status = port->find(port->context, id, &handle, &size);
        if (status == STATUS_OK) {
            pus_request_perform(request);
        } else {
            refuse(parameters, request, i, code_of_find(status), id);
        }
    }
    if (request->performed == 0U) {
        return pus_done();
    }
    octet_writer_t writer = pus_list_begin(request, DEFINITIONS);
    for (uint16_t i = 0U; i < count; i++) {
        const uint32_t id = octet_read_u32(&list);
        if (port->find(port->context, id, &handle, &size) == STATUS_OK) {
            const pus_parameter_code_t code = pus_parameter_code_of(id);
            // These zeros are reported for a parameter of the dictionary, which has no memory address.
            uint8_t memory_id = 0U;
            uint32_t address  = 0U;
            if (parameters->definer.locate != NULL) {
                parameters->definer.locate(port->context, id, &memory_id, &address);
            }
            octet_write_u32(&writer, id);
            octet_write_u8(&writer, memory_id);
            octet_write_u32(&writer, address);
            octet_write_u8(&writer, code.ptc);
            octet_write_u16(&writer, code.pfc);
        }
    }
    return pus_list_end(request, &writer, request->performed);
}

pus_service_t pus_parameters_service(pus_parameters_t* const parameters)
{
    static const pus_subtype_t subtypes[] = {
        PUS_REQUEST(20, 1, report_values),      {SET, format_set, set_values, NULL},
        PUS_REQUEST(20, 4, define_raw),         PUS_REQUEST(20, 5, define_object),
        PUS_REQUEST(20, 6, report_definitions),
    };
    return pus_service_of(PUS_SERVICE_PARAMETERS, subtypes, sizeof subtypes / sizeof subtypes[0], parameters);
}
