// SPDX-License-Identifier: Apache-2.0
#include "pus/st22/st22_position_schedule.h"

#include "base/assertion.h"
#include "generated/pus/st22_request_formats.h"

#define FIELD_BITS 48U // Size of a position and of an offset [bits].
#define FIELD_MASK ((1ULL << FIELD_BITS) - 1U)
#define SIGN (1ULL << (FIELD_BITS - 1U))
#define ANGLE_BITS 16U
#define ANGLE_MASK 0xFFFFU
#define RECORD_SIZE 12U // Size of the record: offset and pending change [octets].

static bool read_position(octet_reader_t* const reader, uint64_t* const out_tag)
{
    const uint64_t orbit = octet_read_u32(reader);
    *out_tag             = (orbit << ANGLE_BITS) | octet_read_u16(reader);
    return true;
}

static int64_t read_offset(octet_reader_t* const reader)
{
    uint64_t field = 0U;
    (void)read_position(reader, &field);
    return (int64_t)(field & (SIGN - 1U)) - (int64_t)(field & SIGN);
}

static void write_position(octet_writer_t* const writer, const uint64_t tag)
{
    octet_write_u32(writer, (uint32_t)(tag >> ANGLE_BITS));
    octet_write_u16(writer, (uint16_t)(tag & ANGLE_MASK));
}

uint64_t pus_position_schedule_now(pus_position_schedule_t* const self)
{
    FSW_ASSERT(self != NULL);
    const uint64_t position = self->port.read(self->port.context);
    const uint32_t orbit    = (uint32_t)(position >> ANGLE_BITS);
    if (self->is_pending && (orbit < self->orbit)) {
        // The count of the source has decreased, so the next orbit is the one after the present count.
        self->orbit = orbit;
    }
    if (self->is_pending && (orbit > self->orbit)) {
        self->is_pending = false;
        self->offset     = self->number - (self->orbit + 1U); // Modulo 2^32, like the sum below.
    }
    return ((uint64_t)(uint32_t)(orbit + self->offset) << ANGLE_BITS) | (position & ANGLE_MASK);
}

static uint64_t now(void* const object, const uint64_t now_ns)
{
    (void)now_ns;
    return pus_position_schedule_now(object);
}

void pus_position_schedule_init(pus_position_schedule_t* const self, const pus_position_port_t* const port,
                                const pus_schedule_config_t* const config)
{
    static const pus_schedule_kind_t kind = {.service     = PUS_SERVICE_POSITION_SCHEDULE,
                                             .tag_max     = FIELD_MASK,
                                             .read_tag    = read_position,
                                             .read_offset = read_offset,
                                             .write_tag   = write_position,
                                             .now         = now};
    FSW_ASSERT((self != NULL) && (port != NULL) && (port->read != NULL));
    self->port       = *port;
    self->offset     = 0U;
    self->is_pending = false;
    pus_schedule_init(&self->schedule, &kind, self, config);
}

static pus_reply_t set_orbit_number(void* const object, pus_request_t* const request)
{
    pus_schedule_t* const schedule      = object;
    pus_position_schedule_t* const self = schedule->self;
    // If the orbit of a pending orbit number has begun, this puts the number into force.
    (void)pus_position_schedule_now(self);
    const uint32_t orbit  = (uint32_t)(self->port.read(self->port.context) >> ANGLE_BITS);
    const uint32_t number = octet_read_u32(&request->reader);
    uint8_t record[RECORD_SIZE];
    octet_writer_t writer = octet_writer(record, sizeof record);
    octet_write_u32(&writer, self->offset);
    octet_write_u32(&writer, orbit);
    octet_write_u32(&writer, number);
    const pus_reply_t reply = pus_schedule_keep_own(schedule, record, sizeof record);
    if (reply.kind == PUS_DONE) {
        self->is_pending = true;
        self->orbit      = orbit;
        self->number     = number;
    }
    return reply;
}

pus_service_t pus_position_schedule_service(pus_position_schedule_t* const self)
{
    static const pus_subtype_t subtypes[] = {PUS_SCHEDULE_REQUESTS(22),
                                             PUS_REQUEST(22, 28, set_orbit_number)};
    FSW_ASSERT(self != NULL);
    return pus_service_of(PUS_SERVICE_POSITION_SCHEDULE, subtypes, sizeof subtypes / sizeof subtypes[0],
                          &self->schedule);
}

status_t pus_position_schedule_restore(pus_position_schedule_t* const self, const uint32_t key,
                                       const uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((self != NULL) && (octets != NULL));
    if (key != PUS_SCHEDULE_KEY_OWN) {
        return pus_schedule_restore(&self->schedule, key, octets, size);
    }
    if (size != RECORD_SIZE) {
        return STATUS_INVALID;
    }
    octet_reader_t reader = octet_reader(octets, size);
    self->offset          = octet_read_u32(&reader);
    self->orbit           = octet_read_u32(&reader);
    self->number          = octet_read_u32(&reader);
    // The number may be in force already, if its orbit began before the restart; then the next reading of the
    // position puts it into force again.
    self->is_pending = true;
    return STATUS_OK;
}

void pus_position_schedule_step(pus_position_schedule_t* const self, const uint64_t now_ns)
{
    FSW_ASSERT(self != NULL);
    pus_schedule_step(&self->schedule, now_ns);
}
