// SPDX-License-Identifier: Apache-2.0
#include "pus/core/app_process.h"

#include "base/assertion.h"
#include "base/crc.h"

#include <string.h>

#define OFFSET_SEQUENCE 2U // Offsets of fields in a report [octets].
#define OFFSET_LENGTH 4U
#define OFFSET_VERSION 6U
#define OFFSET_SERVICE 7U
#define OFFSET_SUBTYPE 8U
#define OFFSET_COUNTER 9U
#define OFFSET_DESTINATION 11U
#define OFFSET_TIME 13U
#define NS_PER_S 1000000000ULL
#define HIGH_EVENT 0x0504U   // TM[5,4]: service and subtype in the header.
#define EVENT_NOTICE 0x8107U // TM[129,7]: service and subtype in the header.

void pus_app_process_init(pus_app_process_t* const process, const uint16_t apid, const uint32_t epoch_s,
                          const pus_port_t* const port)
{
    FSW_ASSERT((process != NULL) && (port != NULL) && (port->send != NULL) && (apid >= 1U) &&
               (apid <= PUS_APID_MAX));
    (void)memset(process, 0, sizeof *process);
    process->apid     = apid;
    process->epoch_ns = epoch_s * NS_PER_S;
    process->port     = *port;
}

void pus_app_process_keep(pus_app_process_t* const process, pus_report_queues_t* const queues)
{
    FSW_ASSERT((process != NULL) && (queues != NULL));
    process->firm  = (pus_kept_t){.octets = queues->firm, .capacity = sizeof queues->firm};
    process->plain = (pus_kept_t){.octets = queues->plain, .capacity = sizeof queues->plain};
}

void pus_app_process_keep_in_order(pus_app_process_t* const process, uint8_t* const octets, const size_t size)
{
    FSW_ASSERT((process != NULL) && (octets != NULL));
    process->firm  = (pus_kept_t){.octets = octets, .capacity = size};
    process->plain = (pus_kept_t){0};
}

void pus_app_process_lengthen(pus_app_process_t* const process, const pus_long_port_t* const port)
{
    FSW_ASSERT((process != NULL) && (port != NULL) && (port->begin != NULL) && (port->post != NULL) &&
               (port->data_max >= PUS_TM_DATA_MAX));
    process->longer = *port;
}

/// Returns the counter of the message type and destination of a packet; creates an entry if there is none.
/// Null if the table is full.
static pus_message_counter_t* counter_of(pus_app_process_t* const process, const uint8_t* const packet)
{
    const uint8_t service      = packet[OFFSET_SERVICE];
    const uint8_t subtype      = packet[OFFSET_SUBTYPE];
    const uint16_t destination = octets_u16_at(&packet[OFFSET_DESTINATION]);
    for (size_t i = 0U; i < PUS_MESSAGE_COUNTERS; i++) {
        pus_message_counter_t* const entry = &process->messages[i];
        if (entry->service == 0U) {
            *entry = (pus_message_counter_t){
                .service = service, .subtype = subtype, .destination = destination, .count = 0U};
        }
        if ((entry->service == service) && (entry->subtype == subtype) &&
            (entry->destination == destination)) {
            return entry;
        }
    }
    return NULL;
}

/// Write sequence count, message type counter and checksum into a built packet, which has room for them.
static void number(const pus_app_process_t* const process, uint8_t* const packet, const size_t size,
                   const pus_message_counter_t* const counter)
{
    octets_put_u16(&packet[OFFSET_SEQUENCE], (uint16_t)((PUS_UNSEGMENTED << 14U) | process->sequence));
    octets_put_u16(&packet[OFFSET_COUNTER], (counter != NULL) ? counter->count : 0U);
    octets_put_u16(&packet[size], crc16_ccitt(packet, size));
}

/// Advance the message type counter after a report with its value was sent or closed.
static void count(pus_app_process_t* const process, pus_message_counter_t* const counter)
{
    if (counter != NULL) {
        counter->count++;
    } else {
        process->counters.uncounted++;
    }
}

/// Number a built packet, add the checksum, and offer it to the port. `packet` has room for the checksum.
static status_t transmit(pus_app_process_t* const process, uint8_t* const packet, const size_t size)
{
    pus_message_counter_t* const counter = counter_of(process, packet);
    number(process, packet, size, counter);
    if (process->port.send(process->port.context, packet, size + PUS_CRC_SIZE) != STATUS_OK) {
        process->counters.refused++;
        return STATUS_FULL;
    }
    process->sequence = (uint16_t)((process->sequence + 1U) % PUS_SEQUENCE_COUNT);
    count(process, counter);
    process->counters.sent++;
    return STATUS_OK;
}

octet_writer_t pus_tm_begin_large(const pus_app_process_t* const process, uint8_t* const octets,
                                  const size_t capacity, const uint8_t service, const uint8_t subtype,
                                  const uint16_t destination, const uint64_t now_ns)
{
    FSW_ASSERT((process != NULL) && (octets != NULL) && (capacity >= PUS_TM_MIN) && (service != 0U));
    octet_writer_t writer = octet_writer(octets, capacity - PUS_CRC_SIZE);
    // Not null, because the buffer has room for the header.
    uint8_t* const header = octet_write_space(&writer, OFFSET_TIME);
    // Sequence, length and counter are written when the report is finished.
    octets_put_u16(header, (uint16_t)(0x0800U | process->apid));
    header[OFFSET_VERSION] = PUS_VERSION << 4U;
    header[OFFSET_SERVICE] = service;
    header[OFFSET_SUBTYPE] = subtype;
    octets_put_u16(&header[OFFSET_DESTINATION], destination);
    pus_time_write(&writer, process->epoch_ns + now_ns);
    return writer;
}

octet_writer_t pus_tm_begin(pus_app_process_t* const process, const uint8_t service, const uint8_t subtype,
                            const uint16_t destination, const uint64_t now_ns)
{
    FSW_ASSERT(process != NULL);
    if (process->is_building) {
        process->counters.discarded++;
    }
    process->is_building = true;
    return pus_tm_begin_large(process, process->building, PUS_PACKET_MAX, service, subtype, destination,
                              now_ns);
}

static void write_length(uint8_t* const packet, const size_t size)
{
    octets_put_u16(&packet[OFFSET_LENGTH],
                   (uint16_t)((size + PUS_CRC_SIZE) - (PUS_PRIMARY_HEADER_SIZE + 1U)));
}

/// Close the report that is being built. STATUS_OK, STATUS_TOO_LARGE, STATUS_INVALID.
static status_t close_report(pus_app_process_t* const process, octet_writer_t* const writer)
{
    const bool was_building = process->is_building;
    const bool failed       = writer->failed;
    process->is_building    = false;
    writer->failed          = true; // The report is finished: it cannot be extended or sent again.
    if (!was_building) {
        process->counters.discarded++;
        return STATUS_INVALID;
    }
    if (failed) {
        process->counters.oversized++;
        return STATUS_TOO_LARGE;
    }
    FSW_ASSERT((writer->octets == process->building) && (writer->position >= PUS_TM_HEADER_SIZE));
    write_length(process->building, writer->position);
    return STATUS_OK;
}

/// Send the reports of a queue until the port refuses one. STATUS_OK (the queue is empty now), STATUS_FULL.
static status_t send_kept(pus_app_process_t* const process, pus_kept_t* const kept)
{
    size_t sent     = 0U;
    status_t status = STATUS_OK;
    while ((sent < kept->size) && (status == STATUS_OK)) {
        const size_t size = octets_u16_at(&kept->octets[sent]);
        status            = transmit(process, &kept->octets[sent + PUS_KEPT_PREFIX], size);
        sent += (status == STATUS_OK) ? (PUS_KEPT_PREFIX + size + PUS_CRC_SIZE) : 0U;
    }
    if (sent > 0U) {
        kept->size -= sent;
        (void)memmove(kept->octets, &kept->octets[sent], kept->size);
    }
    return status;
}

status_t pus_app_process_flush(pus_app_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    const status_t status = send_kept(process, &process->firm);
    return (status == STATUS_OK) ? send_kept(process, &process->plain) : status;
}

bool pus_app_process_is_waiting(const pus_app_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    return (process->firm.size > 0U) || (process->plain.size > 0U);
}

bool pus_app_process_keeps_event(const pus_app_process_t* const process, const uint16_t event_id)
{
    FSW_ASSERT(process != NULL);
    const pus_kept_t* const kept = &process->firm;
    bool is_found                = false;
    size_t at                    = 0U;
    while ((at < kept->size) && !is_found) {
        const uint8_t* const packet = &kept->octets[at + PUS_KEPT_PREFIX];
        const uint16_t type         = octets_u16_at(&packet[OFFSET_SERVICE]);
        is_found                    = ((type == HIGH_EVENT) || (type == EVENT_NOTICE)) &&
                   (octets_u16_at(&packet[PUS_TM_HEADER_SIZE]) == event_id);
        at += PUS_KEPT_PREFIX + octets_u16_at(&kept->octets[at]) + PUS_CRC_SIZE;
    }
    return is_found;
}

static size_t room_of(const pus_kept_t* const kept)
{
    return kept->capacity - kept->size;
}

bool pus_app_process_may_answer(const pus_app_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    return (room_of(&process->firm) >= (PUS_FIRM_OF_REQUEST + PUS_FIRM_STANDING + PUS_FIRM_EVENTS)) &&
           (room_of(&process->plain) >= PUS_ANSWER_ROOM);
}

bool pus_app_process_has_firm_room(const pus_app_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    return room_of(&process->firm) >= (PUS_FIRM_OF_REQUEST + PUS_FIRM_STANDING + PUS_FIRM_EVENTS);
}

/// True if a report does not answer a request: an event, a status or a notice.
static bool is_unsolicited(const uint8_t* const packet)
{
    return (octets_u16_at(&packet[OFFSET_DESTINATION]) == PUS_USER_GROUND) ||
           (octets_u16_at(&packet[OFFSET_SERVICE]) == EVENT_NOTICE);
}

/// True if the packet is a verification report and an answer to the same user is kept: the completion of a
/// request must not overtake its answer.
static bool follows_answer(const pus_app_process_t* const process, const uint8_t* const packet)
{
    const pus_kept_t* const kept = &process->plain;
    const uint16_t user          = octets_u16_at(&packet[OFFSET_DESTINATION]);
    bool is_found                = false;
    size_t at                    = 0U;
    while ((packet[OFFSET_SERVICE] == PUS_SERVICE_VERIFICATION) && (at < kept->size) && !is_found) {
        const uint8_t* const before = &kept->octets[at + PUS_KEPT_PREFIX];
        is_found = (octets_u16_at(&before[OFFSET_DESTINATION]) == user) && !is_unsolicited(before);
        at += PUS_KEPT_PREFIX + octets_u16_at(&kept->octets[at]) + PUS_CRC_SIZE;
    }
    return is_found;
}

/// Returns the queue for the built report. The reports that are already in this queue must be sent before it.
static pus_kept_t* queue_of(pus_app_process_t* const process, const pus_class_t of_report)
{
    const bool is_first = (of_report == PUS_CLASS_FIRM) && !follows_answer(process, process->building);
    return (is_first || (process->plain.capacity == 0U)) ? &process->firm : &process->plain;
}

status_t pus_tm_send(pus_app_process_t* const process, octet_writer_t* const writer)
{
    FSW_ASSERT((process != NULL) && (writer != NULL));
    const status_t status = close_report(process, writer);
    if (status != STATUS_OK) {
        return status;
    }
    const pus_class_t of_report = pus_class_of(process->building, writer->position);
    const bool is_first         = queue_of(process, of_report) == &process->firm;
    const status_t before = is_first ? send_kept(process, &process->firm) : pus_app_process_flush(process);
    return (before == STATUS_OK) ? transmit(process, process->building, writer->position) : STATUS_FULL;
}

/// Keep the report that was built. STATUS_OK, STATUS_EXHAUSTED.
static status_t keep(pus_app_process_t* const process, const size_t size)
{
    const size_t step           = PUS_KEPT_PREFIX + size + PUS_CRC_SIZE;
    const pus_class_t of_report = pus_class_of(process->building, size);
    const bool is_firm          = (of_report == PUS_CLASS_FIRM);
    pus_kept_t* kept            = queue_of(process, of_report);
    size_t reserve              = 0U;
    if (is_firm && (step > room_of(kept))) {
        kept = &process->firm; // The report overtakes its answer, because otherwise it would be lost.
    } else if ((kept == &process->plain) && is_unsolicited(process->building)) {
        reserve = PUS_ANSWER_ROOM; // Room that stays free for the answer to a request.
    } else {
        // The report may use the whole queue.
    }
    if ((of_report == PUS_CLASS_BULK) || ((step + reserve) > room_of(kept))) {
        process->counters.lost++;
        process->counters.lost_firm += is_firm ? 1U : 0U;
        return STATUS_EXHAUSTED;
    }
    uint8_t* const entry = &kept->octets[kept->size];
    octets_put_u16(entry, (uint16_t)size);
    (void)memcpy(&entry[PUS_KEPT_PREFIX], process->building, size);
    kept->size += step;
    process->counters.kept++;
    return STATUS_OK;
}

status_t pus_tm_post(pus_app_process_t* const process, octet_writer_t* const writer)
{
    const status_t status = pus_tm_send(process, writer);
    return (status == STATUS_FULL) ? keep(process, writer->position) : status;
}

status_t pus_tm_forward(pus_app_process_t* const process, const uint8_t* const packet, const size_t size)
{
    FSW_ASSERT((process != NULL) && (packet != NULL) && (size >= (PUS_TM_HEADER_SIZE + PUS_CRC_SIZE)));
    octet_writer_t writer = octet_writer(process->building, PUS_PACKET_MAX - PUS_CRC_SIZE);
    octet_write_octets(&writer, packet, size - PUS_CRC_SIZE);
    process->counters.discarded += process->is_building ? 1U : 0U;
    process->is_building = true;
    return pus_tm_post(process, &writer);
}

status_t pus_tm_close_large(pus_app_process_t* const process, octet_writer_t* const writer,
                            size_t* const out_size)
{
    FSW_ASSERT((process != NULL) && (writer != NULL) && (out_size != NULL));
    const size_t size = writer->position;
    *out_size         = 0U;
    if (writer->failed || ((size + PUS_CRC_SIZE) > PUS_LARGE_MAX)) {
        process->counters.oversized++;
        return STATUS_TOO_LARGE;
    }
    pus_message_counter_t* const counter = counter_of(process, writer->octets);
    write_length(writer->octets, size);
    number(process, writer->octets, size, counter);
    count(process, counter);
    *out_size = size + PUS_CRC_SIZE;
    return STATUS_OK;
}

size_t pus_tm_data_max(const pus_app_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    return (process->longer.begin != NULL) ? process->longer.data_max : PUS_TM_DATA_MAX;
}

status_t pus_tm_begin_sized(pus_app_process_t* const process, const uint8_t service, const uint8_t subtype,
                            const uint16_t destination, const uint64_t now_ns, const size_t size,
                            octet_writer_t* const out_writer)
{
    FSW_ASSERT((process != NULL) && (size <= pus_tm_data_max(process)) && (out_writer != NULL));
    if (size > PUS_TM_DATA_MAX) {
        return process->longer.begin(process->longer.context, service, subtype, destination, now_ns,
                                     out_writer);
    }
    *out_writer = pus_tm_begin(process, service, subtype, destination, now_ns);
    return STATUS_OK;
}

status_t pus_tm_post_sized(pus_app_process_t* const process, octet_writer_t* const writer)
{
    FSW_ASSERT((process != NULL) && (writer != NULL));
    return (writer->octets == process->building) ? pus_tm_post(process, writer)
                                                 : process->longer.post(process->longer.context, writer);
}

void pus_tm_cancel(pus_app_process_t* const process)
{
    FSW_ASSERT(process != NULL);
    process->is_building = false;
}
