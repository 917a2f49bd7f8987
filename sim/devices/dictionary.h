// SPDX-License-Identifier: Apache-2.0
/// Object dictionary of a CANopen device: the objects that an EDS file lists, with their present values.
///
/// Numbers are stored as bits in a 64-bit word (two's complement cut to the size of the object, or IEEE 754);
/// text and octet strings have storage of their own. The address of an object does not change, so that a
/// device may keep pointers to the objects that it uses in every cycle.
///
/// Ownership  eds_load allocates, dictionary_destroy frees.
/// Time       dictionary_find O(log n), other searches O(n) in the number of objects; access to a value O(1).
#ifndef SIM_DEVICES_DICTIONARY_H
#define SIM_DEVICES_DICTIONARY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OBJECT_TEXT_MAX 64U
#define OBJECT_NAME_MAX 128U ///< Longer names are cut.

/// Data types of CiA 301 that a device may use, by their numbers in an EDS.
typedef enum {
    OBJECT_BOOLEAN        = 0x0001,
    OBJECT_INTEGER8       = 0x0002,
    OBJECT_INTEGER16      = 0x0003,
    OBJECT_INTEGER32      = 0x0004,
    OBJECT_UNSIGNED8      = 0x0005,
    OBJECT_UNSIGNED16     = 0x0006,
    OBJECT_UNSIGNED32     = 0x0007,
    OBJECT_REAL32         = 0x0008,
    OBJECT_VISIBLE_STRING = 0x0009,
    OBJECT_OCTET_STRING   = 0x000A,
    OBJECT_INTEGER24      = 0x0010,
    OBJECT_REAL64         = 0x0011,
    OBJECT_INTEGER40      = 0x0012,
    OBJECT_INTEGER48      = 0x0013,
    OBJECT_INTEGER56      = 0x0014,
    OBJECT_INTEGER64      = 0x0015,
    OBJECT_UNSIGNED24     = 0x0016,
    OBJECT_UNSIGNED40     = 0x0018,
    OBJECT_UNSIGNED48     = 0x0019,
    OBJECT_UNSIGNED56     = 0x001A,
    OBJECT_UNSIGNED64     = 0x001B
} object_type_t;

typedef struct {
    uint16_t index;
    uint8_t subindex;
    object_type_t type;
    bool is_readable;
    bool is_writable;
    bool is_mappable; ///< A PDO may contain the object.
    bool has_low;
    bool has_high;
    int64_t low; ///< Limits of an integer, if has_low and has_high.
    int64_t high;
    double real_low; ///< Limits of a REAL32 or REAL64, if has_low and has_high.
    double real_high;
    uint8_t size;   ///< Octets of a number; present octets of a string.
    uint64_t value; ///< Bits of a number.
    uint64_t initial;
    uint8_t* text; ///< OBJECT_TEXT_MAX octets of a string; null for a number.
    uint8_t initial_size;
    uint8_t initial_text[OBJECT_TEXT_MAX];
} object_t;

typedef struct { // Name of a variable, an array or a record.
    uint16_t index;
    char name[OBJECT_NAME_MAX];
} object_name_t;

typedef struct {
    object_t* objects; ///< Ascending by index and sub-index.
    size_t count;
    object_name_t* names;
    size_t name_count;
} dictionary_t;

void dictionary_destroy(dictionary_t* dictionary);

/// Set the objects with index `first` to `last` back to their initial values.
void dictionary_reset_range(dictionary_t* dictionary, uint16_t first, uint16_t last);

/// Null if there is no such object.
object_t* dictionary_find(const dictionary_t* dictionary, uint16_t index, uint8_t subindex);
/// True if the index exists with any sub-index.
bool dictionary_has_index(const dictionary_t* dictionary, uint16_t index);

/// Returns the index of the manufacturer-specific object (0x2000 to 0x5FFF) with a name, which is not
/// case-sensitive; 0 if there is none.
uint16_t dictionary_index_of(const dictionary_t* dictionary, const char* name);

bool object_is_text(const object_t* object);
/// True for REAL32 and REAL64.
bool object_is_real(const object_t* object);
/// Returns the number of a REAL32 or REAL64.
double object_real(const object_t* object);
/// Set a REAL32 or REAL64. A number beyond the range of REAL32 becomes infinite in it.
void object_set_real(object_t* object, double value);
/// Returns the number of octets of a number of this type; 0 for strings.
uint8_t object_type_size(object_type_t type);

/// True for a type with a sign. This and the following functions are inline, because devices read and set
/// most of their objects in every cycle.
static inline bool object_is_signed(const object_t* const object)
{
    return ((object->type >= OBJECT_INTEGER8) && (object->type <= OBJECT_INTEGER32)) ||
           (object->type == OBJECT_INTEGER24) ||
           ((object->type >= OBJECT_INTEGER40) && (object->type <= OBJECT_INTEGER64));
}

/// Returns the number with its sign.
static inline int64_t object_signed(const object_t* const object)
{
    if (!object_is_signed(object) || (object->size == 8U)) {
        return (int64_t)object->value;
    }
    const uint64_t sign = 1ULL << ((8U * object->size) - 1U);
    return (int64_t)((object->value ^ sign) - sign);
}

/// Set a number; bits beyond the object's size are cut.
static inline void object_set(object_t* const object, const int64_t value)
{
    const uint64_t mask = (object->size == 8U) ? UINT64_MAX : ((1ULL << (8U * object->size)) - 1U);
    object->value       = (uint64_t)value & mask;
}

#endif // SIM_DEVICES_DICTIONARY_H
