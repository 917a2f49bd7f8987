// SPDX-License-Identifier: Apache-2.0
// Proves: a path that pus_file_path_read accepts never leaves the root: it has no empty name, no name that
//     begins with a dot, no wildcard, no character that cannot be printed, and no slash at its end. The same
//     is true after pus_file_path_read_name has appended a name. No access is outside the octets.
//     A path or name that is too long is refused.
// Bounds: texts of 0..9 octets; names of at most 3 and paths of at most 7 characters (63 and 192 in flight);
//     the name is appended to any path.
// Replaced: nothing.
// Sources: pus/core/file_path.c base/octets.c
// Options: --unwind 13 --unwindset strlen.0:20,strrchr.0:20
// Reduced: pus/core/file_path.h
//   - #define PUS_FILE_NAME_MAX 63U
//   + #define PUS_FILE_NAME_MAX 3U
// Reduced: pus/core/file_path.h
//   - #define PUS_FILE_PATH_MAX 192U
//   + #define PUS_FILE_PATH_MAX 7U
// Reduced: pus/core/file_path.h
//   - #define PUS_FILE_PATH_SIZE 208U
//   + #define PUS_FILE_PATH_SIZE 8U
// Fault: pus/core/file_path.c
//   - const bool is_name = (length >= 1U) && (length <= PUS_FILE_NAME_MAX) && (text[0] != '.');
//   + const bool is_name = (length >= 1U) && (length <= PUS_FILE_NAME_MAX);
// Fault: pus/core/file_path.c
//   - if ((length == 0U) || (!is_last && ((at + 1U) == size))) {
//   + if (length == 0U) {
// Fault: pus/core/file_path.c
//   - if (size > PUS_FILE_PATH_MAX) {
//   + if (size > (PUS_FILE_PATH_MAX + 1U)) {
// Fault: pus/core/file_path.c
//   - if ((start + size) > PUS_FILE_PATH_MAX) {
//   + if (size > PUS_FILE_PATH_MAX) {
#include "pus/core/file_path.h"
#include "test/proof/proof.h"

#define BUFFER 11U
#define LONGEST 9U

/// True if `text` is a list of names with slashes between them, as file_path.h defines a path.
static bool is_inside(const char* const text)
{
    bool is_start = true;
    size_t length = 0U; // Of the name.
    for (size_t i = 0U; (i < PUS_FILE_PATH_SIZE) && (text[i] != '\0'); i++) {
        const char character = text[i];
        length               = (character == '/') ? 0U : (length + 1U);
        if (length > PUS_FILE_NAME_MAX) {
            return false;
        }
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
        path.text[PUS_FILE_PATH_MAX] = '\0';
        ASSUME(is_inside(path.text));
        if (pus_file_path_read_name(&reader, &path)) {
            PROVE(is_inside(path.text), "a name stays in its directory");
        }
    }
}
