// SPDX-License-Identifier: Apache-2.0
#include "pus/tool/pusdump_print.h"

#include "pus/core/tailoring.h"
#include "pus/tool/pusdump_fields.h"
#include "pus/tool/pusdump_messages.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define FIELDS_MAX 262144U // Characters for the fields of a packet; no packet needs more.
#define HEX_MAX 64U        // Largest number of octets of a malformed packet that are printed.
#define NS_PER_S ((uint64_t)1000000000)
#define S_PER_DAY ((uint64_t)86400)
#define DAYS_TO_1958 ((uint64_t)715085) // Days from 0000-03-01 to 1958-01-01.

/// Decode the fields of a packet into `text`. False if that is not possible.
static bool decode(const dump_packet_t* const packet, const bool as_json, char* const text,
                   const size_t capacity)
{
    const char* const layout = message_layout(packet->service, packet->subtype);
    const bool is_whole = packet->has_secondary && (packet->data != NULL) && (packet->problem[0] == '\0');
    return is_whole && (layout != NULL) &&
           dump_fields(layout, packet->data, packet->data_size, as_json, text, capacity);
}

static const char* name_of(const dump_packet_t* const packet)
{
    if (packet->has_secondary) {
        return message_name(packet->service, packet->subtype);
    }
    if (packet->apid == PUS_APID_TIME) {
        return "spacecraft time packet";
    }
    return (packet->apid == PUS_APID_IDLE) ? "idle packet" : "unknown message";
}

static void print_hex(const uint8_t* const octets, const size_t size)
{
    for (size_t i = 0U; i < size; i++) {
        (void)printf("%02x", octets[i]);
    }
}

static void print_seconds(const uint64_t time_ns)
{
    (void)printf("%" PRIu64 ".%09" PRIu64, time_ns / NS_PER_S, time_ns % NS_PER_S);
}

/// Print the calendar date and the time of day on the TAI scale, from nanoseconds since 1958-01-01.
static void print_calendar(const uint64_t time_ns)
{
    const uint64_t seconds    = time_ns / NS_PER_S;
    const uint64_t days       = (seconds / S_PER_DAY) + DAYS_TO_1958;
    const uint64_t era        = days / 146097U;
    const uint64_t day_of_era = days % 146097U;
    const uint64_t year_of_era =
        (day_of_era - (day_of_era / 1460U) + (day_of_era / 36524U) - (day_of_era / 146096U)) / 365U;
    const uint64_t day_of_year =
        day_of_era - ((365U * year_of_era) + (year_of_era / 4U) - (year_of_era / 100U)); // From 1 March.
    const uint64_t month_from_march = ((5U * day_of_year) + 2U) / 153U;
    const uint64_t day              = day_of_year - (((153U * month_from_march) + 2U) / 5U) + 1U;
    const uint64_t month = (month_from_march < 10U) ? (month_from_march + 3U) : (month_from_march - 9U);
    const uint64_t year  = (era * 400U) + year_of_era + ((month <= 2U) ? 1U : 0U);
    const uint64_t second_of_day = seconds % S_PER_DAY;
    (void)printf("%04" PRIu64 "-%02" PRIu64 "-%02" PRIu64 "T%02" PRIu64 ":%02" PRIu64 ":%02" PRIu64
                 ".%09" PRIu64 " TAI",
                 year, month, day, second_of_day / 3600U, (second_of_day / 60U) % 60U, second_of_day % 60U,
                 time_ns % NS_PER_S);
}

static void print_time(const dump_style_t* const style, const dump_packet_t* const packet)
{
    if (style->has_epoch && (packet->time_ns >= style->epoch_ns)) {
        print_seconds(packet->time_ns - style->epoch_ns);
    } else if (style->has_epoch) {
        (void)printf("-");
        print_seconds(style->epoch_ns - packet->time_ns);
    } else if (dump_packet_is_tai(packet)) {
        print_calendar(packet->time_ns);
    } else {
        print_seconds(packet->time_ns);
    }
}

static void print_header(const dump_style_t* const style, const dump_packet_t* const packet)
{
    (void)printf("%s %u #%u", packet->is_tc ? "TC" : "TM", (unsigned)packet->apid,
                 (unsigned)packet->sequence);
    if (packet->has_secondary) {
        (void)printf(" [%u,%u] %s", (unsigned)packet->service, (unsigned)packet->subtype, name_of(packet));
        (void)printf(packet->is_tc ? " from %u" : " to %u", (unsigned)packet->user);
    } else {
        (void)printf(" %s", name_of(packet));
    }
    if (packet->has_secondary && packet->is_tc) {
        (void)printf(" ack %s%s%s%s%s", ((packet->flags & PUS_ACK_ACCEPTANCE) != 0U) ? "A" : "",
                     ((packet->flags & PUS_ACK_START) != 0U) ? "S" : "",
                     ((packet->flags & PUS_ACK_PROGRESS) != 0U) ? "P" : "",
                     ((packet->flags & PUS_ACK_COMPLETION) != 0U) ? "C" : "",
                     (packet->flags == 0U) ? "none" : "");
    }
    if (packet->has_time) {
        (void)printf(" at ");
        print_time(style, packet);
    }
}

static void print_text(const dump_style_t* const style, const dump_packet_t* const packet,
                       const char* const log_time, const char* const location)
{
    static char fields[FIELDS_MAX];
    if (log_time != NULL) {
        (void)printf("%s ", log_time);
    }
    if (packet->problem[0] != '\0') {
        (void)printf("MALFORMED (%s): %s: ", location, packet->problem);
        print_hex(packet->octets, (packet->size < HEX_MAX) ? packet->size : HEX_MAX);
        (void)printf("%s\n", (packet->size > HEX_MAX) ? "..." : "");
        return;
    }
    print_header(style, packet);
    if (decode(packet, false, fields, sizeof fields)) {
        (void)printf("%s%s", (fields[0] != '\0') ? "  " : "", fields);
    } else if (packet->data_size > 0U) {
        (void)printf("  data=");
        print_hex(packet->data, packet->data_size);
    } else {
        // The packet has no data to print.
    }
    (void)printf("\n");
}

static void print_json_text(const char* const key, const char* const value)
{
    (void)printf(",\"%s\":", key);
    if (value == NULL) {
        (void)printf("null");
        return;
    }
    (void)printf("\"");
    for (const char* character = value; *character != '\0'; character++) {
        const bool is_special = (*character == '"') || (*character == '\\');
        (void)printf(is_special ? "\\%c" : "%c", ((unsigned char)*character < 0x20U) ? ' ' : *character);
    }
    (void)printf("\"");
}

static void print_json_number(const char* const key, const bool is_there, const uint64_t value)
{
    if (is_there) {
        (void)printf(",\"%s\":%" PRIu64, key, value);
    } else {
        (void)printf(",\"%s\":null", key);
    }
}

static void print_json_time(const dump_style_t* const style, const dump_packet_t* const packet)
{
    const bool is_before   = style->has_epoch && (packet->time_ns < style->epoch_ns);
    const uint64_t epoch   = style->has_epoch ? style->epoch_ns : 0U;
    const uint64_t time_ns = is_before ? (epoch - packet->time_ns) : (packet->time_ns - epoch);
    if (packet->has_time) {
        (void)printf(",\"time_ns\":%s%" PRIu64, is_before ? "-" : "", time_ns);
    } else {
        (void)printf(",\"time_ns\":null");
    }
}

static void print_json_data(const dump_packet_t* const packet)
{
    static char fields[FIELDS_MAX];
    (void)printf(",\"data\":");
    if (packet->data != NULL) {
        (void)printf("\"");
        print_hex(packet->data, packet->data_size);
        (void)printf("\"");
    } else {
        (void)printf("null");
    }
    (void)printf(",\"fields\":%s", decode(packet, true, fields, sizeof fields) ? fields : "null");
}

static void print_json(const dump_style_t* const style, const dump_packet_t* const packet,
                       const char* const log_time, const char* const location)
{
    const bool has_second = packet->has_secondary;
    if (packet->has_primary) {
        (void)printf("{\"direction\":\"%s\"", packet->is_tc ? "TC" : "TM");
    } else {
        (void)printf("{\"direction\":null");
    }
    print_json_number("apid", packet->has_primary, packet->apid);
    print_json_number("service", has_second, packet->service);
    print_json_number("subtype", has_second, packet->subtype);
    print_json_number("seq", packet->has_primary, packet->sequence);
    print_json_number(packet->is_tc ? "source" : "destination", has_second, packet->user);
    if (packet->is_tc) {
        print_json_number("ack", has_second, packet->flags);
    } else {
        print_json_number("counter", has_second, packet->counter);
    }
    print_json_time(style, packet);
    if (packet->has_crc) {
        (void)printf(",\"crc_ok\":%s", packet->crc_is_good ? "true" : "false");
    } else {
        (void)printf(",\"crc_ok\":null");
    }
    print_json_text("error", (packet->problem[0] != '\0') ? packet->problem : NULL);
    print_json_text("name", packet->has_primary ? name_of(packet) : NULL);
    print_json_number("size", true, packet->size);
    print_json_text("log_time", log_time);
    print_json_text("location", location);
    print_json_data(packet);
    (void)printf("}\n");
}

void dump_print(const dump_style_t* const style, const dump_packet_t* const packet,
                const char* const log_time, const char* const location)
{
    if (style->as_json) {
        print_json(style, packet, log_time, location);
    } else {
        print_text(style, packet, log_time, location);
    }
}
