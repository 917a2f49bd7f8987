// SPDX-License-Identifier: Apache-2.0
#include "base/crc.h"
#include "pus/st06/st06_operations.h"

#include <string.h>

pus_failure_t memory_fail(pus_memory_service_t* const service, const uint16_t code, const uint32_t detail)
{
    service->counters.refused++;
    return pus_failure(code, detail);
}

pus_failure_t memory_find(const pus_memory_t* const memories, const uint8_t count,
                          octet_reader_t* const reader, const bool is_object,
                          memory_target_t* const out_target)
{
    const uint8_t id = octet_read_u8(reader);
    uint8_t index    = 0U;
    while ((index < count) && (memories[index].id != id)) {
        index++;
    }
    if (index >= count) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, id);
    }
    const pus_memory_t* const memory = &memories[index];
    *out_target                      = (memory_target_t){.memory    = memory,
                                                         .index     = index,
                                                         .is_object = is_object,
                                                         .first     = memory->base,
                                                         .size      = memory->size};
    if (is_object) {
        out_target->first   = 0U;
        out_target->base_id = octet_read_u32(reader);
        if ((memory->object == NULL) ||
            (memory->object(memory->context, out_target->base_id, &out_target->origin, &out_target->size) !=
             STATUS_OK)) {
            return pus_failure(PUS_FAILURE_UNKNOWN_ID, out_target->base_id);
        }
    }
    return pus_no_failure();
}

pus_failure_t memory_target(const pus_memory_service_t* const service, octet_reader_t* const reader,
                            const bool is_object, memory_target_t* const out_target)
{
    return memory_find(service->config.memories, service->config.memory_count, reader, is_object, out_target);
}

bool memory_is_inside(const memory_target_t* const target, const uint32_t address, const uint32_t length)
{
    const uint8_t access = target->memory->access;
    // If the address is lower, the difference wraps to a large number.
    const uint32_t offset = address - target->first;
    const bool is_inside =
        (address >= target->first) && (offset <= target->size) && (length <= (target->size - offset));
    return is_inside && (((target->origin + address) % access) == 0U) && ((length % access) == 0U);
}

pus_failure_t memory_check_access(const pus_memory_service_t* const service,
                                  const memory_target_t* const target, const uint32_t address,
                                  const uint32_t length, const bool is_write, const size_t position)
{
    const pus_memory_t* const memory = target->memory;
    if (length == 0U) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, (uint32_t)position);
    }
    if (!memory_is_inside(target, address, length)) {
        return pus_failure(PUS_FAILURE_ADDRESS, address);
    }
    if (is_write && ((memory->write == NULL) || service->config.states[target->index].is_protected)) {
        return pus_failure(PUS_FAILURE_PROTECTED, memory->id);
    }
    return pus_no_failure();
}

pus_failure_t memory_verify(pus_memory_service_t* const service, const pus_memory_t* const memory,
                            const uint32_t address, const uint8_t* const expected, const size_t size)
{
    bool is_same  = true;
    uint16_t crc  = CRC16_START;
    uint32_t next = address;
    size_t done   = 0U;
    while (done < size) {
        const size_t rest     = size - done;
        const size_t piece    = (rest < sizeof service->echo) ? rest : sizeof service->echo;
        const status_t status = memory->read(memory->context, next, service->echo, piece);
        if (status != STATUS_OK) {
            return memory_fail(service, PUS_FAILURE_IO, (uint32_t)status);
        }
        crc     = crc16_ccitt_more(crc, service->echo, piece);
        is_same = is_same && (memcmp(service->echo, &expected[done], piece) == 0);
        done += piece;
        next += (uint32_t)piece;
    }
    return is_same ? pus_no_failure() : memory_fail(service, PUS_FAILURE_VERIFY, crc);
}
