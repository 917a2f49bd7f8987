// SPDX-License-Identifier: Apache-2.0
#include "pus/tool/pusdump_input.h"

#include "pus/core/tailoring.h"

#include <string.h>

#define PACKET_MAX 65542U // Largest possible space packet [octets].
// Largest number of characters of a line; enough for the largest packet with one space after each octet.
#define LINE_MAX 262144U
#define PEEK_MAX 16U // Octets from which the format is recognized.
#define LOCATION_MAX 32U

/// State of a stream while it is read.
typedef struct {
    FILE* stream;
    const dump_style_t* style;
    // First octets of the stream, from which the format was recognized; they are read again as input.
    uint8_t peeked[PEEK_MAX];
    size_t peeked_count;
    size_t peeked_next;
    unsigned long malformed;
} input_t;

static int next_octet(input_t* const input)
{
    if (input->peeked_next < input->peeked_count) {
        return input->peeked[input->peeked_next++];
    }
    return getc(input->stream);
}

static void show(input_t* const input, const dump_packet_t* const packet, const char* const log_time,
                 const char* const location)
{
    input->malformed += (packet->problem[0] != '\0') ? 1U : 0U;
    dump_print(input->style, packet, log_time, location);
}

// ---- Lines ----

static bool is_blank(const char character)
{
    return (character == ' ') || (character == '\t') || (character == '\r');
}

/// Read a line without its end. Returns false at the end of the stream. A line that is too long sets
/// *out_is_cut.
static bool read_line(input_t* const input, char* const line, bool* const out_is_cut)
{
    size_t length = 0U;
    int octet     = next_octet(input);
    *out_is_cut   = false;
    if (octet == EOF) {
        return false;
    }
    while ((octet != EOF) && (octet != '\n')) {
        if (length < (LINE_MAX - 1U)) {
            line[length] = (octet == '\0') ? '?' : (char)octet; // A NUL would end the line too early.
            length++;
        } else {
            *out_is_cut = true;
        }
        octet = next_octet(input);
    }
    line[length] = '\0';
    return true;
}

static int digit_of(const char character)
{
    const char* const digits = "0123456789abcdef0123456789ABCDEF";
    const char* const found  = (character != '\0') ? strchr(digits, character) : NULL;
    return (found != NULL) ? (int)((found - digits) % 16) : -1;
}

/// Convert a text of hexadecimal digits to octets. Returns null, or the error.
static const char* read_hex(const char* text, uint8_t* const octets, size_t* const out_size)
{
    size_t digits = 0U;
    *out_size     = 0U;
    for (; *text != '\0'; text++) {
        if (is_blank(*text)) {
            continue;
        }
        const int digit = digit_of(*text);
        if (digit < 0) {
            return "not a hexadecimal digit";
        }
        if ((digits / 2U) >= PACKET_MAX) {
            return "longer than any packet";
        }
        octets[digits / 2U] = (uint8_t)(((digits % 2U) == 0U) ? (digit << 4) : (octets[digits / 2U] | digit));
        digits++;
    }
    *out_size = digits / 2U;
    return ((digits % 2U) != 0U) ? "odd number of hexadecimal digits" : NULL;
}

/// Split a line `<time> TC|TM <hex>`: write a NUL after each of the first two words. Returns the rest, or
/// null if the line does not have this form.
static char* split_log_line(char* const line, const char** const out_time, const char** const out_direction)
{
    char* const direction = strchr(line, ' ');
    const bool is_log     = (direction != NULL) &&
                        ((strncmp(direction, " TC ", 4U) == 0) || (strncmp(direction, " TM ", 4U) == 0));
    if (!is_log) {
        return NULL;
    }
    *direction     = '\0';
    direction[3]   = '\0';
    *out_time      = line;
    *out_direction = &direction[1];
    return &direction[4];
}

static bool is_time(const char* const text)
{
    return (text[0] != '\0') && (text[strspn(text, "0123456789.")] == '\0');
}

static void dump_line(input_t* const input, char* const line, const bool is_cut, const dump_format_t format,
                      const char* const location)
{
    static uint8_t octets[PACKET_MAX + 1U];
    dump_packet_t packet;
    size_t size             = 0U;
    const char* log_time    = NULL;
    const char* direction   = NULL;
    char* const rest        = (format == DUMP_HEX) ? NULL : split_log_line(line, &log_time, &direction);
    const char* const wrong = read_hex((rest != NULL) ? rest : line, octets, &size);
    dump_packet_read(octets, size, &packet);
    if ((wrong != NULL) || is_cut) {
        // Report only the problem of the line, not the problems of a packet that is not complete.
        packet.problem[0] = '\0';
        dump_packet_add_problem(&packet, "%s", is_cut ? "line too long" : wrong);
    }
    if ((format == DUMP_LOG) && (rest == NULL)) {
        dump_packet_add_problem(&packet, "not a line of a packet log, expected <time> TC|TM <hex>");
    }
    if ((log_time != NULL) && !is_time(log_time)) {
        dump_packet_add_problem(&packet, "found time '%.32s', expected seconds such as 12.5", log_time);
        log_time = NULL;
    }
    if ((direction != NULL) && packet.has_primary && (packet.is_tc != (direction[1] == 'C'))) {
        dump_packet_add_problem(&packet, "the line says %s, the packet is a %s", direction,
                                packet.is_tc ? "TC" : "TM");
    }
    show(input, &packet, log_time, location);
}

static void dump_lines(input_t* const input, const dump_format_t format)
{
    static char line[LINE_MAX];
    bool is_cut          = false;
    unsigned long number = 0U;
    while (read_line(input, line, &is_cut)) {
        char* start = line;
        char location[LOCATION_MAX];
        number++;
        while (is_blank(*start)) {
            start++;
        }
        if ((*start != '\0') && (*start != '#')) {
            (void)snprintf(location, sizeof location, "line %lu", number);
            dump_line(input, start, is_cut, format, location);
        }
    }
}

// ---- Packets back to back ----

/// Read up to `count` octets. Returns their number.
static size_t read_octets(input_t* const input, uint8_t* const octets, const size_t count)
{
    size_t size = 0U;
    int octet   = 0;
    while ((size < count) && ((octet = next_octet(input)) != EOF)) {
        octets[size] = (uint8_t)octet;
        size++;
    }
    return size;
}

static void dump_binary(input_t* const input)
{
    static uint8_t octets[PACKET_MAX];
    unsigned long offset = 0U;
    size_t size          = read_octets(input, octets, PUS_PRIMARY_HEADER_SIZE);
    while (size > 0U) {
        char location[LOCATION_MAX];
        dump_packet_t packet;
        if (size == PUS_PRIMARY_HEADER_SIZE) {
            const size_t rest = (((size_t)octets[4] << 8U) | octets[5]) + 1U;
            size += read_octets(input, &octets[PUS_PRIMARY_HEADER_SIZE], rest);
        }
        (void)snprintf(location, sizeof location, "octet %lu", offset);
        dump_packet_read(octets, size, &packet);
        show(input, &packet, NULL, location);
        offset += size;
        size = read_octets(input, octets, PUS_PRIMARY_HEADER_SIZE);
    }
}

/// True if the first octets of the stream are printable characters and white space only.
static bool begins_like_text(input_t* const input)
{
    bool is_text = true;
    bool goes_on = true;
    while (goes_on && (input->peeked_count < PEEK_MAX)) {
        const int octet = getc(input->stream);
        goes_on         = (octet != EOF);
        if (goes_on) {
            input->peeked[input->peeked_count] = (uint8_t)octet;
            input->peeked_count++;
            const bool is_space = (octet == '\n') || (octet == '\r') || (octet == '\t');
            is_text             = is_text && (is_space || ((octet >= 0x20) && (octet < 0x7F)));
            goes_on             = is_text;
        }
    }
    return is_text;
}

unsigned long dump_stream(FILE* const stream, const dump_format_t format, const dump_style_t* const style)
{
    input_t input        = {.stream = stream, .style = style};
    const bool is_binary = (format == DUMP_BINARY) || ((format == DUMP_AUTO) && !begins_like_text(&input));
    if (is_binary) {
        dump_binary(&input);
    } else {
        dump_lines(&input, format);
    }
    return input.malformed;
}
