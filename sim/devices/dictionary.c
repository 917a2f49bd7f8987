// SPDX-License-Identifier: Apache-2.0
#include "sim/devices/dictionary.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define MANUFACTURER_FIRST 0x2000U
#define MANUFACTURER_LAST 0x5FFFU

void dictionary_destroy(dictionary_t* const dictionary)
{
    for (size_t i = 0U; i < dictionary->count; i++) {
        free(dictionary->objects[i].text);
    }
    free(dictionary->objects);
    free(dictionary->names);
    *dictionary = (dictionary_t){0};
}

void dictionary_reset_range(dictionary_t* const dictionary, const uint16_t first, const uint16_t last)
{
    for (size_t i = 0U; i < dictionary->count; i++) {
        object_t* object = &dictionary->objects[i];
        if ((object->index < first) || (object->index > last)) {
            continue;
        }
        object->value = object->initial;
        if (object->text != NULL) {
            object->size = object->initial_size;
            memcpy(object->text, object->initial_text, OBJECT_TEXT_MAX);
        }
    }
}

object_t* dictionary_find(const dictionary_t* const dictionary, const uint16_t index, const uint8_t subindex)
{
    const uint32_t wanted = ((uint32_t)index << 8) | subindex;
    size_t low            = 0U;
    size_t high           = dictionary->count;
    while (low < high) {
        const size_t middle    = low + ((high - low) / 2U);
        object_t* const object = &dictionary->objects[middle];
        const uint32_t key     = ((uint32_t)object->index << 8) | object->subindex;
        if (key == wanted) {
            return object;
        }
        if (key < wanted) {
            low = middle + 1U;
        } else {
            high = middle;
        }
    }
    return NULL;
}

bool dictionary_has_index(const dictionary_t* const dictionary, const uint16_t index)
{
    for (size_t i = 0U; i < dictionary->count; i++) {
        if (dictionary->objects[i].index == index) {
            return true;
        }
    }
    return false;
}

uint8_t object_type_size(const object_type_t type)
{
    static const uint8_t sizes[] = {
        [OBJECT_BOOLEAN] = 1U,    [OBJECT_INTEGER8] = 1U,  [OBJECT_UNSIGNED8] = 1U,  [OBJECT_INTEGER16] = 2U,
        [OBJECT_UNSIGNED16] = 2U, [OBJECT_INTEGER24] = 3U, [OBJECT_UNSIGNED24] = 3U, [OBJECT_INTEGER32] = 4U,
        [OBJECT_UNSIGNED32] = 4U, [OBJECT_INTEGER40] = 5U, [OBJECT_UNSIGNED40] = 5U, [OBJECT_INTEGER48] = 6U,
        [OBJECT_UNSIGNED48] = 6U, [OBJECT_INTEGER56] = 7U, [OBJECT_UNSIGNED56] = 7U, [OBJECT_INTEGER64] = 8U,
        [OBJECT_UNSIGNED64] = 8U, [OBJECT_REAL32] = 4U,    [OBJECT_REAL64] = 8U,
    };
    return ((size_t)type < sizeof sizes) ? sizes[type] : 0U; // The size of a string is that of its value.
}

uint16_t dictionary_index_of(const dictionary_t* const dictionary, const char* const name)
{
    for (size_t i = 0U; i < dictionary->name_count; i++) {
        const object_name_t* known = &dictionary->names[i];
        if ((known->index >= MANUFACTURER_FIRST) && (known->index <= MANUFACTURER_LAST) &&
            (strcasecmp(known->name, name) == 0)) {
            return known->index;
        }
    }
    return 0U;
}

bool object_is_text(const object_t* const object)
{
    return (object->type == OBJECT_VISIBLE_STRING) || (object->type == OBJECT_OCTET_STRING);
}

bool object_is_real(const object_t* const object)
{
    return (object->type == OBJECT_REAL32) || (object->type == OBJECT_REAL64);
}

double object_real(const object_t* const object)
{
    const uint32_t half = (uint32_t)object->value;
    float single        = 0.0F;
    double number       = 0.0;
    memcpy(&single, &half, sizeof single);
    memcpy(&number, &object->value, sizeof number);
    return (object->type == OBJECT_REAL32) ? (double)single : number;
}

void object_set_real(object_t* const object, const double value)
{
    const bool is_beyond = fabs(value) > (double)FLT_MAX; // The conversion would be undefined.
    const float single   = is_beyond ? copysignf(INFINITY, (value > 0.0) ? 1.0F : -1.0F) : (float)value;
    uint32_t half        = 0U;
    memcpy(&half, &single, sizeof half);
    memcpy(&object->value, &value, sizeof object->value);
    object->value = (object->type == OBJECT_REAL32) ? half : object->value;
}
