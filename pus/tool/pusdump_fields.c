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

#define DEPTH_MAX 3U // Of lists in lists.
#define WORD_MAX 32U // Characters of a name or type.

/// A list that is being walked.
typedef struct {
    const char* body;
    unsigned left; ///< Remaining entries, the present one included.
} list_t;

typedef struct {
    octet_reader_t reader;
    bool as_json;
    bool needs_glue; ///< There is an earlier item in this list or object.
    char* text;
    size_t capacity;
    size_t length;
    bool is_cut;
    list_t lists[DEPTH_MAX];
    size_t depth;
} walk_t;

static void put(walk_t* const walk, const char* const format, ...) __attribute__((format(printf, 2, 3)));

static void put(walk_t* const walk, const char* const format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int count = vsnprintf(&walk->text[walk->length], walk->capacity - walk->length, format, arguments);
    va_end(arguments);
    if ((count < 0) || ((size_t)count >= (walk->capacity - walk->length))) {
        walk->is_cut             = true;
        walk->text[walk->length] = '\0';
    } else {
        walk->length += (size_t)count;
    }
}

static void put_name(walk_t* const walk, const char* const name)
{
    const char* const glue = walk->as_json ? "," : " ";
    put(walk, walk->as_json ? "%s\"%s\":" : "%s%s=", walk->needs_glue ? glue : "", name);
    walk->needs_glue = true;
}

static void put_hex(walk_t* const walk, const uint8_t* const octets, const size_t size)
{
    put(walk, "%s", walk->as_json ? "\"" : "");
    for (size_t i = 0U; (octets != NULL) && (i < size); i++) {
        put(walk, "%02x", octets[i]);
    }
    put(walk, "%s", walk->as_json ? "\"" : "");
}

/// Text of a name in a packet: characters other than printable ASCII, and quotes, become question marks.
static void put_text(walk_t* const walk, const uint8_t* const octets, const size_t size)
{
    const char* const quote = walk->as_json ? "\"" : "";
    put(walk, "%s", quote);
    for (size_t i = 0U; (octets != NULL) && (i < size) && (octets[i] != 0U); i++) {
        const bool is_plain =
            (octets[i] > 0x20U) && (octets[i] < 0x7FU) && (octets[i] != '"') && (octets[i] != '\\');
        put(walk, "%c", is_plain ? (char)octets[i] : '?');
    }
    put(walk, "%s", quote);
}

static void put_time(walk_t* const walk)
{
    uint8_t p_field  = 0U;
    uint64_t time_ns = 0U;
    if (dump_time_read(&walk->reader, &p_field, &time_ns) != STATUS_OK) {
        walk->reader.failed = true;
    }
    put(walk, walk->as_json ? "%" PRIu64 "%s" : "%" PRIu64 "%s", time_ns, walk->as_json ? "" : "ns");
}

static void put_code(walk_t* const walk)
{
    const uint16_t code = octet_read_u16(&walk->reader);
    if (walk->as_json) {
        put(walk, "%u,\"meaning\":\"%s\"", (unsigned)code, failure_words(code));
    } else {
        put(walk, "0x%04X (%s)", (unsigned)code, failure_words(code));
    }
}

static void put_request_id(walk_t* const walk)
{
    const uint32_t id = octet_read_u32(&walk->reader);
    put(walk, walk->as_json ? "{\"apid\":%u,\"seq\":%u}" : "%u/%u", (unsigned)((id >> 16U) & 0x7FFU),
        (unsigned)(id & 0x3FFFU));
}

static void put_number(walk_t* const walk, const char* const type)
{
    const bool is_hex     = (type[0] == 'x');
    const unsigned digits = (strcmp(&type[1], "8") == 0)    ? 2U
                            : (strcmp(&type[1], "16") == 0) ? 4U
                            : (strcmp(&type[1], "32") == 0) ? 8U
                                                            : 16U;
    uint64_t value        = 0U;
    for (unsigned i = 0U; i < (digits / 2U); i++) {
        value = (value << 8U) | octet_read_u8(&walk->reader);
    }
    if (is_hex) {
        put(walk, walk->as_json ? "\"0x%0*" PRIX64 "\"" : "0x%0*" PRIX64, (int)digits, value);
    } else {
        put(walk, "%" PRIu64, value);
    }
}

static void put_value(walk_t* const walk, const char* const name, const char* const type)
{
    put_name(walk, name);
    if (strcmp(type, "code") == 0) {
        put_code(walk);
    } else if (strcmp(type, "id") == 0) {
        put_request_id(walk);
    } else if (strcmp(type, "time") == 0) {
        put_time(walk);
    } else if (strcmp(type, "text") == 0) {
        put_text(walk, octet_read_octets(&walk->reader, PUS_NAME_SIZE), PUS_NAME_SIZE);
    } else if (strcmp(type, "octets") == 0) {
        const uint8_t size = octet_read_u8(&walk->reader);
        put_hex(walk, octet_read_octets(&walk->reader, size), size);
    } else if (strcmp(type, "rest") == 0) {
        const size_t size = octet_reader_left(&walk->reader);
        put_hex(walk, octet_read_octets(&walk->reader, size), size);
    } else {
        put_number(walk, type);
    }
}

/// The item after the list whose body begins at `body`.
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

static void open_entry(walk_t* const walk)
{
    put(walk, "%s", walk->as_json ? "{" : "");
    walk->needs_glue = false;
}

/// Begin a list; returns where the layout continues.
static const char* open_list(walk_t* const walk, const char* const name, const char* const width,
                             const char* const body)
{
    const unsigned count =
        (strcmp(width, "8") == 0) ? octet_read_u8(&walk->reader) : octet_read_u16(&walk->reader);
    put_name(walk, name);
    put(walk, "[");
    if ((count == 0U) || (walk->depth >= DEPTH_MAX)) {
        put(walk, "]");
        return after_list(body);
    }
    walk->lists[walk->depth] = (list_t){.body = body, .left = count};
    walk->depth++;
    open_entry(walk);
    return body;
}

/// End an entry; returns where the layout continues: at the next entry or after the list.
static const char* close_entry(walk_t* const walk, const char* const next)
{
    list_t* const list = &walk->lists[walk->depth - 1U];
    put(walk, "%s", walk->as_json ? "}" : "");
    list->left--;
    if ((list->left > 0U) && !walk->reader.failed && !walk->is_cut) {
        put(walk, walk->as_json ? "," : ", ");
        open_entry(walk);
        return list->body;
    }
    put(walk, "]");
    walk->needs_glue = true;
    walk->depth--;
    return next;
}

/// Copy the characters up to any of `ends` (or the end); returns what follows them, without the separator.
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
    walk_t walk = {
        .reader = octet_reader(data, size), .as_json = as_json, .text = text, .capacity = capacity};
    const char* next = layout;
    text[0]          = '\0';
    put(&walk, "%s", as_json ? "{" : "");
    while ((*next != '\0') && !walk.reader.failed && !walk.is_cut) {
        char name[WORD_MAX];
        char type[WORD_MAX];
        char end = '\0';
        next     = take_word(next, ":[ ", name, &end);
        if (strcmp(name, "]") == 0) {
            next = close_entry(&walk, next);
        } else {
            const bool is_list = (end == '[');
            next               = take_word(next, " ", type, &end);
            if (is_list) {
                next = open_list(&walk, name, type, next);
            } else {
                put_value(&walk, name, type);
            }
        }
    }
    put(&walk, "%s", as_json ? "}" : "");
    return octet_reader_is_done(&walk.reader) && !walk.is_cut;
}
