// SPDX-License-Identifier: Apache-2.0
#include "base/assertion.h"
#include "base/crc.h"
#include "pus/st18/st18_internal.h"

#include <string.h>

#define PART_HEAD 12U // Octets before the code in a record: id (8), size (2), checksum (2).
#define PART_DATA (PUS_RECORD_MAX - PART_HEAD)
#define KEYS_EACH 4U      // Keys that are reserved for one procedure; its code has at most 3 parts.
#define ENGINE_KEY 65535U // Key of the record of the engine: running or stopped.

uint32_t procedures_detail(const uint8_t* const id)
{
    return octets_u32_at(id);
}

pus_procedure_t* procedures_find(const pus_procedures_t* const self, const uint8_t* const id)
{
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        pus_procedure_t* const procedure = &self->config.procedures[i];
        if (procedure->in_use && (memcmp(procedure->id, id, PUS_NAME_SIZE) == 0)) {
            return procedure;
        }
    }
    return NULL;
}

/// Returns a free entry, or null if all are in use.
static pus_procedure_t* find_free(const pus_procedures_t* const self)
{
    for (uint16_t i = 0U; i < self->config.capacity; i++) {
        if (!self->config.procedures[i].in_use) {
            return &self->config.procedures[i];
        }
    }
    return NULL;
}

// ---- Records ----

static uint32_t key_of(const pus_procedures_t* const self, const pus_procedure_t* const procedure,
                       const uint32_t part)
{
    return ((uint32_t)(procedure - self->config.procedures) * KEYS_EACH) + part;
}

static uint32_t parts_of(const uint16_t size)
{
    return ((uint32_t)size + (PART_DATA - 1U)) / PART_DATA;
}

static size_t octets_of(const uint16_t size, const uint32_t part)
{
    const size_t left = (size_t)size - ((size_t)part * PART_DATA);
    return (left < PART_DATA) ? left : PART_DATA;
}

static pus_failure_t outcome(pus_procedures_t* const self, const status_t status)
{
    const bool is_good = status == STATUS_OK;
    self->counters.unsaved += is_good ? 0U : 1U;
    return pus_failure(is_good ? PUS_FAILURE_NONE : PUS_FAILURE_IO, (uint32_t)status);
}

static status_t put_part(const pus_procedures_t* const self, const pus_procedure_t* const procedure,
                         const uint32_t part)
{
    uint8_t octets[PUS_RECORD_MAX];
    octet_writer_t writer                = octet_writer(octets, sizeof octets);
    const pus_persistence_t* const store = self->config.persistence;
    octet_write_octets(&writer, procedure->id, PUS_NAME_SIZE);
    octet_write_u16(&writer, procedure->size);
    octet_write_u16(&writer, procedure->checksum);
    octet_write_octets(&writer, &procedure->code[(size_t)part * PART_DATA], octets_of(procedure->size, part));
    return store->put(store->context, PUS_SERVICE_PROCEDURES, key_of(self, procedure, part), octets,
                      writer.position);
}

/// Erase the first `parts` records of a procedure.
static status_t erase_parts(const pus_procedures_t* const self, const pus_procedure_t* const procedure,
                            const uint32_t parts)
{
    const pus_persistence_t* const store = self->config.persistence;
    status_t result                      = STATUS_OK;
    for (uint32_t part = 0U; part < parts; part++) {
        const status_t status =
            store->erase(store->context, PUS_SERVICE_PROCEDURES, key_of(self, procedure, part));
        result = ((status == STATUS_OK) || (status == STATUS_NOT_FOUND)) ? result : status;
    }
    return result;
}

/// Store all parts. If one cannot be stored, erase them all.
static pus_failure_t save(pus_procedures_t* const self, const pus_procedure_t* const procedure)
{
    if (self->config.persistence == NULL) {
        return pus_no_failure();
    }
    uint32_t part   = 0U;
    status_t status = STATUS_OK;
    while ((part < parts_of(procedure->size)) && (status == STATUS_OK)) {
        status = put_part(self, procedure, part);
        part++;
    }
    if (status != STATUS_OK) {
        (void)erase_parts(self, procedure, part);
    }
    return outcome(self, status);
}

pus_failure_t procedures_save_engine(pus_procedures_t* const self, const bool is_stopped)
{
    const pus_persistence_t* const store = self->config.persistence;
    const uint8_t octet                  = (uint8_t)(is_stopped ? 1U : 0U);
    return outcome(self, (store == NULL)
                             ? STATUS_OK
                             : store->put(store->context, PUS_SERVICE_PROCEDURES, ENGINE_KEY, &octet, 1U));
}

static status_t restore_part(pus_procedures_t* const self, const uint32_t key, octet_reader_t* const reader)
{
    const uint32_t part     = key % KEYS_EACH;
    const uint8_t* const id = octet_read_octets(reader, PUS_NAME_SIZE);
    const uint16_t size     = octet_read_u16(reader);
    const uint16_t checksum = octet_read_u16(reader);
    const size_t left       = octet_reader_left(reader);
    if ((key / KEYS_EACH) >= self->config.capacity) {
        return STATUS_EXHAUSTED;
    }
    if (reader->failed || (size > PUS_PROCEDURE_CODE_MAX) || (part >= parts_of(size)) ||
        (left != octets_of(size, part))) {
        return STATUS_INVALID;
    }
    pus_procedure_t* const procedure = &self->config.procedures[key / KEYS_EACH];
    const bool belongs               = (procedure->size == size) && (procedure->checksum == checksum) &&
                         (memcmp(procedure->id, id, PUS_NAME_SIZE) == 0);
    procedure->parts    = belongs ? procedure->parts : 0U;
    procedure->in_use   = false;
    procedure->size     = size;
    procedure->checksum = checksum;
    (void)memcpy(procedure->id, id, PUS_NAME_SIZE);
    (void)memcpy(&procedure->code[(size_t)part * PART_DATA], octet_read_octets(reader, left), left);
    procedure->parts = (uint8_t)(procedure->parts | (1U << part));
    if (procedure->parts != ((1U << parts_of(size)) - 1U)) {
        return STATUS_OK;
    }
    procedure->in_use = crc16_ccitt(procedure->code, size) == checksum;
    return procedure->in_use ? STATUS_OK : STATUS_INVALID;
}

status_t pus_procedures_restore(pus_procedures_t* const self, const uint32_t key, const uint8_t* const octets,
                                const size_t size)
{
    FSW_ASSERT((self != NULL) && ((octets != NULL) || (size == 0U)));
    octet_reader_t reader = octet_reader(octets, size);
    if (key != ENGINE_KEY) {
        return restore_part(self, key, &reader);
    }
    const bool is_stopped = octet_read_u8(&reader) != 0U;
    if (!octet_reader_is_done(&reader)) {
        return STATUS_INVALID;
    }
    self->is_stopped = is_stopped;
    return STATUS_OK;
}

// ---- Loading ----

/// Find an entry for new code of this size. PUS_FAILURE_NONE, or the failure.
static pus_failure_t prepare(const pus_procedures_t* const self, const uint8_t* const id, const size_t size,
                             pus_procedure_t** const out_entry)
{
    if (self->is_stopped) {
        return pus_failure(PUS_FAILURE_STATE, procedures_detail(id));
    }
    if (procedures_find(self, id) != NULL) {
        return pus_failure(PUS_FAILURE_EXISTS, procedures_detail(id));
    }
    if ((size == 0U) || (size > PUS_PROCEDURE_CODE_MAX)) {
        return pus_failure(PUS_FAILURE_TABLE_FULL, PUS_PROCEDURE_CODE_MAX);
    }
    *out_entry = find_free(self);
    return pus_failure((*out_entry != NULL) ? PUS_FAILURE_NONE : PUS_FAILURE_TABLE_FULL,
                       self->config.capacity);
}

/// Complete the loading of a procedure, whose code is already in `entry`.
static pus_failure_t complete_loading(pus_procedures_t* const self, pus_procedure_t* const entry,
                                      const uint8_t* const id, const size_t size)
{
    (void)memcpy(entry->id, id, PUS_NAME_SIZE);
    entry->size     = (uint16_t)size;
    entry->checksum = crc16_ccitt(entry->code, size);
    entry->level    = PUS_OBSERVE_NOTHING;
    entry->slot     = PUS_PROCEDURE_NONE;

    const pus_failure_t failure = save(self, entry);
    entry->in_use               = failure.code == PUS_FAILURE_NONE;
    return failure;
}

pus_failure_t procedures_load(pus_procedures_t* const self, const uint8_t* const id,
                              octet_reader_t* const code)
{
    const uint16_t size         = octet_read_u16(code);
    const uint8_t* const octets = octet_read_octets(code, size);
    const uint16_t checksum     = octet_read_u16(code);
    pus_procedure_t* entry      = NULL;
    const pus_failure_t failure = prepare(self, id, size, &entry);
    if (failure.code != PUS_FAILURE_NONE) {
        return failure;
    }
    FSW_ASSERT((entry != NULL) && (octets != NULL)); // The dispatcher has checked the format.
    if (crc16_ccitt(octets, size) != checksum) {
        return pus_failure(PUS_FAILURE_DATA_CHECKSUM, crc16_ccitt(octets, size));
    }
    (void)memcpy(entry->code, octets, size);
    return complete_loading(self, entry, id, size);
}

static pus_failure_t failure_of_file(const status_t status)
{
    switch (status) {
    case STATUS_OK:
        return pus_no_failure();
    case STATUS_NOT_FOUND:
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, 0U);
    case STATUS_INVALID:
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, PUS_NAME_SIZE);
    default:
        return pus_failure(PUS_FAILURE_IO, (uint32_t)status);
    }
}

pus_failure_t procedures_load_file(pus_procedures_t* const self, const uint8_t* const id,
                                   const pus_file_name_t* const name)
{
    const pus_file_port_t* const files = self->config.files;
    uint32_t file                      = 0U;
    uint32_t size                      = 0U;
    pus_procedure_t* entry             = NULL;
    if (files == NULL) {
        return pus_failure(PUS_FAILURE_ACCESS, 0U);
    }
    pus_failure_t failure = failure_of_file(files->open(files->context, name, &file, &size));
    if (failure.code != PUS_FAILURE_NONE) {
        return failure;
    }
    failure = prepare(self, id, size, &entry);
    if (failure.code == PUS_FAILURE_NONE) {
        FSW_ASSERT(entry != NULL); // `prepare` has returned no failure, so it has found an entry.
        failure = failure_of_file(files->read(files->context, file, 0U, entry->code, size));
    }
    (void)files->close(files->context, file); // No data was written, so the status does not matter.
    return (failure.code == PUS_FAILURE_NONE) ? complete_loading(self, entry, id, size) : failure;
}

pus_failure_t procedures_unload(pus_procedures_t* const self, pus_procedure_t* const procedure)
{
    pus_failure_t failure = pus_no_failure();
    if (self->config.persistence != NULL) {
        failure = outcome(self, erase_parts(self, procedure, parts_of(procedure->size)));
    }
    if (failure.code == PUS_FAILURE_NONE) {
        procedure->in_use = false;
        procedure->parts  = 0U;
    }
    return failure;
}
