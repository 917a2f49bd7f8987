// SPDX-License-Identifier: Apache-2.0
// Proves: if every value of a parameter is a finite number within its bounds, this is also true after any
//     write from a packet; a write that is refused changes no value and is counted; only a settable parameter
//     is written; no octet is stored outside the storage of the parameter.
// Bounds: a parameter of two doubles and an integer of 16 bits with any bounds; writes of 0..18 octets.
// Replaced: the mutex does nothing.
// Sources: fsw/framework/parameter/parameter.c base/value.c base/octets.c
// Options: --unwind 9
// Fault: fsw/framework/parameter/parameter.c
//   - return is_finite && (value >= bounds->min) && (value <= bounds->max);
//   + return is_finite && !(value < bounds->min) && ((value <= bounds->max) || (value > 1.0e300));
// Fault: fsw/framework/parameter/parameter.c
//   - return entry->is_settable ? decode(entry, reader, false) : STATUS_READ_ONLY;
//   + return entry->is_settable ? STATUS_OK : STATUS_READ_ONLY;
#include "fsw/framework/parameter/parameter.h"
#include "test/proof/proof.h"

#include <float.h>

#define OCTETS 17U

typedef struct {
    double gains[2];
    int16_t offset;
} values_t;

static const parameter_field_t fields[]        = {{"gains", VALUE_DOUBLE, 2U, 0U},
                                                  {"offset", VALUE_INT16, 1U, offsetof(values_t, offset)}};
static const parameter_definition_t definition = {"values", PARAMETER_ID(1U, 24U, 1U), fields,
                                                  2U,       sizeof(values_t),          18U};

status_t osal_mutex_create(osal_mutex_t* const mutex, const bool is_shared)
{
    (void)mutex;
    (void)is_shared;
    return STATUS_OK;
}

status_t osal_mutex_lock(osal_mutex_t* const mutex)
{
    (void)mutex;
    return STATUS_OK;
}

void osal_mutex_unlock(osal_mutex_t* const mutex)
{
    (void)mutex;
}

static bool is_within(const values_t* const values, const parameter_bounds_t* const bounds)
{
    return (values->gains[0] >= bounds[0].min) && (values->gains[0] <= bounds[0].max) &&
           (values->gains[1] >= bounds[0].min) && (values->gains[1] <= bounds[0].max) &&
           (values->offset >= bounds[1].min) && (values->offset <= bounds[1].max);
}

double nondet_double(void);

void proof(void)
{
    parameter_dictionary_t dictionary;
    parameter_entry_t entries[1];
    parameter_bounds_t bounds[2];
    values_t values;
    uint8_t octets[OCTETS + 1U];
    PROVE(parameter_init(&dictionary, entries, 1U, bounds, 2U) == STATUS_OK, "the dictionary is initialised");
    PROVE(parameter_publish(&dictionary, &definition, &values) == STATUS_OK, "the parameter is published");
    entries[0].is_settable = nondet_bool();
    bounds[0]              = (parameter_bounds_t){nondet_double(), nondet_double()};
    bounds[1]              = (parameter_bounds_t){nondet_double(), nondet_double()};
    ASSUME((bounds[0].min >= -DBL_MAX) && (bounds[0].max <= DBL_MAX));
    ASSUME(is_within(&values, bounds));
    const values_t before = values;
    octet_reader_t reader = octet_reader(octets, any_size(OCTETS + 1U));
    const status_t status = parameter_write(&dictionary, definition.id, &reader);
    PROVE(is_within(&values, bounds), "every value is within its bounds");
    const parameter_refusals_t* const refusals = &dictionary.refusals;
    if (status == STATUS_OK) {
        PROVE(entries[0].is_settable && (reader.position == definition.wire_size),
              "a parameter that is written is settable, and its value is read whole");
    } else {
        PROVE((values.gains[0] == before.gains[0]) && (values.gains[1] == before.gains[1]) &&
                  (values.offset == before.offset),
              "what is refused changes nothing");
        PROVE((refusals->read_only + refusals->out_of_range + refusals->malformed) == 1U,
              "a refusal is counted");
    }
}
