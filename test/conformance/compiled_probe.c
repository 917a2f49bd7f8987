// SPDX-License-Identifier: Apache-2.0
// Compares the descriptors that were compiled into a program with those that the reader makes of the files:
// every octet of every item, and the texts to which pointers lead. Built by test_compiled_descriptors.py;
// COMPILED is the generated source. Arguments: files of missions. Prints three numbers: entries that were
// compared, entries of the program, and items compared; or the first difference, or the error of a file.
#include COMPILED
#include "fsw/framework/descriptor/descriptor.h"
#include "launcher/descriptor_members.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ITEM_OCTETS_MAX 1024U

static descriptor_loader_t loader;
static mission_descriptor_t whole;
static mission_descriptor_t mission;
static subsystem_descriptor_t own;
static unsigned items_compared;

static void expect(const bool is_same, const char* const list, const char* const member, const unsigned item)
{
    if (!is_same) {
        (void)printf("%s[%u].%s differs\n", list, item, member);
        exit(1);
    }
}

/// Returns the pointer that is stored at this place of a descriptor.
static const char* pointer_at(const uint8_t* const place)
{
    const char* pointer = NULL;
    (void)memcpy(&pointer, place, sizeof pointer);
    return pointer;
}

/// Compare the texts of two items, and clear the pointers to them in the copies.
static void compare_texts(const descriptor_member_t* const member, uint8_t* const one, uint8_t* const other,
                          const char* const list, const unsigned item)
{
    const char* words       = pointer_at(&one[member->offset]);
    const char* other_words = pointer_at(&other[member->offset]);
    if ((member->kind == DESCRIPTOR_MEMBER_NAMES) && (words != NULL) && (other_words != NULL)) {
        words       = pointer_at((const uint8_t*)words); // An enumeration begins with its name.
        other_words = pointer_at((const uint8_t*)other_words);
    }
    expect((words == NULL) == (other_words == NULL), list, member->name, item);
    expect((words == NULL) || (strcmp(words, other_words) == 0), list, member->name, item);
    (void)memset(&one[member->offset], 0, sizeof words);
    (void)memset(&other[member->offset], 0, sizeof words);
}

static void compare_list(const descriptor_list_t* const list, const uint8_t* const one,
                         const uint8_t* const other)
{
    uint16_t count       = 0U;
    uint16_t other_count = 0U;
    (void)memcpy(&count, &one[list->count], sizeof count);
    (void)memcpy(&other_count, &other[list->count], sizeof other_count);
    expect(count == other_count, list->name, "count", 0U);
    const uint8_t* item       = (const uint8_t*)pointer_at(&one[list->items]);
    const uint8_t* other_item = (const uint8_t*)pointer_at(&other[list->items]);
    for (unsigned i = 0U; i < count; i++) {
        uint8_t octets[2][ITEM_OCTETS_MAX];
        expect(list->size <= ITEM_OCTETS_MAX, list->name, "size", i);
        (void)memcpy(octets[0], item, list->size);
        (void)memcpy(octets[1], other_item, list->size);
        for (size_t m = 0U; m < list->member_count; m++) {
            if ((list->members[m].kind == DESCRIPTOR_MEMBER_WORDS) ||
                (list->members[m].kind == DESCRIPTOR_MEMBER_NAMES)) {
                compare_texts(&list->members[m], octets[0], octets[1], list->name, i);
            }
        }
        expect(memcmp(octets[0], octets[1], list->size) == 0, list->name, "an octet", i);
        items_compared++;
        item += list->size;
        other_item += list->size;
    }
}

static void compare(const descriptor_model_t* const parts, const void* const one, const void* const other)
{
    for (size_t i = 0U; i < parts->list_count; i++) {
        compare_list(&parts->lists[i], one, other);
    }
    for (size_t i = 0U; i < parts->member_count; i++) {
        const descriptor_member_t* const member = &parts->members[i];
        const uint8_t* const place              = (const uint8_t*)one + member->offset;
        const uint8_t* const other_place        = (const uint8_t*)other + member->offset;
        const size_t size = (size_t)member->width * ((member->count > 0U) ? member->count : 1U);
        expect((member->kind == DESCRIPTOR_MEMBER_WORDS)
                   ? (strcmp(pointer_at(place), pointer_at(other_place)) == 0)
                   : (memcmp(place, other_place, size) == 0),
               parts->type, member->name, 0U);
    }
}

/// Compare the entries of the program for one mission.
static unsigned compare_mission(const char* const path, const compiled_descriptors_t* const all)
{
    unsigned found = 0U;
    if (descriptor_load_mission(&loader, path, MISSION_ANY_TARGET, &descriptor_mission_whole, &whole, &own) !=
        STATUS_OK) {
        (void)printf("%s\n", descriptor_error(&loader));
        exit(1);
    }
    for (size_t i = 0U; i < all->count; i++) {
        const compiled_descriptor_t* const one = &all->entries[i];
        if (one->mission_hash != whole.configuration_hash) {
            continue;
        }
        if (descriptor_load_mission(&loader, path, one->apid, NULL, &mission, &own) != STATUS_OK) {
            exit(1);
        }
        compare(&descriptor_model_of_subsystem, one->own, &own);
        compare(&descriptor_model_of_mission, one->mission, &mission);
        found++;
    }
    return found;
}

int main(const int argument_count, char* arguments[])
{
    unsigned found = 0U;
    descriptor_loader_init(&loader);
    for (int i = 1; i < argument_count; i++) {
        found += compare_mission(arguments[i], compiled_descriptors_of_program());
    }
    (void)printf("%u %zu %u\n", found, compiled_descriptors_of_program()->count, items_compared);
    return 0;
}
