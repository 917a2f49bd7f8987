// SPDX-License-Identifier: Apache-2.0
/// Paths of the file service: names separated by `/`, beginning at the root; the root itself is "". A name
/// has 1 to PUS_FILE_NAME_MAX printable ASCII characters; it does not begin with a dot, and contains neither
/// `/` nor a wildcard. Therefore no path leads out of the root, and each file has only one path.
///
/// A repository path in a request may begin with a `/`, and in a report it always does; the file name follows
/// in a separate field. On the wire the length (u16) comes before the characters of a path, name or pattern.
///
/// Context    Any; no state.
/// Time       O(length); pus_file_pattern_matches O(length of the pattern x length of the name).
#ifndef PUS_CORE_FILE_PATH_H
#define PUS_CORE_FILE_PATH_H

#include "base/octets.h"

#define PUS_FILE_NAME_MAX 63U   ///< Longest name and search pattern [characters].
#define PUS_FILE_PATH_MAX 192U  ///< Longest path of a file or directory [characters].
#define PUS_FILE_PATH_SIZE 208U ///< With its NUL, and room for the name of a copy in progress.

typedef struct {
    char text[PUS_FILE_PATH_SIZE];
} pus_file_path_t;

/// True if a text is a name; the text may be longer than a name.
bool pus_file_name_is_good(const char* name);
/// Read a repository path. False: malformed, or longer than PUS_FILE_PATH_MAX; *out_path is then the root.
bool pus_file_path_read(octet_reader_t* reader, pus_file_path_t* out_path);
/// Read a name and append it to the directory *path. False: malformed, or the path becomes too long.
bool pus_file_path_read_name(octet_reader_t* reader, pus_file_path_t* path);
/// Append a well-formed name to the directory *path. False: the path would be too long, and *path does not
/// change.
bool pus_file_path_enter(pus_file_path_t* path, const char* name);
/// Returns the last name of a path; "" for the root.
const char* pus_file_path_name(const pus_file_path_t* path);
/// Remove the last name, so that *path is that of the parent directory. *path must not be the root.
void pus_file_path_leave(pus_file_path_t* path);
/// True if both paths are equal.
bool pus_file_path_is_same(const pus_file_path_t* a, const pus_file_path_t* b);
/// True if a path is the directory or below it.
bool pus_file_path_is_within(const pus_file_path_t* path, const pus_file_path_t* directory);

/// Write a name or a pattern.
void pus_file_name_write(octet_writer_t* writer, const char* name);
/// Write a path with its leading `/`.
void pus_file_path_write(octet_writer_t* writer, const pus_file_path_t* path);

/// Read a search pattern into PUS_FILE_NAME_MAX + 1 characters. False: malformed; a pattern has 1 to
/// PUS_FILE_NAME_MAX printable ASCII characters without `/`.
bool pus_file_pattern_read(octet_reader_t* reader, char* out_pattern);
/// True if a name matches the pattern: `*` stands for any characters or none, `?` for one character.
bool pus_file_pattern_matches(const char* pattern, const char* name);

#endif // PUS_CORE_FILE_PATH_H
