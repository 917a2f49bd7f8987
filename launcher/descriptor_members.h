// SPDX-License-Identifier: Apache-2.0
/// The members of the models of descriptors, by which they are written as constants. Internal to
/// descriptor_writer.
#ifndef LAUNCHER_DESCRIPTOR_MEMBERS_H
#define LAUNCHER_DESCRIPTOR_MEMBERS_H

#include <stddef.h>
#include <stdint.h>

typedef enum {
    DESCRIPTOR_MEMBER_NUMBER,
    DESCRIPTOR_MEMBER_REAL,
    DESCRIPTOR_MEMBER_WORDS,
    DESCRIPTOR_MEMBER_NAMES ///< An enumeration of the same model.
} descriptor_member_kind_t;

typedef struct {
    const char* name;
    size_t offset;
    uint8_t width; ///< [octets]
    uint8_t count; ///< Numbers in an array; 0: no array.
    descriptor_member_kind_t kind;
} descriptor_member_t;

typedef struct { // A list of a model.
    const char* type;
    const char* name;
    const descriptor_member_t* members; ///< NULL: the items are numbers.
    size_t member_count;
    size_t size;  ///< Of an item.
    size_t items; ///< Offset in the model of the pointer to the items,
    size_t count; ///< and of their number.
} descriptor_list_t;

typedef struct { // A model.
    const char* type;
    const descriptor_list_t* lists;
    size_t list_count;
    const descriptor_member_t* members; ///< Those that are not lists.
    size_t member_count;
} descriptor_model_t;

extern const descriptor_model_t descriptor_model_of_subsystem;
extern const descriptor_model_t descriptor_model_of_mission; ///< Only what a subsystem needs of it.

#endif // LAUNCHER_DESCRIPTOR_MEMBERS_H
