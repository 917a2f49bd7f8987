// SPDX-License-Identifier: Apache-2.0
#include "launcher/descriptor_writer.h"

#include "base/assertion.h"
#include "launcher/descriptor_members.h"

#include <string.h>

#define MANTISSA_DIGITS 13U // Hexadecimal digits of the fraction of a double.
#define EXPONENT_BIAS 1023
#define NAME_MAX 32U

// ---- Text ----

static void flush(descriptor_writer_t* const writer)
{
    FSW_ASSERT(!writer->text.cut);
    if (writer->status == STATUS_OK) {
        writer->status = osal_file_write(writer->file, writer->characters, writer->text.length);
    }
    writer->text = text_in(writer->characters, sizeof writer->characters);
}

/// Returns the text; if it is more than half full, it is written to the file first, so that a member fits.
static text_t* room(descriptor_writer_t* const writer)
{
    if (writer->text.length > (DESCRIPTOR_WRITER_OCTETS / 2U)) {
        flush(writer);
    }
    return &writer->text;
}

static void add_words(text_t* const text, const char* const words)
{
    if (words == NULL) {
        text_add(text, "NULL");
        return;
    }
    text_add_character(text, '"');
    for (const char* at = words; *at != '\0'; at++) {
        const unsigned code = (unsigned char)*at;
        const bool is_plain =
            (code >= 0x20U) && (code < 0x7FU) && (*at != '"') && (*at != '\\') && (*at != '?');
        if (is_plain) {
            text_add_character(text, *at);
        } else { // Another character: three octal digits.
            text_add_character(text, '\\');
            text_add_character(text, (char)('0' + (char)(code >> 6U)));
            text_add_character(text, (char)('0' + (char)((code >> 3U) & 7U)));
            text_add_character(text, (char)('0' + (char)(code & 7U)));
        }
    }
    text_add_character(text, '"');
}

/// Write a finite number exactly, in hexadecimal, for example 0x1.8000000000000p1.
static void add_real(text_t* const text, const void* const octets)
{
    uint64_t bits = 0U;
    char digits[sizeof "0x" + 16U];
    text_t number = text_in(digits, sizeof digits);
    (void)memcpy(&bits, octets, sizeof bits);
    const unsigned exponent = (unsigned)(bits >> 52U) & 0x7FFU;
    text_add_hex(&number, bits & 0xFFFFFFFFFFFFFULL, MANTISSA_DIGITS);
    text_add(text, ((bits >> 63U) != 0U) ? "-" : "");
    text_add(text, (exponent > 0U) ? "0x1." : "0x0.");
    text_add(text, &digits[2]);
    text_add(text, "p");
    text_add_signed(text, (exponent > 0U) ? ((int64_t)exponent - EXPONENT_BIAS) : (1 - EXPONENT_BIAS));
}

static void add_number(text_t* const text, const void* const octets, const size_t width)
{
    uint8_t u8   = 0U;
    uint16_t u16 = 0U;
    uint32_t u32 = 0U;
    uint64_t u64 = 0U;
    FSW_ASSERT((width == 1U) || (width == 2U) || (width == 4U) || (width == 8U));
    (void)memcpy((width == 1U)   ? (void*)&u8
                 : (width == 2U) ? (void*)&u16
                 : (width == 4U) ? (void*)&u32
                                 : (void*)&u64,
                 octets, width);
    text_add_unsigned(text, (uint64_t)u8 + u16 + u32 + u64);
    text_add(text, (width == 8U) ? "ULL" : "U");
}

// ---- Structures ----

typedef struct { // The model that is being written.
    descriptor_writer_t* writer;
    const char* prefix; ///< Prefix of the names of its lists.
    const descriptor_enumeration_t* enumerations;
} model_t;

static void add_names(const model_t* const model, text_t* const text, const void* const octets)
{
    const descriptor_enumeration_t* enumeration = NULL;
    (void)memcpy(&enumeration, octets, sizeof(void*));
    if (enumeration == NULL) {
        text_add(text, "NULL");
        return;
    }
    text_add_pattern(text, "&%enumerations[#]", model->prefix, NULL,
                     (uint64_t)(enumeration - model->enumerations));
}

static void add_member(const model_t* const model, const uint8_t* const item,
                       const descriptor_member_t* const member)
{
    FSW_ASSERT(member != NULL);
    text_t* const text    = room(model->writer);
    const uint8_t* octets = &item[member->offset];
    const char* words     = NULL;
    text_add_pattern(text, ".% = ", member->name, NULL, 0U);
    if (member->count > 0U) {
        text_add(text, "{");
        for (uint8_t i = 0U; i < member->count; i++) {
            text_add(text, (i > 0U) ? ", " : "");
            add_number(text, &octets[(size_t)i * member->width], member->width);
        }
        text_add(text, "}");
    } else if (member->kind == DESCRIPTOR_MEMBER_NUMBER) {
        add_number(text, octets, member->width);
    } else if (member->kind == DESCRIPTOR_MEMBER_REAL) {
        add_real(text, octets);
    } else if (member->kind == DESCRIPTOR_MEMBER_NAMES) {
        add_names(model, text, octets);
    } else {
        (void)memcpy(&words, octets, sizeof words);
        add_words(text, words);
    }
    text_add(text, ", ");
}

static uint16_t count_of(const uint8_t* const whole, const descriptor_list_t* const list)
{
    uint16_t count = 0U;
    (void)memcpy(&count, &whole[list->count], sizeof count);
    return count;
}

static void add_list(const model_t* const model, const uint8_t* const whole,
                     const descriptor_list_t* const list)
{
    const uint16_t count = count_of(whole, list);
    const uint8_t* item  = NULL;
    (void)memcpy(&item, &whole[list->items], sizeof item);
    if (count == 0U) {
        return;
    }
    descriptor_writer_add(model->writer, (const char* const[]){"static const ", list->type, " ",
                                                               model->prefix, list->name, "[] = {\n", NULL});
    for (uint16_t i = 0U; i < count; i++) {
        text_add(room(model->writer), (list->members != NULL) ? "    {" : "    ");
        for (size_t m = 0U; m < list->member_count; m++) {
            add_member(model, item, &list->members[m]);
        }
        if (list->members == NULL) {
            add_number(room(model->writer), item, list->size);
        }
        text_add(room(model->writer), (list->members != NULL) ? "},\n" : ",\n");
        item += list->size;
    }
    text_add(room(model->writer), "};\n");
}

/// Write the lists, then the model as an object. The name of the object is the prefix without its last
/// character.
static void add_model(const model_t* const model, const uint8_t* const whole,
                      const descriptor_model_t* const parts)
{
    char name[NAME_MAX];
    text_t text = text_in(name, sizeof name);
    for (size_t i = 0U; i < parts->list_count; i++) {
        add_list(model, whole, &parts->lists[i]);
    }
    for (const char* at = model->prefix; at[1] != '\0'; at++) {
        text_add_character(&text, *at);
    }
    descriptor_writer_add(model->writer,
                          (const char* const[]){"static ", parts->type, " ", name, " = {\n    ", NULL});
    for (size_t i = 0U; i < parts->member_count; i++) {
        add_member(model, whole, &parts->members[i]);
    }
    for (size_t i = 0U; i < parts->list_count; i++) {
        const descriptor_list_t* const list = &parts->lists[i];
        if (count_of(whole, list) > 0U) {
            descriptor_writer_add(model->writer, (const char* const[]){"\n    .", list->name, " = ",
                                                                       model->prefix, list->name, ",", NULL});
        }
    }
    descriptor_writer_add(model->writer, (const char* const[]){"\n};\n", NULL});
}

void descriptor_writer_add(descriptor_writer_t* const writer, const char* const* const words)
{
    FSW_ASSERT((writer != NULL) && (words != NULL));
    text_add_words(room(writer), words);
}

// ---- Models ----

static void add_prefix(text_t* const text, const char* const kind, const unsigned number)
{
    text_add(text, kind);
    text_add_unsigned(text, number);
    text_add(text, "_");
}

void descriptor_writer_subsystem(descriptor_writer_t* const writer, const unsigned number,
                                 const subsystem_descriptor_t* const descriptor)
{
    FSW_ASSERT((writer != NULL) && (descriptor != NULL));
    char prefix[NAME_MAX];
    text_t text = text_in(prefix, sizeof prefix);
    add_prefix(&text, "subsystem_", number);
    const model_t model = {writer, prefix, descriptor->enumerations};
    add_model(&model, (const uint8_t*)descriptor, &descriptor_model_of_subsystem);
}

void descriptor_writer_mission(descriptor_writer_t* const writer, const unsigned number,
                               const mission_descriptor_t* const mission)
{
    FSW_ASSERT((writer != NULL) && (mission != NULL));
    char prefix[NAME_MAX];
    text_t text = text_in(prefix, sizeof prefix);
    add_prefix(&text, "mission_", number);
    const model_t model = {writer, prefix, NULL};
    add_model(&model, (const uint8_t*)mission, &descriptor_model_of_mission);
}

typedef struct { // In each of these structures, the offset of `member` is the alignment of its type.
    char octet;
    uint16_t member;
} aligned_u16_t;
typedef struct {
    char octet;
    uint32_t member;
} aligned_u32_t;
typedef struct {
    char octet;
    uint64_t member;
} aligned_u64_t;
typedef struct {
    char octet;
    float member;
} aligned_float_t;
typedef struct {
    char octet;
    double member;
} aligned_double_t;

static void add_check(descriptor_writer_t* const writer, const char* const type, const size_t alignment)
{
    text_t* const text = room(writer);
    text_add_words(text, (const char* const[]){"typedef struct { char octet; ", type, " member; } aligned_",
                                               type, ";\ntypedef char layout_of_", type,
                                               "[(offsetof(aligned_", type, ", member) == ", NULL});
    text_add_unsigned(text, alignment);
    text_add(text, "U) ? 1 : -1];\n");
}

void descriptor_writer_begin(descriptor_writer_t* const writer, osal_file_t* const file)
{
    FSW_ASSERT((writer != NULL) && (file != NULL));
    writer->file   = file;
    writer->status = STATUS_OK;
    writer->text   = text_in(writer->characters, sizeof writer->characters);
    text_add(&writer->text,
             "/* Made by descriptor-compiler. */\n#include \"fsw/programs/compiled_descriptors.h\"\n\n"
             "/* Offsets in generated structures are those of this layout. */\n");
    add_check(writer, "uint16_t", offsetof(aligned_u16_t, member));
    add_check(writer, "uint32_t", offsetof(aligned_u32_t, member));
    add_check(writer, "uint64_t", offsetof(aligned_u64_t, member));
    add_check(writer, "float", offsetof(aligned_float_t, member));
    add_check(writer, "double", offsetof(aligned_double_t, member));
}

status_t descriptor_writer_end(descriptor_writer_t* const writer)
{
    FSW_ASSERT(writer != NULL);
    flush(writer);
    return writer->status;
}
