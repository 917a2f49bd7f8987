// SPDX-License-Identifier: Apache-2.0
// An electronic data sheet is either refused with the file's name, or gives a consistent dictionary in which
// every object can be found, read and reset.
#include "sim/devices/eds.h"
#include "test/fuzz/fuzz.h"

#include <string.h>

static void check_dictionary(dictionary_t* const dictionary)
{
    FUZZ_CHECK(dictionary->count > 0U);
    for (size_t i = 0U; i < dictionary->count; i++) {
        const object_t* const object = &dictionary->objects[i];
        FUZZ_CHECK(dictionary_find(dictionary, object->index, object->subindex) == object);
        FUZZ_CHECK(dictionary_has_index(dictionary, object->index));
        FUZZ_CHECK(object_is_text(object) ? ((object->text != NULL) && (object->size <= OBJECT_TEXT_MAX))
                                          : (object->size == object_type_size(object->type)));
        (void)object_signed(object);
    }
    dictionary_reset_range(dictionary, 0U, UINT16_MAX);
}

int LLVMFuzzerTestOneInput(const uint8_t* const data, const size_t size)
{
    dictionary_t dictionary;
    char error[EDS_ERROR_MAX];
    const char* const path = fuzz_file(data, size);
    const status_t status  = eds_load(path, 0x11U, &dictionary, error);
    if (status == STATUS_OK) {
        check_dictionary(&dictionary);
        dictionary_destroy(&dictionary);
    } else {
        FUZZ_CHECK((status == STATUS_INVALID) && (strncmp(error, path, strlen(path)) == 0));
        FUZZ_CHECK((dictionary.count == 0U) && (memchr(error, '\0', sizeof error) != NULL));
    }
    return 0;
}
