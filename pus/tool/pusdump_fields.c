// SPDX-License-Identifier: Apache-2.0
#include "pus/tool/pusdump_fields.h"

#include "base/octets.h"
#include "pus/core/tailoring.h"
#include "pus/tool/pusdump_messages.h"
#include "pus/tool/pusdump_packet.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define DEPTH_MAX 3U // Largest depth of nested lists.
#define WORD_MAX 32U // Largest number of characters of a name or type, NUL included.

/// A list that is being decoded.
typedef struct {
    const char* body;
    unsigned left; ///< Number of remaining entries, the present one included.
} list_t;

typedef struct {
    octet_reader_t reader;
    bool as_json;
    bool needs_glue; ///< An item comes before the next one in this list or object, so a separator is needed.
    char* text;
    size_t capacity;
    size_t length;
    bool is_cut;
    list_t lists[DEPTH_MAX];
    size_t depth;
} decoder_t;

static void put(decoder_t* const decoder, const char* const format, ...)
    __attribute__((format(printf, 2, 3)));

static void put(decoder_t* const decoder, const char* const format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int count =
        vsnprintf(&decoder->text[decoder->length], decoder->capacity - decoder->length, format, arguments);
    va_end(arguments);
    if ((count < 0) || ((size_t)count >= (decoder->capacity - decoder->length))) {
        decoder->is_cut                = true;
        decoder->text[decoder->length] = '\0';
    } else {
        decoder->length += (size_t)count;
    }
}

static void put_name(decoder_t* const decoder, const char* const name)
{
    const char* const glue = decoder->as_json ? "," : " ";
    put(decoder, decoder->as_json ? "%s\"%s\":" : "%s%s=", decoder->needs_glue ? glue : "", name);
    decoder->needs_glue = true;
}

static void put_hex(decoder_t* const decoder, const uint8_t* const octets, const size_t size)
{
    put(decoder, "%s", decoder->as_json ? "\"" : "");
    for (size_t i = 0U; (octets != NULL) && (i < size); i++) {
        put(decoder, "%02x", octets[i]);
    }
    put(decoder, "%s", decoder->as_json ? "\"" : "");
}

/// Text of a name in a packet: characters other than printable ASCII, and quotes, become question marks.
static void put_text(decoder_t* const decoder, const uint8_t* const octets, const size_t size)
{
    const char* const quote = decoder->as_json ? "\"" : "";
    put(decoder, "%s", quote);
    for (size_t i = 0U; (octets != NULL) && (i < size) && (octets[i] != 0U); i++) {
        const bool is_plain =
            (octets[i] > 0x20U) && (octets[i] < 0x7FU) && (octets[i] != '"') && (octets[i] != '\\');
        put(decoder, "%c", is_plain ? (char)octets[i] : '?');
    }
    put(decoder, "%s", quote);
}

static void put_time(decoder_t* const decoder)
{
    uint8_t p_field  = 0U;
    uint64_t time_ns = 0U;
    if (dump_time_read(&decoder->reader, &p_field, &time_ns) != STATUS_OK) {
        decoder->reader.failed = true;
    }
    put(decoder, decoder->as_json ? "%" PRIu64 "%s" : "%" PRIu64 "%s", time_ns, decoder->as_json ? "" : "ns");
}

static void put_code(decoder_t* const decoder)
{
    const uint16_t code = octet_read_u16(&decoder->reader);
    if (decoder->as_json) {
        put(decoder, "%u,\"meaning\":\"%s\"", (unsigned)code, failure_words(code));
    } else {
        put(decoder, "0x%04X (%s)", (unsigned)code, failure_words(code));
    }
}

static void put_request_id(decoder_t* const decoder)
{
    const uint32_t id = octet_read_u32(&decoder->reader);
    put(decoder, decoder->as_json ? "{\"apid\":%u,\"seq\":%u}" : "%u/%u", (unsigned)((id >> 16U) & 0x7FFU),
        (unsigned)(id & 0x3FFFU));
}

static void put_number(decoder_t* const decoder, const char* const type)
{
    const bool is_hex     = (type[0] == 'x');
    const unsigned digits = (strcmp(&type[1], "8") == 0)    ? 2U
                            : (strcmp(&type[1], "16") == 0) ? 4U
                            : (strcmp(&type[1], "32") == 0) ? 8U
                                                            : 16U;
    uint64_t value        = 0U;
    for (unsigned i = 0U; i < (digits / 2U); i++) {
        value = (value << 8U) | octet_read_u8(&decoder->reader);
    }
    if (is_hex) {
        put(decoder, decoder->as_json ? "\"0x%0*" PRIX64 "\"" : "0x%0*" PRIX64, (int)digits, value);
    } else {
        put(decoder, "%" PRIu64, value);
    }
}

static void put_value(decoder_t* const decoder, const char* const name, const char* const type)
{
    put_name(decoder, name);
    if (strcmp(type, "code") == 0) {
        put_code(decoder);
    } else if (strcmp(type, "id") == 0) {
        put_request_id(decoder);
    } else if (strcmp(type, "time") == 0) {
        put_time(decoder);
    } else if (strcmp(type, "text") == 0) {
        put_text(decoder, octet_read_octets(&decoder->reader, PUS_NAME_SIZE), PUS_NAME_SIZE);
    } else if (strcmp(type, "octets") == 0) {
        const uint8_t size = octet_read_u8(&decoder->reader);
        put_hex(decoder, octet_read_octets(&decoder->reader, size), size);
    } else if (strcmp(type, "rest") == 0) {
        const size_t size = octet_reader_left(&decoder->reader);
        put_hex(decoder, octet_read_octets(&decoder->reader, size), size);
    } else {
        put_number(decoder, type);
    }
}

/// Returns the position in the layout after the list whose body begins at `body`.
static const char* after_list(const char* body)
{
    unsigned open = 1U;
    while ((*body != '\0') && (open > 0U)) {
        open += (*body == '[') ? 1U : 0U;
        open -= (*body == ']') ? 1U : 0U;
        body++;
    }
    return (*body == ' ') ? (body + 1) : body;
}

static void open_entry(decoder_t* const decoder)
{
    put(decoder, "%s", decoder->as_json ? "{" : "");
    decoder->needs_glue = false;
}

/// Begin a list. Returns the position at which the layout continues.
static const char* open_list(decoder_t* const decoder, const char* const name, const char* const width,
                             const char* const body)
{
    const unsigned count =
        (strcmp(width, "8") == 0) ? octet_read_u8(&decoder->reader) : octet_read_u16(&decoder->reader);
    put_name(decoder, name);
    put(decoder, "[");
    if ((count == 0U) || (decoder->depth >= DEPTH_MAX)) {
        put(decoder, "]");
        return after_list(body);
    }
    decoder->lists[decoder->depth] = (list_t){.body = body, .left = count};
    decoder->depth++;
    open_entry(decoder);
    return body;
}

/// End an entry. Returns the position at which the layout continues: the body of the next entry, or after the
/// list.
static const char* close_entry(decoder_t* const decoder, const char* const next)
{
    list_t* const list = &decoder->lists[decoder->depth - 1U];
    put(decoder, "%s", decoder->as_json ? "}" : "");
    list->left--;
    if ((list->left > 0U) && !decoder->reader.failed && !decoder->is_cut) {
        put(decoder, decoder->as_json ? "," : ", ");
        open_entry(decoder);
        return list->body;
    }
    put(decoder, "]");
    decoder->needs_glue = true;
    decoder->depth--;
    return next;
}

/// Copy the characters up to one of `ends`, or up to the end of the text. Returns the text after the
/// separator.
static const char* take_word(const char* from, const char* const ends, char* const word, char* const out_end)
{
    size_t length = 0U;
    while ((*from != '\0') && (strchr(ends, *from) == NULL) && (length < (WORD_MAX - 1U))) {
        word[length] = *from;
        length++;
        from++;
    }
    word[length] = '\0';
    *out_end     = *from;
    return (*from != '\0') ? (from + 1) : from;
}

bool dump_fields(const char* const layout, const uint8_t* const data, const size_t size, const bool as_json,
                 char* const text, const size_t capacity)
{
    decoder_t decoder = {
        .reader = octet_reader(data, size), .as_json = as_json, .text = text, .capacity = capacity};
    const char* next = layout;
    text[0]          = '\0';
    put(&decoder, "%s", as_json ? "{" : "");
    while ((*next != '\0') && !decoder.reader.failed && !decoder.is_cut) {
        char name[WORD_MAX];
        char type[WORD_MAX];
        char end = '\0';
        next     = take_word(next, ":[ ", name, &end);
        if (strcmp(name, "]") == 0) {
            next = close_entry(&decoder, next);
        } else {
            const bool is_list = (end == '[');
            next               = take_word(next, " ", type, &end);
            if (is_list) {
                next = open_list(&decoder, name, type, next);
            } else {
                put_value(&decoder, name, type);
            }
        }
    }
    put(&decoder, "%s", as_json ? "}" : "");
    return octet_reader_is_done(&decoder.reader) && !decoder.is_cut;
}
