// SPDX-License-Identifier: Apache-2.0
/// Reader of the XML files of a world: passes each element with its line to a handler, and copies attributes
/// into a record as a table of fields describes.
///
/// The reader refuses the following, with file and line: a document that is not well-formed, document type
/// declarations (and therefore entities), text between elements, an element deeper than DOCUMENT_DEPTH_MAX, a
/// file of more than DOCUMENT_OCTETS_MAX octets; an attribute that the table does not have, or that is
/// missing, malformed or outside its range.
///
/// Ownership  Elements and their texts are valid until the handler returns; records contain copies.
/// Context    One task.
/// Errors     "file:line: found 'x', expected y" in the buffer given to document_read.
#ifndef SIM_WORLD_DOCUMENT_H
#define SIM_WORLD_DOCUMENT_H

#include "base/status.h"

#include <stdbool.h>
#include <stddef.h>

#define DOCUMENT_ERROR_MAX 320U
#define DOCUMENT_TEXT_MAX 64U ///< Octets of a name or text, its end included.
#define DOCUMENT_OCTETS_MAX 1048576U
#define DOCUMENT_DEPTH_MAX 16U
#define DOCUMENT_VECTOR_MAX 3U

typedef struct {
    const char* path;
    unsigned line;
    unsigned depth; ///< 1: the document element.
    const char* name;
    const char* const* attributes; ///< name, value, .., null.
    char* error;                   ///< DOCUMENT_ERROR_MAX octets.
} element_t;

typedef struct {
    /// If it sets *out_is_skipped, the handler is not called for the elements inside this one, nor for its
    /// end.
    status_t (*start)(void* context, const element_t* element, bool* out_is_skipped);
    /// Called at the end of an element; `attributes` is not valid.
    status_t (*end)(void* context, const element_t* element);
    void* context;
} document_handler_t;

/// Read a file. If the handler returns a status other than STATUS_OK, reading ends with this status.
/// STATUS_OK, STATUS_NOT_FOUND (the file cannot be opened), STATUS_INVALID (content), STATUS_TOO_LARGE (or
/// the file cannot be read), STATUS_EXHAUSTED (memory); for every status except STATUS_OK `error` is filled.
MUST_USE status_t document_read(const char* path, const document_handler_t* handler,
                                char error[DOCUMENT_ERROR_MAX]);

/// Fill the error with "file:line: found 'x', expected y". Returns STATUS_INVALID.
status_t document_refuse(const char* path, unsigned line, const char* found, const char* expected,
                         char error[DOCUMENT_ERROR_MAX]);
status_t element_refuse(const element_t* element, const char* found, const char* expected);

typedef enum {
    FIELD_NAME,     ///< char[DOCUMENT_TEXT_MAX]: a letter, then letters, digits, '_' and '-'.
    FIELD_TEXT,     ///< char[DOCUMENT_TEXT_MAX]: a text that is not empty.
    FIELD_NUMBER,   ///< double.
    FIELD_VECTOR,   ///< double[3], each in the range.
    FIELD_UNSIGNED, ///< unsigned, decimal or hexadecimal.
    FIELD_TIME      ///< double [ns]; the text is a whole number with the unit us, ms or s.
} field_kind_t;

typedef struct {
    const char* name;
    field_kind_t kind;
    size_t offset; ///< Offset in the record.
    double low;    ///< Smallest allowed number.
    double high;
    bool is_optional; ///< If the attribute is missing, the record keeps its value.
} field_t;

/// Copy the attributes of an element into a record. STATUS_OK, or STATUS_INVALID: the error is filled, and
/// the record may have changed.
MUST_USE status_t element_take(const element_t* element, const field_t* fields, size_t count, void* record);
/// Read a number. False: `text` is not a number, or it is outside the range; *out_value may have changed.
bool document_number(const char* text, double low, double high, double* out_value);
/// Returns the value of an attribute, or null if there is none.
const char* element_attribute(const element_t* element, const char* name);

#endif // SIM_WORLD_DOCUMENT_H
