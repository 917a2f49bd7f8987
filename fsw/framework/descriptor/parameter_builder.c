// SPDX-License-Identifier: Apache-2.0
// The contents of <Parameters>. A structure within a structure is called a group: its fields have names
// that begin with the name of the group and a dot; in memory it is a nested structure.
#include "base/assertion.h"
#include "fsw/framework/descriptor/subsystem_builder.h"

#include <string.h>

#define PARAMETER_OCTETS_MAX 4000U
#define MEMBER_ID 1U ///< Index of the id in the attributes of a member.

// Alignment of each scalar type inside a structure with this compiler.
#define DEFINE_ALIGNED(type)                                                                                 \
    typedef struct {                                                                                         \
        char before;                                                                                         \
        type member;                                                                                         \
    } aligned_##type
#define ALIGNMENT_OF(type) ((uint8_t)offsetof(aligned_##type, member))

DEFINE_ALIGNED(uint8_t);
DEFINE_ALIGNED(uint16_t);
DEFINE_ALIGNED(uint32_t);
DEFINE_ALIGNED(uint64_t);
DEFINE_ALIGNED(float);
DEFINE_ALIGNED(double);

// A signed type has the alignment of the corresponding unsigned type (C99 6.2.5). Generated structures use
// bool for BOOL.
typedef struct {
    char before;
    bool member;
} aligned_bool;

static const uint8_t alignments[VALUE_SCALARS] = {
    [VALUE_UINT8]  = ALIGNMENT_OF(uint8_t),
    [VALUE_UINT16] = ALIGNMENT_OF(uint16_t),
    [VALUE_UINT32] = ALIGNMENT_OF(uint32_t),
    [VALUE_UINT64] = ALIGNMENT_OF(uint64_t),
    [VALUE_INT8]   = ALIGNMENT_OF(uint8_t),
    [VALUE_INT16]  = ALIGNMENT_OF(uint16_t),
    [VALUE_INT32]  = ALIGNMENT_OF(uint32_t),
    [VALUE_INT64]  = ALIGNMENT_OF(uint64_t),
    [VALUE_FLOAT]  = ALIGNMENT_OF(float),
    [VALUE_DOUBLE] = ALIGNMENT_OF(double),
    [VALUE_BOOL]   = (uint8_t)offsetof(aligned_bool, member),
};

// ---- Layout in memory ----

static uint32_t round_up(const uint32_t offset, const uint32_t alignment)
{
    return ((offset + alignment - 1U) / alignment) * alignment;
}

/// Returns the alignment of a group: of those fields of a range whose names begin with the first `length`
/// characters of `name`. With length 0 the group is the whole parameter.
static uint32_t group_alignment(const subsystem_descriptor_t* const descriptor, const uint16_t first,
                                const uint16_t count, const char* const name, const size_t length)
{
    uint32_t alignment = 1U;
    for (uint16_t i = first; i < (first + count); i++) {
        const uint32_t own = alignments[descriptor->fields[i].type];
        if ((strncmp(descriptor->fields[i].name, name, length) == 0) && (own > alignment)) {
            alignment = own;
        }
    }
    return alignment;
}

/// Returns the number of characters of the groups that two names share, including the dots.
static size_t shared_groups(const char* const one, const char* const other)
{
    size_t shared = 0U;
    for (size_t i = 0U; (one[i] != '\0') && (one[i] == other[i]); i++) {
        shared = (one[i] == '.') ? (i + 1U) : shared;
    }
    return shared;
}

/// Returns `offset`, rounded up to the alignment of each group of `name` that begins or ends there: those
/// after its first `kept` characters. As a structure, a group begins at a multiple of its alignment, and its
/// size is such a multiple, too.
static uint32_t pass_groups(const subsystem_descriptor_t* const descriptor, const uint16_t first,
                            const uint16_t count, const char* const name, const size_t kept,
                            const uint32_t offset)
{
    uint32_t rounded = offset;
    for (size_t length = strlen(name); length > kept; length--) {
        if (name[length - 1U] == '.') {
            rounded = round_up(rounded, group_alignment(descriptor, first, count, name, length));
        }
    }
    return rounded;
}

uint32_t descriptor_subsystem_builder_lay_out(subsystem_descriptor_t* const descriptor, const uint16_t first,
                                              const uint16_t count)
{
    uint32_t offset    = 0U;
    const char* before = "";
    for (uint16_t i = first; i < (first + count); i++) {
        descriptor_field_t* const field = &descriptor->storage.fields[i];
        // The groups that only the field before has end here; then those that only this field has begin.
        const size_t kept = shared_groups(before, field->name);
        offset            = pass_groups(descriptor, first, count, before, kept, offset);
        offset            = pass_groups(descriptor, first, count, field->name, kept, offset);
        field->offset     = round_up(offset, alignments[field->type]);
        offset            = field->offset + (uint32_t)(value_size(field->type) * field->count);
        before            = field->name;
    }
    offset = pass_groups(descriptor, first, count, before, 0U, offset);
    return round_up(offset, group_alignment(descriptor, first, count, "", 0U));
}

// ---- Elements ----

/// Set id and sizes of a parameter whose fields are complete. Refuse one that is too large, or that has the
/// layout and id of another one.
static void complete_parameter(source_t* const source, descriptor_parameter_t* const parameter,
                               const uint32_t layout)
{
    subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    const uint16_t first                     = parameter->first_field;
    // 11 bits APID, 5 bits layout, 16 bits number.
    parameter->id          = ((uint32_t)descriptor->apid << 21U) | (layout << 16U) | parameter->number;
    parameter->wire_size   = descriptor_subsystem_builder_octets(descriptor, first, parameter->field_count);
    parameter->memory_size = descriptor_subsystem_builder_lay_out(descriptor, first, parameter->field_count);
    descriptor_source_limit(source, parameter->wire_size, PARAMETER_OCTETS_MAX, " octets in one parameter");
    for (const descriptor_parameter_t* other = descriptor->parameters; other < parameter; other++) {
        if (other->id == parameter->id) {
            descriptor_source_refuse(source, source->line, "layout and id of % are those of % in line #",
                                     parameter->name, other->name, other->line);
        }
    }
}

void descriptor_parameter_builder_scalars(source_t* const source)
{
    descriptor_parameter_t* const parameter = source->item;
    descriptor_field_t* const field =
        descriptor_source_item(source, &descriptor_subsystem_parameter_fields, parameter,
                               descriptor_subsystem_field_attributes, SUBSYSTEM_FIELD_ATTRIBUTES);
    if (field != NULL) {
        descriptor_subsystem_builder_complete(source, field);
        complete_parameter(source, parameter,
                           (field->count > 1U) ? (uint32_t)VALUE_ARRAY : (uint32_t)field->type);
    }
}

void descriptor_parameter_builder_struct(source_t* const source)
{
    descriptor_parameter_t* const parameter = source->item;
    parameter->is_struct                    = true;
}

/// Build the full name of the element in `characters`: the enclosing groups, then its own name. Refuse a
/// name that a group or a field of the same parameter already has; only fields before `newest` are compared.
static text_t path_of(source_t* const source, char* const characters,
                      const descriptor_parameter_t* const parameter, const descriptor_field_t* const newest)
{
    text_t path = text_in(characters, DESCRIPTOR_PATH_MAX + 1U);
    text_add(&path, descriptor_subsystem_builder_of(source)->group);
    text_add(&path, descriptor_source_raw(source, "name"));
    FSW_ASSERT(!path.cut);
    const descriptor_field_t* field =
        &descriptor_subsystem_builder_model(source)->fields[parameter->first_field];
    for (; (parameter->field_count > 0U) && (field < newest); field++) {
        if ((strncmp(field->name, characters, path.length) == 0) &&
            ((field->name[path.length] == '\0') || (field->name[path.length] == '.'))) {
            descriptor_source_taken(source, "name", characters, field->line);
        }
    }
    return path;
}

void descriptor_parameter_builder_group(source_t* const source)
{
    subsystem_builder_t* const builder             = descriptor_subsystem_builder_of(source);
    const subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    char characters[DESCRIPTOR_PATH_MAX + 1U];
    if (builder->group_depth == DESCRIPTOR_NESTING_MAX) {
        descriptor_source_refuse(source, source->line, "structures nested more than # deep", NULL, NULL,
                                 DESCRIPTOR_NESTING_MAX);
        return;
    }
    text_t path = path_of(source, characters, source->item, &descriptor->fields[descriptor->field_count]);
    text_add(&path, ".");
    text_t group = text_in(builder->group, sizeof builder->group);
    text_add(&group, characters);
    builder->group_depth++;
}

/// Refuse a structure without fields.
static void check_filled(source_t* const source, const bool is_filled)
{
    if (!is_filled) {
        descriptor_source_fail(source, source->line, "<StructRef> has no <ParamRef>");
    }
}

void descriptor_parameter_builder_group_end(source_t* const source)
{
    subsystem_builder_t* const builder             = descriptor_subsystem_builder_of(source);
    const subsystem_descriptor_t* const descriptor = descriptor_subsystem_builder_model(source);
    const descriptor_parameter_t* const parameter  = source->item;
    size_t length                                  = strlen(builder->group);
    check_filled(source, (parameter->field_count > 0U) &&
                             (strncmp(descriptor->fields[descriptor->field_count - 1U].name, builder->group,
                                      length) == 0));
    do { // Cut the name back to the dot of the enclosing group, if there is one.
        length--;
    } while ((length > 0U) && (builder->group[length - 1U] != '.'));
    builder->group[length] = '\0';
    builder->group_depth--;
}

void descriptor_parameter_builder_member(source_t* const source)
{
    descriptor_field_t* const field = source->item;
    char characters[DESCRIPTOR_PATH_MAX + 1U];
    descriptor_subsystem_builder_field(source);
    if (descriptor_source_has(source, "id")) {
        field->id = (uint16_t)descriptor_source_value(source, MEMBER_ID);
    }
    (void)path_of(source, characters, source->items[source->depth - 1U], field);
    if (descriptor_subsystem_builder_of(source)->group_depth > 0U) {
        field->name = descriptor_source_keep(source, characters);
    }
}

void descriptor_parameter_builder_struct_end(source_t* const source)
{
    descriptor_parameter_t* const parameter = source->item;
    check_filled(source, parameter->field_count > 0U);
    complete_parameter(source, parameter, (uint32_t)VALUE_STRUCT);
}
