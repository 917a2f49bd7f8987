// SPDX-License-Identifier: Apache-2.0
// Elements, lists, hash and errors. source_value.c reads the values of attributes.
#include "fsw/framework/descriptor/source.h"

#include "base/assertion.h"
#include "base/crc.h"

#include <string.h>

// ---- Errors ----

void descriptor_source_append(source_t* const source, const char* const pattern, const char* const one,
                              const char* const other, const uint32_t number)
{
    if (source->is_reporting) {
        text_add_pattern(source->error, pattern, one, other, number);
    }
}

void descriptor_source_refuse(source_t* const source, const uint32_t line, const char* const pattern,
                              const char* const one, const char* const other, const uint32_t number)
{
    // Only the first error of a file is reported.
    source->is_reporting = (source->status == STATUS_OK);
    if (source->is_reporting) {
        source->status = STATUS_INVALID;
    }
    descriptor_source_append(source, "%:#: ", source->path, NULL, line);
    descriptor_source_append(source, pattern, one, other, number);
}

void descriptor_source_fail(source_t* const source, const uint32_t line, const char* const message)
{
    descriptor_source_refuse(source, line, "%", message, NULL, 0U);
}

void descriptor_source_fail_as(source_t* const source, const uint32_t line, const status_t status,
                               const char* const message)
{
    descriptor_source_fail(source, line, message);
    if (source->is_reporting) {
        source->status = status;
    }
}

void descriptor_source_wrong(source_t* const source, const char* const attribute, const char* const expected)
{
    const char* const value = descriptor_source_raw(source, attribute);
    FSW_ASSERT(value != NULL);
    descriptor_source_refuse(source, source->line, "%=\"%\" of <", attribute, value, 0U);
    descriptor_source_append(source, "%>: expected %", source->open[source->depth - 1U]->name, expected, 0U);
}

void descriptor_source_taken(source_t* const source, const char* const attribute, const char* const value,
                             const uint32_t line)
{
    descriptor_source_refuse(source, source->line, "% % is taken in line #", attribute, value, line);
}

/// Append "<what>, at most <most>" to the error text.
static void add_limit(source_t* const source, const char* const what, const uint32_t most)
{
    descriptor_source_append(source, "%, at most #", what, NULL, most);
}

void descriptor_source_limit(source_t* const source, const uint32_t octets, const uint32_t most,
                             const char* const what)
{
    if (octets > most) {
        descriptor_source_refuse(source, source->line, "#", NULL, NULL, octets);
        add_limit(source, what, most);
    }
}

bool descriptor_source_has_room(source_t* const source, const uint32_t count, const uint32_t capacity,
                                const char* const what)
{
    if (count >= capacity) {
        descriptor_source_fail_as(source, source->line, STATUS_EXHAUSTED, "too many ");
        add_limit(source, what, capacity);
    }
    return (source->status == STATUS_OK);
}

// ---- Hash ----

static void hash_words(source_t* const source, const char* const words)
{
    source->hash = fnv64(source->hash, (const uint8_t*)words, strlen(words));
}

/// Add the attributes to the hash in the order of their names. Repeated selection is fast enough, because
/// an element has few attributes.
static void hash_attributes(source_t* const source, const xml_element_t* const element)
{
    const char* before = ""; // The empty string precedes every name.
    for (;;) {
        const char* const* next = NULL;
        for (size_t i = 0U; element->attributes[i] != NULL; i += 2U) {
            const char* const name = element->attributes[i];
            if ((strcmp(name, before) > 0) && ((next == NULL) || (strcmp(name, next[0]) < 0))) {
                next = &element->attributes[i];
            }
        }
        if (next == NULL) {
            return;
        }
        hash_words(source, next[0]);
        hash_words(source, "=");
        hash_words(source, next[1]);
        hash_words(source, "\n");
        before = next[0];
    }
}

// ---- Lists ----

/// Returns the address of a counter in the model or in an item.
static uint16_t* count_at(void* const base, const uint32_t offset)
{
    return (uint16_t*)(void*)((uint8_t*)base + offset);
}

void* descriptor_source_add(source_t* const source, const source_list_t* const list, void* const around)
{
    uint16_t* const count = count_at(source->items[0], list->count);
    if (!descriptor_source_has_room(source, *count, list->capacity, list->what)) {
        return NULL;
    }
    uint8_t* const item = (uint8_t*)source->items[0] + list->items + ((size_t)*count * list->size);
    (void)memset(item, 0, list->size);
    source->order = *count;
    if (list->number != 0U) {
        uint16_t* const number = count_at(around, list->number);
        source->order          = *number;
        if (*number == 0U) {
            *count_at(around, list->first) = *count;
        }
        (*number)++;
    }
    (*count)++;
    if (list->line != 0U) {
        (void)memcpy(&item[list->line], &source->line, sizeof source->line);
    }
    return item;
}

void descriptor_source_names(const source_t* const source, const source_list_t* const list,
                             text_t* const out_words)
{
    const uint16_t count = *count_at(source->items[0], list->count);
    for (uint16_t i = 0U; i < count; i++) {
        const char* name = NULL;
        (void)memcpy(&name, (const uint8_t*)source->items[0] + list->items + ((size_t)i * list->size),
                     sizeof name);
        text_add(out_words, (i > 0U) ? " " : "");
        text_add(out_words, name);
    }
}

/// True if two items have the same value of an attribute.
static bool is_same(const uint8_t* const one, const uint8_t* const other,
                    const source_attribute_t* const attribute)
{
    const char* name       = NULL;
    const char* other_name = NULL;
    if ((attribute->form & SOURCE_FORMS) > SOURCE_TEXT) {
        return memcmp(&one[attribute->member], &other[attribute->member], attribute->width) == 0;
    }
    (void)memcpy(&name, &one[attribute->member], sizeof name);
    (void)memcpy(&other_name, &other[attribute->member], sizeof other_name);
    return strcmp(name, other_name) == 0;
}

void* descriptor_source_item(source_t* const source, const source_list_t* const list, void* const around,
                             const source_attribute_t* const attributes, const size_t number)
{
    uint8_t* const item = descriptor_source_add(source, list, around);
    if (item == NULL) {
        return NULL;
    }
    descriptor_source_read(source, item, attributes, number);
    for (size_t back = source->order; back > 0U; back--) {
        const uint8_t* const other = item - (back * list->size);
        for (size_t i = 0U; i < number; i++) {
            if (((attributes[i].form & SOURCE_UNIQUE) != 0U) && is_same(item, other, &attributes[i])) {
                uint32_t line = 0U;
                (void)memcpy(&line, &other[list->line], sizeof line);
                descriptor_source_taken(source, attributes[i].name,
                                        descriptor_source_raw(source, attributes[i].name), line);
            }
        }
    }
    return (source->status == STATUS_OK) ? item : NULL;
}

// ---- Elements ----

/// Check that every present attribute is known and every required one is present.
static void check_attributes(source_t* const source, const source_row_t* const row,
                             const char* const* const attributes)
{
    for (size_t given = 0U; attributes[given] != NULL; given += 2U) {
        size_t i = 0U;
        while ((i < row->number) && (strcmp(attributes[given], row->attributes[i].name) != 0)) {
            i++;
        }
        if (i == row->number) {
            descriptor_source_refuse(source, source->line, "attribute % of <%>: expected ", attributes[given],
                                     row->name, 0U);
            descriptor_source_append(source, (i > 0U) ? "one of" : "none", NULL, NULL, 0U);
            for (i = 0U; i < row->number; i++) {
                descriptor_source_append(source, " %", row->attributes[i].name, NULL, 0U);
            }
        }
    }
    for (size_t i = 0U; i < row->number; i++) {
        if (((row->attributes[i].form & SOURCE_NEEDED) != 0U) &&
            !descriptor_source_has(source, row->attributes[i].name)) {
            descriptor_source_refuse(source, source->line, "<%> needs attribute %", row->name,
                                     row->attributes[i].name, 0U);
        }
    }
}

static void refuse_element(source_t* const source, const uint8_t parent)
{
    descriptor_source_refuse(source, source->line, "<%>", source->element->name, NULL, 0U);
    if (source->depth > 0U) {
        descriptor_source_append(source, " in <%>", source->open[source->depth - 1U]->name, NULL, 0U);
    }
    const char* before = ": expected <%>";
    for (size_t i = 0U; i < source->row_count; i++) {
        if (source->rows[i].parent == parent) {
            descriptor_source_append(source, before, source->rows[i].name, NULL, 0U);
            before = " or <%>";
        }
    }
    descriptor_source_append(source, (before[0] == ':') ? ": expected nothing" : "", NULL, NULL, 0U);
}

static const source_row_t* row_of(const source_t* const source, const uint8_t parent, const char* const name)
{
    for (size_t i = 0U; i < source->row_count; i++) {
        if ((source->rows[i].parent == parent) && (strcmp(source->rows[i].name, name) == 0)) {
            return &source->rows[i];
        }
    }
    return NULL;
}

/// Note that the parent contains this element, and that no child of the element has been read yet.
static void mark_seen(source_t* const source, const source_row_t* const row)
{
    uint64_t* const seen = &source->seen[source->depth - 1U];
    // The lowest bit of `times` is set if the element may occur only once.
    if (((seen[0] >> row->kind) & row->times & 1U) != 0U) {
        descriptor_source_refuse(source, source->line, "a second <%>: expected one", row->name, NULL, 0U);
    }
    seen[0] |= (uint64_t)1U << row->kind;
    seen[1] = 0U;
}

/// Refuse an element that lacks a required child.
static void check_seen(source_t* const source, const source_row_t* const row)
{
    for (size_t i = 1U; i < source->row_count; i++) { // The first row is the document itself.
        const source_row_t* const child = &source->rows[i];
        if ((child->parent == row->kind) && (child->times >= SOURCE_SOME) &&
            (((source->seen[source->depth] >> child->kind) & 1U) == 0U)) {
            descriptor_source_refuse(source, source->line, "<%> has no <%>", row->name, child->name, 0U);
        }
    }
}

static void read_element(source_t* const source, const source_row_t* const row)
{
    void* const around = source->items[source->depth - 1U];
    source->item       = around;
    if (row->list == NULL) {
        descriptor_source_read(source, around, row->attributes, row->number);
    } else {
        source->item = descriptor_source_item(source, row->list, around, row->attributes, row->number);
    }
    source->items[source->depth] = source->item;
    if ((source->status == STATUS_OK) && (row->start != NULL)) {
        row->start(source);
    }
}

static status_t on_start(void* const context, const xml_element_t* const element)
{
    source_t* const source = context;
    const uint8_t parent   = (source->depth > 0U) ? source->open[source->depth - 1U]->kind : SOURCE_ROOT;
    const source_row_t* const row = row_of(source, parent, element->name);
    source->element               = element;
    source->line                  = element->line;
    FSW_ASSERT(source->depth < SOURCE_DEPTH_MAX); // The tables of elements permit no deeper nesting.
    if (row == NULL) {
        refuse_element(source, parent);
        return source->status;
    }
    source->open[source->depth]      = row;
    source->open_line[source->depth] = element->line;
    source->depth++;
    check_attributes(source, row, element->attributes);
    hash_words(source, "<");
    hash_words(source, element->name);
    hash_words(source, "\n");
    hash_attributes(source, element);
    mark_seen(source, row);
    if (source->status == STATUS_OK) {
        read_element(source, row);
    }
    // The attributes are valid only during this call.
    source->element = NULL;
    return source->status;
}

static status_t on_end(void* const context, const char* const name, const uint32_t line)
{
    source_t* const source = context;
    (void)name;
    (void)line;
    FSW_ASSERT(source->depth > 0U);
    const source_row_t* const row = source->open[source->depth - 1U];
    source->item                  = source->items[source->depth];
    // Errors about an element refer to the line where it begins.
    source->line = source->open_line[source->depth - 1U];
    hash_words(source, ">\n");
    check_seen(source, row);
    if (row->end != NULL) {
        row->end(source);
    }
    source->depth--;
    return source->status;
}

xml_handler_t descriptor_source_handler(source_t* const source)
{
    source->hash = FNV64_START;
    return (xml_handler_t){.start = on_start, .end = on_end, .context = source};
}
