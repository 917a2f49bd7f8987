// SPDX-License-Identifier: Apache-2.0
// Proves: a path that pus_file_path_read accepts never leaves the root: it has no empty name, no name that
//     begins with a dot, no wildcard, no character that cannot be printed, and no slash at its end. The same
//     is true after pus_file_path_read_name has appended a name. No access is outside the octets.
// Bounds: texts of 0..6 octets in a buffer of 8 octets; the name is appended to a folder or to the root.
// Replaced: nothing.
// Sources: pus/core/file_path.c base/octets.c
// Options: --unwind 10 --unwindset strlen.0:20,strrchr.0:20
// Fault: pus/core/file_path.c
//   - const bool is_name = (length >= 1U) && (length <= PUS_FILE_NAME_MAX) && (text[0] != '.');
//   + const bool is_name = (length >= 1U) && (length <= PUS_FILE_NAME_MAX);
// Fault: pus/core/file_path.c
//   - if ((length == 0U) || (!is_last && ((at + 1U) == size))) {
//   + if (length == 0U) {
#include "pus/core/file_path.h"
#include "test/proof/proof.h"

#define BUFFER 8U
#define LONGEST 6U

/// True if `text` is a list of names with slashes between them, as file_path.h defines a path.
static bool is_inside(const char* const text)
{
    bool is_start = true;
    for (size_t i = 0U; (i < (LONGEST + 4U)) && (text[i] != '\0'); i++) {
        const char character = text[i];
        if ((character < ' ') || (character > '~') || (character == '*') || (character == '?')) {
            return false;
        }
        if (is_start && ((character == '.') || (character == '/'))) {
            return false;
        }
        is_start = (character == '/');
    }
    return (text[0] == '\0') || !is_start;
}

void proof(void)
{
    uint8_t octets[BUFFER];
    const size_t size     = any_size(BUFFER);
    octet_reader_t reader = octet_reader(octets, size);
    ASSUME(octets_u16_at(octets) <= LONGEST);
    pus_file_path_t path;
    if (nondet_bool()) {
        if (pus_file_path_read(&reader, &path)) {
            PROVE(is_inside(path.text), "a path stays below the root");
            PROVE(!reader.failed && (reader.position == (2U + (size_t)octets_u16_at(octets))),
                  "the text is read");
        }
    } else {
        path.text[0] = nondet_bool() ? 'f' : '\0';
        path.text[1] = '\0';
        if (pus_file_path_read_name(&reader, &path)) {
            PROVE(is_inside(path.text), "a name stays in its folder");
        }
    }
}
