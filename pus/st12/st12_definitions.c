// SPDX-License-Identifier: Apache-2.0
#include "pus/st12/st12_internal.h"

bool monitoring_read_validity(octet_reader_t* const reader, pus_validity_t* const out_validity)
{
    out_validity->scalar.id   = octet_read_u32(reader);
    out_validity->scalar.type = pus_scalar_type(out_validity->scalar.id);
    if (out_validity->scalar.type == VALUE_SCALARS) {
        return false;
    }
    out_validity->mask     = pus_scalar_read(reader, out_validity->scalar.type);
    out_validity->expected = pus_scalar_read(reader, out_validity->scalar.type);
    return true;
}

void monitoring_write_validity(octet_writer_t* const writer, const pus_validity_t* const validity)
{
    octet_write_u32(writer, validity->scalar.id);
    pus_scalar_write(writer, validity->scalar.type, validity->mask);
    pus_scalar_write(writer, validity->scalar.type, validity->expected);
}

static bool read_criteria(octet_reader_t* const reader, pus_pmon_t* const pmon)
{
    const value_type_t type = pmon->scalar.type;
    pmon->low               = pus_scalar_read(reader, type);
    switch (pmon->check_type) {
    case PUS_CHECK_EXPECTED:
        pmon->high      = pus_scalar_read(reader, type);
        pmon->low_event = octet_read_u16(reader);
        return true;
    case PUS_CHECK_LIMIT:
    case PUS_CHECK_DELTA:
        pmon->low_event  = octet_read_u16(reader);
        pmon->high       = pus_scalar_read(reader, type);
        pmon->high_event = octet_read_u16(reader);
        pmon->deltas     = (pmon->check_type == (uint8_t)PUS_CHECK_DELTA) ? octet_read_u16(reader) : 1U;
        return true;
    default:
        return false;
    }
}

bool monitoring_read_pmon(octet_reader_t* const reader, const monitoring_origin_t origin,
                          pus_pmon_t* const out_pmon)
{
    *out_pmon = (pus_pmon_t){
        .status = PUS_CHECK_UNCHECKED, .verdict = PUS_CHECK_UNCHECKED, .interval = 1U, .deltas = 1U};
    out_pmon->id          = octet_read_u16(reader);
    out_pmon->scalar.id   = octet_read_u32(reader);
    out_pmon->scalar.type = pus_scalar_type(out_pmon->scalar.id);
    if (out_pmon->scalar.type == VALUE_SCALARS) {
        return false;
    }
    if (origin != MONITORING_FROM_MODIFY) {
        if (!monitoring_read_validity(reader, &out_pmon->validity)) {
            return false;
        }
        out_pmon->interval = octet_read_u32(reader);
    }
    if (origin == MONITORING_FROM_RECORD) {
        out_pmon->is_enabled = octet_read_u8(reader) != 0U;
    }
    out_pmon->repetition = octet_read_u16(reader);
    out_pmon->check_type = octet_read_u8(reader);
    return read_criteria(reader, out_pmon);
}

void monitoring_write_pmon(octet_writer_t* const writer, const pus_pmon_t* const pmon)
{
    const value_type_t type = pmon->scalar.type;
    octet_write_u16(writer, pmon->id);
    octet_write_u32(writer, pmon->scalar.id);
    monitoring_write_validity(writer, &pmon->validity);
    octet_write_u32(writer, pmon->interval);
    octet_write_u8(writer, pmon->is_enabled ? 1U : 0U);
    octet_write_u16(writer, pmon->repetition);
    octet_write_u8(writer, pmon->check_type);
    pus_scalar_write(writer, type, pmon->low);
    if (pmon->check_type == (uint8_t)PUS_CHECK_EXPECTED) {
        pus_scalar_write(writer, type, pmon->high);
        octet_write_u16(writer, pmon->low_event);
        return;
    }
    octet_write_u16(writer, pmon->low_event);
    pus_scalar_write(writer, type, pmon->high);
    octet_write_u16(writer, pmon->high_event);
    if (pmon->check_type == (uint8_t)PUS_CHECK_DELTA) {
        octet_write_u16(writer, pmon->deltas);
    }
}

void monitoring_write_transition(octet_writer_t* const writer, const pus_check_transition_t* const transition)
{
    const value_type_t type = pus_scalar_type(transition->parameter_id);
    octet_write_u16(writer, transition->pmon_id);
    octet_write_u32(writer, transition->parameter_id);
    octet_write_u8(writer, transition->check_type);
    if (transition->check_type == (uint8_t)PUS_CHECK_EXPECTED) {
        pus_scalar_write(writer, type, transition->mask);
    }
    pus_scalar_write(writer, type, transition->value);
    pus_scalar_write(writer, type, transition->limit);
    octet_write_u8(writer, transition->previous);
    octet_write_u8(writer, transition->current);
    pus_time_write(writer, transition->time_ns);
}

// ---- Checks of a definition ----

/// Find a parameter. For a definition from a record this always succeeds, because the parameter may exist
/// later.
static pus_failure_t find(const pus_monitoring_t* const self, const monitoring_origin_t origin,
                          pus_scalar_t* const scalar)
{
    const status_t status = (origin == MONITORING_FROM_RECORD)
                                ? STATUS_OK
                                : pus_scalar_find(&self->config.parameters, scalar->id, scalar);
    return (status == STATUS_OK) ? pus_no_failure() : pus_failure(pus_scalar_failure(status), scalar->id);
}

pus_failure_t monitoring_check_validity(const pus_monitoring_t* const self, const monitoring_origin_t origin,
                                        pus_validity_t* const validity, const uint32_t offset)
{
    if (validity->scalar.id == 0U) {
        return pus_no_failure();
    }
    if ((validity->expected & ~validity->mask) != 0U) {
        return pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    return find(self, origin, &validity->scalar);
}

pus_failure_t monitoring_check_event(const pus_monitoring_t* const self, const uint16_t event_id,
                                     const size_t size)
{
    const pus_event_port_t* const events = &self->config.events;
    if (event_id == 0U) {
        return pus_no_failure();
    }
    if (!events->is_known(events->context, event_id)) {
        return pus_failure(PUS_FAILURE_UNKNOWN_ID, event_id);
    }
    const bool is_filled = (events->can_fill == NULL) || events->can_fill(events->context, event_id, size);
    return pus_failure(is_filled ? PUS_FAILURE_NONE : PUS_FAILURE_ACCESS, event_id);
}

/// True if the criteria are possible: at least one value satisfies them.
static bool is_satisfiable(const pus_pmon_t* const pmon)
{
    pus_comparison_t order = PUS_EQUAL;
    if (pmon->check_type == (uint8_t)PUS_CHECK_EXPECTED) {
        return (pmon->high & ~pmon->low) == 0U;
    }
    if (pmon->check_type == (uint8_t)PUS_CHECK_LIMIT) {
        order = pus_scalar_compare(pmon->scalar.type, pmon->low, pmon->high);
    } else {
        order = pus_scalar_compare(pus_scalar_delta_type(pmon->scalar.type), pmon->low, pmon->high);
    }
    return (order == PUS_LESS) || (order == PUS_EQUAL);
}

pus_failure_t monitoring_check_pmon(const pus_monitoring_t* const self, const monitoring_origin_t origin,
                                    pus_pmon_t* const pmon, const uint32_t offset)
{
    pus_failure_t failure = find(self, origin, &pmon->scalar);
    if (failure.code == PUS_FAILURE_NONE) {
        failure = monitoring_check_validity(self, origin, &pmon->validity, offset);
    }
    if ((failure.code == PUS_FAILURE_NONE) && ((pmon->interval == 0U) || (pmon->repetition == 0U) ||
                                               (pmon->deltas == 0U) || !is_satisfiable(pmon))) {
        failure = pus_failure(PUS_FAILURE_OUT_OF_RANGE, offset);
    }
    if (failure.code == PUS_FAILURE_NONE) {
        failure = monitoring_check_event(self, pmon->low_event, MONITORING_PMON_EVENT);
    }
    if (failure.code == PUS_FAILURE_NONE) {
        failure = monitoring_check_event(self, pmon->high_event, MONITORING_PMON_EVENT);
    }
    return failure;
}
