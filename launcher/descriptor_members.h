// SPDX-License-Identifier: Apache-2.0
/// Members of the models of descriptors, from which descriptor_writer writes the models as constants. Private
/// to descriptor_writer.
#ifndef LAUNCHER_DESCRIPTOR_MEMBERS_H
#define LAUNCHER_DESCRIPTOR_MEMBERS_H

#include <stddef.h>
#include <stdint.h>

typedef enum {
    DESCRIPTOR_MEMBER_NUMBER,
    DESCRIPTOR_MEMBER_REAL,
    DESCRIPTOR_MEMBER_TEXT, ///< Pointer to a text.
    DESCRIPTOR_MEMBER_NAMES ///< Pointer to an enumeration of the same model.
} descriptor_member_kind_t;

typedef struct {
    const char* name;
    size_t offset;
    uint8_t width; ///< [octets]
    uint8_t count; ///< Length if it is an array of numbers; 0: it is no array.
    descriptor_member_kind_t kind;
} descriptor_member_t;

typedef struct { // A list of a model.
    const char* type;
    const char* name;
    const descriptor_member_t* members; ///< Members of each item; NULL: the items are numbers.
    size_t member_count;
    size_t size;  ///< Size of an item [octets].
    size_t items; ///< Offset of the pointer to the items in the model.
    size_t count; ///< Offset of the number of items in the model.
} descriptor_list_t;

typedef struct { // A model.
    const char* type;
    const descriptor_list_t* lists;
    size_t list_count;
    const descriptor_member_t* members; ///< Members that are not lists.
    size_t member_count;
} descriptor_model_t;

extern const descriptor_model_t descriptor_model_of_subsystem;
extern const descriptor_model_t descriptor_model_of_mission; ///< Only the members that a subsystem needs.

#endif // LAUNCHER_DESCRIPTOR_MEMBERS_H
