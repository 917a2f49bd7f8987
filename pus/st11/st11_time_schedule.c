// SPDX-License-Identifier: Apache-2.0
#include "pus/st11/st11_time_schedule.h"

#include "base/assertion.h"
#include "generated/pus/st11_request_formats.h"

#define NS_PER_S 1000000000ULL
#define FIELD_BITS 56U // Size of a time without its P-field, and of a relative time [bits].
#define FIELD_MASK ((1ULL << FIELD_BITS) - 1U)
#define SECONDS_SHIFT 24U

static bool read_time(octet_reader_t* const reader, uint64_t* const out_tag)
{
    const uint64_t field = octet_read_u64(reader);
    *out_tag             = field & FIELD_MASK;
    return (field >> FIELD_BITS) == PUS_TIME_P_FIELD;
}

static void write_time(octet_writer_t* const writer, const uint64_t tag)
{
    octet_write_u64(writer, ((uint64_t)PUS_TIME_P_FIELD << FIELD_BITS) | tag);
}

static uint64_t now(void* const object, const uint64_t now_ns)
{
    const pus_time_schedule_t* const self = object;
    const uint64_t time_ns                = self->epoch_ns + now_ns;
    return ((time_ns / NS_PER_S) << SECONDS_SHIFT) +
           (((time_ns % NS_PER_S) * PUS_TIME_TICKS_PER_S) / NS_PER_S);
}

void pus_time_schedule_init(pus_time_schedule_t* const self, const uint32_t epoch_s,
                            const pus_schedule_config_t* const config)
{
    static const pus_schedule_kind_t kind = {.service     = PUS_SERVICE_TIME_SCHEDULE,
                                             .tag_max     = FIELD_MASK,
                                             .read_tag    = read_time,
                                             .read_offset = pus_relative_time_read,
                                             .write_tag   = write_time,
                                             .now         = now};
    FSW_ASSERT(self != NULL);
    self->epoch_ns = epoch_s * NS_PER_S;
    pus_schedule_init(&self->schedule, &kind, self, config);
}

pus_service_t pus_time_schedule_service(pus_time_schedule_t* const self)
{
    static const pus_subtype_t subtypes[] = {PUS_SCHEDULE_REQUESTS(11)};
    FSW_ASSERT(self != NULL);
    return pus_service_of(PUS_SERVICE_TIME_SCHEDULE, subtypes, sizeof subtypes / sizeof subtypes[0],
                          &self->schedule);
}

status_t pus_time_schedule_restore(pus_time_schedule_t* const self, const uint32_t key,
                                   const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT(self != NULL);
    return pus_schedule_restore(&self->schedule, key, octets, size);
}

void pus_time_schedule_step(pus_time_schedule_t* const self, const uint64_t now_ns)
{
    FSW_ASSERT(self != NULL);
    pus_schedule_step(&self->schedule, now_ns);
}

uint64_t pus_time_schedule_next_ns(const pus_time_schedule_t* const self)
{
    FSW_ASSERT(self != NULL);
    const uint64_t tag = pus_schedule_next(&self->schedule);
    if (tag == UINT64_MAX) {
        return UINT64_MAX;
    }
    // Rounded up, because `now` rounds down: at the returned time the tag has been reached.
    const uint64_t ticks   = tag % PUS_TIME_TICKS_PER_S;
    const uint64_t time_ns = ((tag / PUS_TIME_TICKS_PER_S) * NS_PER_S) +
                             (((ticks * NS_PER_S) + (PUS_TIME_TICKS_PER_S - 1U)) / PUS_TIME_TICKS_PER_S);
    return (time_ns > self->epoch_ns) ? (time_ns - self->epoch_ns) : 0U;
}
