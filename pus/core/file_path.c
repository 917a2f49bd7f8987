// SPDX-License-Identifier: Apache-2.0
#include "pus/core/file_path.h"

#include <string.h>

static bool is_printable(const char character)
{
    return (character >= ' ') && (character <= '~');
}

/// Returns the length of the name at the beginning of a text; 0 if the name is malformed. A name ends at
/// `size` or a slash.
static size_t name_length(const char* const text, const size_t size)
{
    size_t length = 0U;
    while ((length < size) && (text[length] != '/')) {
        const char character = text[length];
        if (!is_printable(character) || (character == '*') || (character == '?')) {
            return 0U;
        }
        length++;
    }
    const bool is_name = (length >= 1U) && (length <= PUS_FILE_NAME_MAX) && (text[0] != '.');
    return is_name ? length : 0U;
}

bool pus_file_name_is_good(const char* const name)
{
    const size_t size = strlen(name);
    return (size > 0U) && (name_length(name, size) == size);
}

/// Read a text with its size in front. Returns its octets; null if they are missing.
static const char* read_text(octet_reader_t* const reader, size_t* const out_size)
{
    *out_size = octet_read_u16(reader);
    return (const char*)octet_read_octets(reader, *out_size);
}

bool pus_file_path_read(octet_reader_t* const reader, pus_file_path_t* const out_path)
{
    size_t size       = 0U;
    const char* text  = read_text(reader, &size);
    out_path->text[0] = '\0';
    if (text == NULL) {
        return false;
    }
    if ((size > 0U) && (text[0] == '/')) {
        text = &text[1];
        size--;
    }
    if (size > PUS_FILE_PATH_MAX) {
        return false;
    }
    for (size_t at = 0U; at < size;) {
        const size_t length = name_length(&text[at], size - at);
        at += length;
        const bool is_last = (at == size);
        // The name is empty, or no name follows the last slash.
        if ((length == 0U) || (!is_last && ((at + 1U) == size))) {
            return false;
        }
        at += is_last ? 0U : 1U;
    }
    (void)memcpy(out_path->text, text, size);
    out_path->text[size] = '\0';
    return true;
}

/// Append a name to a path, with a slash before it unless the path is empty.
static bool append(pus_file_path_t* const path, const char* const name, const size_t size)
{
    const size_t length = strlen(path->text);
    const size_t start  = (length > 0U) ? (length + 1U) : 0U;
    if ((start + size) > PUS_FILE_PATH_MAX) {
        return false;
    }
    if (length > 0U) {
        path->text[length] = '/';
    }
    (void)memcpy(&path->text[start], name, size);
    path->text[start + size] = '\0';
    return true;
}

bool pus_file_path_read_name(octet_reader_t* const reader, pus_file_path_t* const path)
{
    size_t size            = 0U;
    const char* const text = read_text(reader, &size);
    return (text != NULL) && (size > 0U) && (name_length(text, size) == size) && append(path, text, size);
}

bool pus_file_path_enter(pus_file_path_t* const path, const char* const name)
{
    return append(path, name, strlen(name));
}

const char* pus_file_path_name(const pus_file_path_t* const path)
{
    const char* const slash = strrchr(path->text, '/');
    return (slash != NULL) ? &slash[1] : path->text;
}

void pus_file_path_leave(pus_file_path_t* const path)
{
    char* const slash                       = strrchr(path->text, '/');
    *((slash != NULL) ? slash : path->text) = '\0';
}

bool pus_file_path_is_same(const pus_file_path_t* const a, const pus_file_path_t* const b)
{
    return strcmp(a->text, b->text) == 0;
}

bool pus_file_path_is_within(const pus_file_path_t* const path, const pus_file_path_t* const directory)
{
    const size_t length = strlen(directory->text);
    const bool is_root  = (length == 0U);
    return is_root || ((strncmp(path->text, directory->text, length) == 0) &&
                       ((path->text[length] == '\0') || (path->text[length] == '/')));
}

void pus_file_name_write(octet_writer_t* const writer, const char* const name)
{
    const size_t size = strlen(name);
    octet_write_u16(writer, (uint16_t)size);
    octet_write_octets(writer, (const uint8_t*)name, size);
}

void pus_file_path_write(octet_writer_t* const writer, const pus_file_path_t* const path)
{
    const size_t size = strlen(path->text);
    octet_write_u16(writer, (uint16_t)(size + 1U));
    octet_write_u8(writer, (uint8_t)'/');
    octet_write_octets(writer, (const uint8_t*)path->text, size);
}

bool pus_file_pattern_read(octet_reader_t* const reader, char* const out_pattern)
{
    size_t size            = 0U;
    const char* const text = read_text(reader, &size);
    if ((text == NULL) || (size < 1U) || (size > PUS_FILE_NAME_MAX)) {
        return false;
    }
    for (size_t i = 0U; i < size; i++) {
        if (!is_printable(text[i]) || (text[i] == '/')) {
            return false;
        }
    }
    (void)memcpy(out_pattern, text, size);
    out_pattern[size] = '\0';
    return true;
}

bool pus_file_pattern_matches(const char* const pattern, const char* const name)
{
    size_t at       = 0U; // Position in the pattern.
    size_t position = 0U; // Position in the name.
    size_t star     = 0U; // Position after the last star in the pattern; 0: no star yet.
    size_t resume   = 0U; // Position in the name after the characters that this star matches.
    bool is_matched = true;
    while (is_matched && (name[position] != '\0')) {
        if (pattern[at] == '*') {
            at++;
            star   = at;
            resume = position;
        } else if ((pattern[at] == '?') || (pattern[at] == name[position])) {
            at++;
            position++;
        } else if (star > 0U) { // Let the star match one more character.
            resume++;
            at       = star;
            position = resume;
        } else {
            is_matched = false;
        }
    }
    while (pattern[at] == '*') {
        at++;
    }
    return is_matched && (pattern[at] == '\0');
}
