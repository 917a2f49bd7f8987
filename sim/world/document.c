// SPDX-License-Identifier: Apache-2.0
#include "sim/world/document.h"

#include <errno.h>
#include <expat.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PIECE_OCTETS 4096
#define EXPECTED_MAX 200U
#define TIME_DIGITS_MAX 9U // As in descriptors.

typedef struct {
    const char* path;
    const document_handler_t* handler;
    XML_Parser parser;
    char* error;
    status_t status;
    unsigned depth;
    unsigned skipped_depth; // 0: nothing is skipped.
} document_reader_t;

// ---- Errors ----

status_t document_refuse(const char* const path, const unsigned line, const char* const found,
                         const char* const expected, char error[DOCUMENT_ERROR_MAX])
{
    (void)snprintf(error, DOCUMENT_ERROR_MAX, "%.100s:%u: found '%.48s', expected %.120s", path, line, found,
                   expected);
    return STATUS_INVALID;
}

status_t element_refuse(const element_t* const element, const char* const found, const char* const expected)
{
    return document_refuse(element->path, element->line, found, expected, element->error);
}

static status_t refuse_attribute(const element_t* const element, const char* const name,
                                 const char* const value, const char* const expected)
{
    char found[DOCUMENT_TEXT_MAX];
    (void)snprintf(found, sizeof found, "%.24s=\"%.30s\"", name, value);
    return element_refuse(element, found, expected);
}

// ---- Elements ----

static element_t element_here(const document_reader_t* const reader, const char* const name,
                              const char* const* const attributes)
{
    return (element_t){.path       = reader->path,
                       .line       = (unsigned)XML_GetCurrentLineNumber(reader->parser),
                       .depth      = reader->depth,
                       .name       = name,
                       .attributes = attributes,
                       .error      = reader->error};
}

/// Keep the first error, which ends the reading.
static void note_status(document_reader_t* const reader, const status_t status)
{
    if ((reader->status == STATUS_OK) && (status != STATUS_OK)) {
        reader->status = status;
        (void)XML_StopParser(reader->parser, XML_FALSE);
    }
}

static void XMLCALL on_start(void* const context, const XML_Char* const name,
                             const XML_Char** const attributes)
{
    document_reader_t* reader = context;
    bool is_skipped           = false;
    reader->depth++;
    if (reader->skipped_depth != 0U) {
        return;
    }
    const element_t element = element_here(reader, name, (const char* const*)attributes);
    if (reader->depth > DOCUMENT_DEPTH_MAX) {
        note_status(reader, element_refuse(&element, name, "at most 16 levels of elements"));
        return;
    }
    note_status(reader, reader->handler->start(reader->handler->context, &element, &is_skipped));
    reader->skipped_depth = is_skipped ? reader->depth : 0U;
}

static void XMLCALL on_end(void* const context, const XML_Char* const name)
{
    static const char* const none[] = {NULL};
    document_reader_t* reader       = context;
    if (reader->status != STATUS_OK) {
        return; // The parser still reports the end of the empty element that was refused.
    }
    if (reader->skipped_depth == 0U) {
        const element_t element = element_here(reader, name, none);
        note_status(reader, reader->handler->end(reader->handler->context, &element));
    } else if (reader->skipped_depth == reader->depth) {
        reader->skipped_depth = 0U;
    } else {
        // The element is inside a skipped element.
    }
    reader->depth--;
}

static void XMLCALL on_text(void* const context, const XML_Char* const text, const int length)
{
    document_reader_t* reader = context;
    for (int i = 0; (i < length) && (reader->skipped_depth == 0U); i++) {
        if (strchr(" \t\r\n", text[i]) == NULL) {
            const char found[2]     = {text[i], '\0'};
            const element_t element = element_here(reader, "", NULL);
            note_status(reader, element_refuse(&element, found, "no text between elements"));
            return;
        }
    }
}

static void XMLCALL on_doctype(void* const context, const XML_Char* const name,
                               const XML_Char* const system_id, const XML_Char* const public_id,
                               const int has_internal)
{
    document_reader_t* reader = context;
    const element_t element   = element_here(reader, "", NULL);
    (void)system_id;
    (void)public_id;
    (void)has_internal;
    note_status(reader, element_refuse(&element, name, "no document type declaration"));
}

// ---- The file ----

static void feed(document_reader_t* const reader, FILE* const file)
{
    char piece[PIECE_OCTETS];
    size_t octets = 0U;
    bool is_last  = false;
    while ((reader->status == STATUS_OK) && !is_last) {
        const size_t count = fread(piece, 1U, sizeof piece, file);
        octets += count;
        is_last = count < sizeof piece;
        if ((ferror(file) != 0) || (octets > DOCUMENT_OCTETS_MAX)) {
            (void)snprintf(reader->error, DOCUMENT_ERROR_MAX,
                           "%.200s: expected a readable file of at most %u octets", reader->path,
                           DOCUMENT_OCTETS_MAX);
            reader->status = STATUS_TOO_LARGE;
        } else if ((XML_Parse(reader->parser, piece, (int)count, is_last ? 1 : 0) != XML_STATUS_OK) &&
                   (reader->status == STATUS_OK)) {
            reader->status = document_refuse(reader->path, (unsigned)XML_GetCurrentLineNumber(reader->parser),
                                             XML_ErrorString(XML_GetErrorCode(reader->parser)),
                                             "well-formed XML", reader->error);
        } else {
            // The parser has accepted the piece.
        }
    }
}

status_t document_read(const char* const path, const document_handler_t* const handler,
                       char error[DOCUMENT_ERROR_MAX])
{
    document_reader_t reader = {.path = path, .handler = handler, .error = error};
    error[0]                 = '\0';
    FILE* file               = fopen(path, "r");
    if (file == NULL) {
        (void)snprintf(error, DOCUMENT_ERROR_MAX, "%.200s: %s", path, strerror(errno));
        return STATUS_NOT_FOUND;
    }
    reader.parser = XML_ParserCreate("UTF-8");
    if (reader.parser == NULL) {
        (void)snprintf(error, DOCUMENT_ERROR_MAX, "%.200s: out of memory", path);
        reader.status = STATUS_EXHAUSTED;
    } else {
        XML_SetUserData(reader.parser, &reader);
        XML_SetElementHandler(reader.parser, on_start, on_end);
        XML_SetCharacterDataHandler(reader.parser, on_text);
        XML_SetStartDoctypeDeclHandler(reader.parser, on_doctype);
        feed(&reader, file);
        XML_ParserFree(reader.parser);
    }
    (void)fclose(file);
    return reader.status;
}

// ---- Attributes ----

const char* element_attribute(const element_t* const element, const char* const name)
{
    for (size_t i = 0U; element->attributes[i] != NULL; i += 2U) {
        if (strcmp(element->attributes[i], name) == 0) {
            return element->attributes[i + 1U];
        }
    }
    return NULL;
}

/// Read the decimal number at the beginning of `text`, and return its end. Null: `text` does not begin with a
/// finite decimal number.
static const char* scan_number(const char* const text, double* const out_value)
{
    char* end    = NULL;
    *out_value   = strtod(text, &end);
    size_t count = strspn(text, "0123456789+-.eE");
    return ((end != text) && ((size_t)(end - text) <= count)) ? end : NULL;
}

static bool is_inside(const double value, const double low, const double high)
{
    return (value >= low) && (value <= high); // False for NaN.
}

bool document_number(const char* const text, const double low, const double high, double* const out_value)
{
    const char* end = scan_number(text, out_value);
    return (end != NULL) && (*end == '\0') && is_inside(*out_value, low, high);
}

static bool take_text(const char* const value, const bool is_name, char* const out_text)
{
    static const char* const letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz";
    const size_t length              = strlen(value);
    if ((length == 0U) || (length >= DOCUMENT_TEXT_MAX)) {
        return false;
    }
    for (size_t i = 0U; is_name && (i < length); i++) {
        const bool is_letter = strchr(letters, value[i]) != NULL;
        if (!is_letter && ((i == 0U) || (strchr("0123456789_-", value[i]) == NULL))) {
            return false;
        }
    }
    memcpy(out_text, value, length + 1U);
    return true;
}

static bool take_vector(const char* const value, const field_t* const field,
                        double out_vector[DOCUMENT_VECTOR_MAX])
{
    const char* next = value;
    for (unsigned i = 0U; i < DOCUMENT_VECTOR_MAX; i++) {
        next += strspn(next, " \t\n");
        next = scan_number(next, &out_vector[i]);
        if ((next == NULL) || !is_inside(out_vector[i], field->low, field->high)) {
            return false;
        }
    }
    return next[strspn(next, " \t\n")] == '\0';
}

static bool take_unsigned(const char* const value, const field_t* const field, unsigned* const out_value)
{
    char* end                  = NULL;
    errno                      = 0;
    const bool is_hexadecimal  = strncmp(value, "0x", 2U) == 0;
    const unsigned long number = strtoul(value, &end, is_hexadecimal ? 16 : 10);
    *out_value                 = (unsigned)number;
    // A zero in front has another meaning in other readers: octal.
    const bool is_clear = is_hexadecimal || (value[0] != '0') || (value[1] == '\0');
    return is_clear && (value[0] >= '0') && (value[0] <= '9') && (*end == '\0') && (errno == 0) &&
           is_inside((double)number, field->low, field->high);
}

static bool take_time(const char* const value, const field_t* const field, double* const out_ns)
{
    static const struct {
        const char* word;
        double ns;
    } units[]          = {{"us", 1e3}, {"ms", 1e6}, {"s", 1e9}};
    const char* end    = &value[strspn(value, "0123456789")];
    const bool is_time = (end != value) && ((size_t)(end - value) <= TIME_DIGITS_MAX);
    *out_ns            = strtod(value, NULL);
    for (size_t i = 0U; (i < (sizeof units / sizeof units[0])) && is_time; i++) {
        if (strcmp(end, units[i].word) == 0) {
            *out_ns *= units[i].ns;
            return is_inside(*out_ns, field->low, field->high);
        }
    }
    return false;
}

static bool take_value(const char* const value, const field_t* const field, void* const record)
{
    void* member = (char*)record + field->offset;
    switch (field->kind) {
    case FIELD_NAME:
    case FIELD_TEXT:
        return take_text(value, field->kind == FIELD_NAME, member);
    case FIELD_NUMBER:
        return document_number(value, field->low, field->high, member);
    case FIELD_VECTOR:
        return take_vector(value, field, member);
    case FIELD_UNSIGNED:
        return take_unsigned(value, field, member);
    case FIELD_TIME:
        break;
    }
    return take_time(value, field, member);
}

static status_t refuse_value(const element_t* const element, const field_t* const field,
                             const char* const value)
{
    static const char* const words[] = {[FIELD_NAME] =
                                            "a name: a letter, then at most 62 letters, digits, _ or -",
                                        [FIELD_TEXT]     = "a text of 1 to 63 octets",
                                        [FIELD_NUMBER]   = "a number",
                                        [FIELD_VECTOR]   = "three numbers",
                                        [FIELD_UNSIGNED] = "a whole number",
                                        [FIELD_TIME]     = "a time in us, ms or s"};
    char expected[EXPECTED_MAX];
    if (field->kind <= FIELD_TEXT) {
        return refuse_attribute(element, field->name, value, words[field->kind]);
    }
    const double unit = (field->kind == FIELD_TIME) ? 1e3 : 1.0;
    (void)snprintf(expected, sizeof expected, "%s from %g to %g%s", words[field->kind], field->low / unit,
                   field->high / unit, (field->kind == FIELD_TIME) ? " us" : "");
    return refuse_attribute(element, field->name, value, expected);
}

static status_t refuse_unknown(const element_t* const element, const field_t* const fields,
                               const size_t count, const size_t attribute)
{
    char expected[EXPECTED_MAX] = "no attribute";
    for (size_t i = 0U; i < count; i++) {
        const size_t used = (i == 0U) ? 0U : strlen(expected);
        (void)snprintf(&expected[used], sizeof expected - used, "%s%s", (i == 0U) ? "" : " ", fields[i].name);
    }
    return refuse_attribute(element, element->attributes[attribute], element->attributes[attribute + 1U],
                            expected);
}

status_t element_take(const element_t* const element, const field_t* const fields, const size_t count,
                      void* const record)
{
    for (size_t i = 0U; element->attributes[i] != NULL; i += 2U) {
        size_t k = 0U;
        while ((k < count) && (strcmp(element->attributes[i], fields[k].name) != 0)) {
            k++;
        }
        if (k == count) {
            return refuse_unknown(element, fields, count, i);
        }
        if (!take_value(element->attributes[i + 1U], &fields[k], record)) {
            return refuse_value(element, &fields[k], element->attributes[i + 1U]);
        }
    }
    for (size_t k = 0U; k < count; k++) {
        if (!fields[k].is_optional && (element_attribute(element, fields[k].name) == NULL)) {
            char expected[EXPECTED_MAX];
            (void)snprintf(expected, sizeof expected, "an attribute %s", fields[k].name);
            return element_refuse(element, element->name, expected);
        }
    }
    return STATUS_OK;
}
