// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/eds.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define LINE_MAX_OCTETS 512U
#define GROWTH 64U // Number of entries by which an array grows.

// Object codes of CiA 301.
#define OBJECT_TYPE_NULL 0x0
#define OBJECT_TYPE_DOMAIN 0x2
#define OBJECT_TYPE_DEFTYPE 0x5
#define OBJECT_TYPE_DEFSTRUCT 0x6
#define OBJECT_TYPE_VAR 0x7
#define OBJECT_TYPE_RECORD 0x9
#define SUBINDEX_MAX 0xFE   // Last sub-index of a member.
#define DATA_TYPE_MAX 0x25F // Last data type of device profiles in the object dictionary of CiA 301.

/// A section of the file that describes an object; the keys that have been read so far.
typedef struct {
    bool is_open;
    unsigned line;
    bool has_subindex;
    bool has_name;
    bool has_type;
    bool has_access;
    uint8_t compact;  // CompactSubObj: number of members that have no section of their own.
    bool is_left_out; // Of a type that CiA 301 defines and simulated devices do not have.
    long object_type;
    unsigned default_line;
    char default_value[LINE_MAX_OCTETS];
    char name[OBJECT_NAME_MAX];
    object_t object;
} section_t;

typedef struct {
    const char* path;
    unsigned line;
    uint8_t node_id;
    dictionary_t* dictionary;
    size_t capacity;
    size_t name_capacity;
    char* error;
    section_t section;
} eds_reader_t;

static status_t fail(const eds_reader_t* const reader, const unsigned line, const char* const found,
                     const char* const expected)
{
    (void)snprintf(reader->error, EDS_ERROR_MAX, "%s:%u: found '%.60s', expected %s", reader->path, line,
                   found, expected);
    return STATUS_INVALID;
}

static char* trimmed(char* text)
{
    while (isspace((unsigned char)*text)) {
        text++;
    }
    size_t length = strlen(text);
    while ((length > 0U) && isspace((unsigned char)text[length - 1U])) {
        length--;
    }
    text[length] = '\0';
    return text;
}

/// Read a term: a decimal or hexadecimal number, or $NODEID.
static bool parse_term(const eds_reader_t* const reader, const char* const text, const size_t length,
                       int64_t* const out_value)
{
    char term[32];
    if ((length == 0U) || (length >= sizeof term)) {
        return false;
    }
    memcpy(term, text, length);
    term[length] = '\0';
    char* start  = trimmed(term);
    if (strcasecmp(start, "$NODEID") == 0) {
        *out_value = reader->node_id;
        return true;
    }
    char* end = NULL;
    errno     = 0;
    // Base 0 accepts a leading 0x. It would read a leading 0 as octal: no EDS file of this project has one.
    if (start[0] == '-') {
        *out_value = strtoll(start, &end, 0);
    } else {
        *out_value = (int64_t)strtoull(start, &end, 0);
    }
    return (errno == 0) && (end != start) && (*end == '\0');
}

static bool parse_number(const eds_reader_t* const reader, const char* const text, int64_t* const out_value)
{
    const char* plus = strchr(text, '+');
    if (plus == NULL) {
        return parse_term(reader, text, strlen(text), out_value);
    }
    int64_t left  = 0;
    int64_t right = 0;
    if (!parse_term(reader, text, (size_t)(plus - text), &left) ||
        !parse_term(reader, plus + 1, strlen(plus + 1), &right)) {
        return false;
    }
    *out_value = left + right;
    return true;
}

static bool fits(const object_t* const object, const int64_t value)
{
    if (object->size == 8U) {
        return true;
    }
    if (object->type == OBJECT_BOOLEAN) {
        return (value == 0) || (value == 1);
    }
    const unsigned bits = 8U * object->size;
    if (object_is_signed(object)) {
        const int64_t limit = (int64_t)1 << (bits - 1U);
        return (value >= -limit) && (value < limit);
    }
    return (value >= 0) && (value < ((int64_t)1 << bits));
}

/// Value of a hexadecimal number in the type of an object: makers write negative numbers as their two's
/// complement.
static int64_t in_type(const object_t* const object, const int64_t value)
{
    const unsigned bits = 8U * object->size;
    if (!object_is_signed(object) || (bits >= 64U) || (value < ((int64_t)1 << (bits - 1U))) ||
        (value >= ((int64_t)1 << bits))) {
        return value;
    }
    return value - ((int64_t)1 << bits);
}

/// Parse a real number. False if it is not finite.
static bool parse_real(const char* const text, double* const out_value)
{
    char* end  = NULL;
    *out_value = strtod(text, &end);
    // strtod also reads inf, nan and hexadecimal numbers, which CiA 306 does not have.
    return (end != text) && (*end == '\0') && isfinite(*out_value) && (strpbrk(text, "xXnN") == NULL);
}

/// Set the default of a REAL32 or REAL64.
static status_t set_real_default(const eds_reader_t* const reader, section_t* const section)
{
    object_t* object = &section->object;
    double value     = 0.0;
    if ((section->default_value[0] != '\0') && !parse_real(section->default_value, &value)) {
        return fail(reader, section->default_line, section->default_value, "a finite number as DefaultValue");
    }
    object_set_real(object, value);
    object->initial = object->value;
    if (!isfinite(object_real(object)) || (object->has_low && (value < object->real_low)) ||
        (object->has_high && (value > object->real_high))) {
        return fail(reader, section->default_line, section->default_value,
                    "a DefaultValue inside DataType, LowLimit and HighLimit");
    }
    return STATUS_OK;
}

static status_t set_default(const eds_reader_t* const reader, section_t* const section)
{
    object_t* object = &section->object;
    if (object_is_text(object)) {
        const size_t length = strlen(section->default_value);
        if (length > OBJECT_TEXT_MAX) {
            return fail(reader, section->default_line, section->default_value, "at most 64 characters");
        }
        memcpy(object->initial_text, section->default_value, length);
        object->initial_size = (uint8_t)length;
        object->size         = (uint8_t)length;
        return STATUS_OK;
    }
    if (object_is_real(object)) {
        return set_real_default(reader, section);
    }
    int64_t value = 0;
    if ((section->default_value[0] != '\0') && !parse_number(reader, section->default_value, &value)) {
        return fail(reader, section->default_line, section->default_value, "a number as DefaultValue");
    }
    value        = (strpbrk(section->default_value, "xX") != NULL) ? in_type(object, value) : value;
    object->low  = in_type(object, object->low);
    object->high = in_type(object, object->high);
    if (!fits(object, value) || (object->has_low && (value < object->low)) ||
        (object->has_high && (value > object->high))) {
        return fail(reader, section->default_line, section->default_value,
                    "a DefaultValue inside DataType, LowLimit and HighLimit");
    }
    object_set(object, value);
    object->initial = object->value;
    return STATUS_OK;
}

static status_t append(eds_reader_t* const reader, const object_t* const object)
{
    dictionary_t* dictionary = reader->dictionary;
    if (dictionary->count == reader->capacity) {
        object_t* grown = realloc(dictionary->objects, (reader->capacity + GROWTH) * sizeof *grown);
        if (grown == NULL) {
            (void)snprintf(reader->error, EDS_ERROR_MAX, "%s: out of memory", reader->path);
            return STATUS_EXHAUSTED;
        }
        dictionary->objects = grown;
        reader->capacity += GROWTH;
    }
    dictionary->objects[dictionary->count] = *object;
    if (object_is_text(object)) {
        uint8_t* text = calloc(1U, OBJECT_TEXT_MAX);
        if (text == NULL) {
            (void)snprintf(reader->error, EDS_ERROR_MAX, "%s: out of memory", reader->path);
            return STATUS_EXHAUSTED;
        }
        memcpy(text, object->initial_text, OBJECT_TEXT_MAX);
        dictionary->objects[dictionary->count].text = text;
    }
    dictionary->count++;
    return STATUS_OK;
}

static status_t append_name(eds_reader_t* const reader, const section_t* const section)
{
    dictionary_t* dictionary = reader->dictionary;
    if (dictionary->name_count == reader->name_capacity) {
        object_name_t* grown = realloc(dictionary->names, (reader->name_capacity + GROWTH) * sizeof *grown);
        if (grown == NULL) {
            (void)snprintf(reader->error, EDS_ERROR_MAX, "%s: out of memory", reader->path);
            return STATUS_EXHAUSTED;
        }
        dictionary->names = grown;
        reader->name_capacity += GROWTH;
    }
    object_name_t* name = &dictionary->names[dictionary->name_count];
    name->index         = section->object.index;
    memcpy(name->name, section->name, sizeof name->name);
    dictionary->name_count++;
    return STATUS_OK;
}

/// Add the members that CompactSubObj describes: sub-index 0 with their number, the others with the type,
/// access and default of the section (CiA 306).
static status_t append_members(eds_reader_t* const reader, section_t* const section)
{
    const object_t count = {.index       = section->object.index,
                            .type        = OBJECT_UNSIGNED8,
                            .size        = 1U,
                            .is_readable = true,
                            .value       = section->compact,
                            .initial     = section->compact};
    status_t status      = append(reader, &count);
    for (unsigned i = 1U; (i <= section->compact) && !section->is_left_out && (status == STATUS_OK); i++) {
        section->object.subindex = (uint8_t)i;
        status                   = set_default(reader, section);
        status                   = (status == STATUS_OK) ? append(reader, &section->object) : status;
    }
    return status;
}

/// At the end of a section, add its object to the dictionary.
static status_t close_section(eds_reader_t* const reader)
{
    section_t* section = &reader->section;
    if (!section->is_open) {
        return STATUS_OK;
    }
    section->is_open = false;
    if (!section->has_name) {
        return fail(reader, section->line, "no name", "ParameterName in this section");
    }
    // Head of an array or record; its members have sections of their own.
    const bool is_head = !section->has_subindex && (section->object_type > OBJECT_TYPE_VAR);
    if (section->is_left_out && !is_head) {
        return STATUS_OK;
    }
    if (!section->has_subindex && (append_name(reader, section) != STATUS_OK)) {
        return STATUS_EXHAUSTED;
    }
    if (is_head && (section->compact == 0U)) {
        return STATUS_OK;
    }
    if (!section->has_type) {
        return fail(reader, section->line, "no type", "DataType in this section");
    }
    if (!section->has_access) {
        return fail(reader, section->line, "no access", "AccessType in this section");
    }
    if (is_head) {
        return append_members(reader, section);
    }
    status_t status = set_default(reader, section);
    if (status == STATUS_OK) {
        status = append(reader, &section->object);
    }
    return status;
}

/// Parse the name of an object's section: four hexadecimal digits, optionally "sub" and one or two digits.
static bool parse_section_name(const char* const name, object_t* const out_object,
                               bool* const out_has_subindex)
{
    for (unsigned i = 0U; i < 4U; i++) {
        if (!isxdigit((unsigned char)name[i])) {
            return false;
        }
    }
    out_object->index = (uint16_t)strtoul((char[]){name[0], name[1], name[2], name[3], '\0'}, NULL, 16);
    *out_has_subindex = name[4] != '\0';
    if (!*out_has_subindex) {
        return true;
    }
    char* end = NULL;
    if ((strncasecmp(&name[4], "sub", 3U) != 0) || !isxdigit((unsigned char)name[7])) {
        return false;
    }
    const unsigned long subindex = strtoul(&name[7], &end, 16);
    out_object->subindex         = (uint8_t)subindex;
    return (*end == '\0') && (subindex <= SUBINDEX_MAX);
}

static status_t open_section(eds_reader_t* const reader, char* const text)
{
    char* end = strchr(text, ']');
    if (end == NULL) {
        return fail(reader, reader->line, text, "']' at the end of the section's name");
    }
    *end            = '\0';
    status_t status = close_section(reader);
    if ((status == STATUS_OK) && (strlen(text) == strlen("[1003Value")) &&
        (strcasecmp(&text[strlen("[1003")], "Value") == 0)) {
        return fail(reader, reader->line, text + 1,
                    "the values of CompactSubObj as DefaultValue in a section for each sub-object");
    }
    if (status == STATUS_OK) {
        section_t* section = &reader->section;
        memset(section, 0, sizeof *section);
        section->object_type = OBJECT_TYPE_VAR;
        section->line        = reader->line;
        section->is_open     = parse_section_name(text + 1, &section->object, &section->has_subindex);
    }
    return status;
}

static status_t take_type(const eds_reader_t* const reader, section_t* const section, const char* const value,
                          const int64_t number)
{
    if ((number < 1) || (number > DATA_TYPE_MAX)) {
        return fail(reader, reader->line, value, "a DataType from 0x1 to 0x25F");
    }
    section->object.type = (object_type_t)number;
    section->object.size = object_type_size(section->object.type);
    section->has_type    = true;
    section->is_left_out =
        section->is_left_out || ((section->object.size == 0U) && !object_is_text(&section->object));
    return STATUS_OK;
}

static status_t take_access(const eds_reader_t* const reader, section_t* const section,
                            const char* const value)
{
    static const char* const names[] = {"ro", "const", "rw", "rww", "rwr", "wo"};
    size_t i                         = 0U;
    while ((i < 6U) && (strcasecmp(value, names[i]) != 0)) {
        i++;
    }
    if (i == 6U) {
        return fail(reader, reader->line, value, "AccessType ro, const, rw, rww, rwr or wo");
    }
    section->object.is_readable = i <= 4U;
    section->object.is_writable = i >= 2U;
    section->has_access         = true;
    return STATUS_OK;
}

static status_t take_object_type(const eds_reader_t* const reader, section_t* const section,
                                 const char* const value, const int64_t number)
{
    const bool is_known  = (number >= OBJECT_TYPE_VAR) && (number <= OBJECT_TYPE_RECORD);
    section->object_type = number;
    section->is_left_out = section->is_left_out || !is_known;
    if (!is_known && (number != OBJECT_TYPE_NULL) && (number != OBJECT_TYPE_DOMAIN) &&
        (number != OBJECT_TYPE_DEFTYPE) && (number != OBJECT_TYPE_DEFSTRUCT)) {
        return fail(reader, reader->line, value, "an ObjectType of CiA 301: 0x0, 0x2 or 0x5 to 0x9");
    }
    return STATUS_OK;
}

/// Take a limit of a REAL32 or REAL64.
static status_t take_real_limit(const eds_reader_t* const reader, section_t* const section,
                                const char* const key, const char* const value)
{
    object_t* object  = &section->object;
    const bool is_low = strcasecmp(key, "LowLimit") == 0;
    if (!parse_real(value, is_low ? &object->real_low : &object->real_high)) {
        return fail(reader, reader->line, value, "a finite number");
    }
    object->has_low  = object->has_low || is_low;
    object->has_high = object->has_high || !is_low;
    return STATUS_OK;
}

static status_t take_number(const eds_reader_t* const reader, section_t* const section, const char* const key,
                            const char* const value)
{
    int64_t number   = 0;
    object_t* object = &section->object;
    if ((value[0] == '\0') || section->is_left_out) {
        return STATUS_OK; // No value. An object that is left out may have limits of any kind.
    }
    if (object_is_real(object) &&
        ((strcasecmp(key, "LowLimit") == 0) || (strcasecmp(key, "HighLimit") == 0))) {
        return take_real_limit(reader, section, key, value);
    }
    if (!parse_number(reader, value, &number)) {
        return fail(reader, reader->line, value, "a number");
    }
    if (strcasecmp(key, "ObjectType") == 0) {
        return take_object_type(reader, section, value, number);
    } else if (strcasecmp(key, "DataType") == 0) {
        return take_type(reader, section, value, number);
    } else if (strcasecmp(key, "CompactSubObj") == 0) {
        if ((number < 0) || (number > SUBINDEX_MAX)) {
            return fail(reader, reader->line, value, "a number of sub-objects from 0 to 254");
        }
        section->compact = (uint8_t)number;
    } else if (strcasecmp(key, "PDOMapping") == 0) {
        object->is_mappable = number != 0;
    } else if (strcasecmp(key, "LowLimit") == 0) {
        object->has_low = true;
        object->low     = number;
    } else {
        object->has_high = true;
        object->high     = number;
    }
    return STATUS_OK;
}

static status_t take_entry(eds_reader_t* const reader, char* const text)
{
    section_t* section = &reader->section;
    char* equals       = strchr(text, '=');
    if (equals == NULL) {
        return fail(reader, reader->line, text, "key=value, [section] or ; comment");
    }
    *equals           = '\0';
    const char* key   = trimmed(text);
    const char* value = trimmed(equals + 1);
    if (!section->is_open) {
        return STATUS_OK;
    }
    if (strcasecmp(key, "ParameterName") == 0) {
        section->has_name = value[0] != '\0';
        (void)snprintf(section->name, sizeof section->name, "%.*s", (int)sizeof section->name - 1, value);
    } else if (strcasecmp(key, "AccessType") == 0) {
        return take_access(reader, section, value);
    } else if (strcasecmp(key, "DefaultValue") == 0) {
        section->default_line = reader->line;
        (void)snprintf(section->default_value, sizeof section->default_value, "%s", value);
    } else if ((strcasecmp(key, "ObjectType") == 0) || (strcasecmp(key, "DataType") == 0) ||
               (strcasecmp(key, "PDOMapping") == 0) || (strcasecmp(key, "CompactSubObj") == 0) ||
               (strcasecmp(key, "LowLimit") == 0) || (strcasecmp(key, "HighLimit") == 0)) {
        return take_number(reader, section, key, value);
    }
    return STATUS_OK;
}

static status_t read_lines(eds_reader_t* const reader, FILE* const file)
{
    char line[LINE_MAX_OCTETS];
    status_t status = STATUS_OK;
    while ((status == STATUS_OK) && (fgets(line, (int)sizeof line, file) != NULL)) {
        reader->line++;
        if ((reader->line == 1U) && (strncmp(line, "\xEF\xBB\xBF", 3U) == 0)) { // Byte order mark of UTF-8.
            memmove(line, &line[3], strlen(&line[3]) + 1U);
        }
        if ((strchr(line, '\n') == NULL) && !feof(file)) {
            return fail(reader, reader->line, line, "a line of at most 510 characters");
        }
        char* text = trimmed(line);
        if ((text[0] == '\0') || (text[0] == ';') || (text[0] == '#')) {
            continue;
        }
        status = (text[0] == '[') ? open_section(reader, text) : take_entry(reader, text);
    }
    return (status == STATUS_OK) ? close_section(reader) : status;
}

static int compare_objects(const void* const left, const void* const right)
{
    const object_t* a = left;
    const object_t* b = right;
    const int key_a   = (a->index << 8) | a->subindex;
    const int key_b   = (b->index << 8) | b->subindex;
    return (key_a > key_b) - (key_a < key_b);
}

static status_t check_unique(const eds_reader_t* const reader)
{
    const dictionary_t* dictionary = reader->dictionary;
    for (size_t i = 1U; i < dictionary->count; i++) {
        if (compare_objects(&dictionary->objects[i - 1U], &dictionary->objects[i]) == 0) {
            (void)snprintf(reader->error, EDS_ERROR_MAX,
                           "%s: object %04X:%02X is described twice; remove one", reader->path,
                           dictionary->objects[i].index, dictionary->objects[i].subindex);
            return STATUS_INVALID;
        }
    }
    if (dictionary->count == 0U) {
        (void)snprintf(reader->error, EDS_ERROR_MAX, "%s: describes no object; is it an EDS file?",
                       reader->path);
        return STATUS_INVALID;
    }
    return STATUS_OK;
}

status_t eds_load(const char* const path, const uint8_t node_id, dictionary_t* const out_dictionary,
                  char error[EDS_ERROR_MAX])
{
    *out_dictionary = (dictionary_t){0};
    FILE* file      = fopen(path, "r");
    if (file == NULL) {
        (void)snprintf(error, EDS_ERROR_MAX,
                       "%.200s: cannot be read (%s), expected a data sheet; run from the project's root",
                       path, strerror(errno));
        return STATUS_NOT_FOUND;
    }
    eds_reader_t reader = {.path = path, .node_id = node_id, .dictionary = out_dictionary, .error = error};
    status_t status     = read_lines(&reader, file);
    (void)fclose(file);
    if ((status == STATUS_OK) && (out_dictionary->count != 0U)) {
        qsort(out_dictionary->objects, out_dictionary->count, sizeof(object_t), compare_objects);
    }
    if (status == STATUS_OK) {
        status = check_unique(&reader);
    }
    if (status != STATUS_OK) {
        dictionary_destroy(out_dictionary);
    }
    return status;
}
