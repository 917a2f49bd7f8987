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

/// Require that two texts are equal, or both missing.
static void expect_text(const char* const compiled, const char* const read, const char* const list,
                        const unsigned item, const char* const member)
{
    const bool is_same =
        ((compiled == NULL) || (read == NULL)) ? (compiled == read) : (strcmp(compiled, read) == 0);
    if (!is_same) {
        (void)printf("%s[%u].%s is \"%s\" in the program, but \"%s\" in the file\n", list, item, member,
                     (compiled != NULL) ? compiled : "(null)", (read != NULL) ? read : "(null)");
        exit(1);
    }
}

/// Require that all octets of a member, or of a whole item, are equal.
static void expect_octets(const uint8_t* const compiled, const uint8_t* const read, const size_t size,
                          const char* const list, const unsigned item, const char* const member)
{
    for (size_t i = 0U; i < size; i++) {
        if (compiled[i] != read[i]) {
            (void)printf("%s[%u].%s: octet %zu is 0x%02X in the program, but 0x%02X in the file\n", list,
                         item, member, i, (unsigned)compiled[i], (unsigned)read[i]);
            exit(1);
        }
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
static void compare_texts(const descriptor_member_t* const member, uint8_t* const compiled,
                          uint8_t* const read, const char* const list, const unsigned item)
{
    const char* compiled_text = pointer_at(&compiled[member->offset]);
    const char* read_text     = pointer_at(&read[member->offset]);
    if ((member->kind == DESCRIPTOR_MEMBER_NAMES) && (compiled_text != NULL) && (read_text != NULL)) {
        compiled_text = pointer_at((const uint8_t*)compiled_text); // An enumeration begins with its name.
        read_text     = pointer_at((const uint8_t*)read_text);
    }
    expect_text(compiled_text, read_text, list, item, member->name);
    (void)memset(&compiled[member->offset], 0, sizeof compiled_text);
    (void)memset(&read[member->offset], 0, sizeof read_text);
}

static void compare_list(const descriptor_list_t* const list, const uint8_t* const compiled,
                         const uint8_t* const read)
{
    uint16_t count      = 0U;
    uint16_t read_count = 0U;
    (void)memcpy(&count, &compiled[list->count], sizeof count);
    (void)memcpy(&read_count, &read[list->count], sizeof read_count);
    if (count != read_count) {
        (void)printf("%s: %u items in the program, but %u in the file\n", list->name, (unsigned)count,
                     (unsigned)read_count);
        exit(1);
    }
    if (list->size > ITEM_OCTETS_MAX) {
        (void)printf("%s: an item has %zu octets, increase ITEM_OCTETS_MAX (%u)\n", list->name, list->size,
                     ITEM_OCTETS_MAX);
        exit(1);
    }
    const uint8_t* item      = (const uint8_t*)pointer_at(&compiled[list->items]);
    const uint8_t* read_item = (const uint8_t*)pointer_at(&read[list->items]);
    for (unsigned i = 0U; i < count; i++) {
        uint8_t octets[2][ITEM_OCTETS_MAX];
        (void)memcpy(octets[0], item, list->size);
        (void)memcpy(octets[1], read_item, list->size);
        for (size_t m = 0U; m < list->member_count; m++) {
            if ((list->members[m].kind == DESCRIPTOR_MEMBER_TEXT) ||
                (list->members[m].kind == DESCRIPTOR_MEMBER_NAMES)) {
                compare_texts(&list->members[m], octets[0], octets[1], list->name, i);
            }
        }
        expect_octets(octets[0], octets[1], list->size, list->name, i, list->type);
        items_compared++;
        item += list->size;
        read_item += list->size;
    }
}

static void compare(const descriptor_model_t* const parts, const void* const compiled, const void* const read)
{
    for (size_t i = 0U; i < parts->list_count; i++) {
        compare_list(&parts->lists[i], compiled, read);
    }
    for (size_t i = 0U; i < parts->member_count; i++) {
        const descriptor_member_t* const member = &parts->members[i];
        const uint8_t* const place              = (const uint8_t*)compiled + member->offset;
        const uint8_t* const read_place         = (const uint8_t*)read + member->offset;
        const size_t size = (size_t)member->width * ((member->count > 0U) ? member->count : 1U);
        if (member->kind == DESCRIPTOR_MEMBER_TEXT) {
            expect_text(pointer_at(place), pointer_at(read_place), parts->type, 0U, member->name);
        } else {
            expect_octets(place, read_place, size, parts->type, 0U, member->name);
        }
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
            (void)printf("%s\n", descriptor_error(&loader));
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
