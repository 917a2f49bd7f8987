// SPDX-License-Identifier: Apache-2.0
/// The parameter dictionary: data structures that a subsystem shares with the framework; their ids identify
/// them.
///
/// The parameter_definition_t tables of the generated header are the compiled interface. Bounds, settable
/// flags and initial values are set after publishing, from the descriptor. On the wire a parameter is
/// always complete: its fields one after the other, big-endian, without padding.
///
/// Ownership  The caller provides entries, bounds and the published storage; all outlive the dictionary.
/// Context    Any thread: a mutex with priority inheritance guards the content. The owner updates a published
///            structure between parameter_lock and parameter_unlock and calls no other function of this
///            header in between. parameter_read_entry reads without the mutex, and locks it only if values
///            change at that time (docs/decisions/0023).
/// Time       Finding O(1), by a hash of the id; reading and writing O(size); publishing O(size + count).
/// Errors     Each function lists every status. A refused value from the wire is also counted.
#ifndef FSW_FRAMEWORK_PARAMETER_PARAMETER_H
#define FSW_FRAMEWORK_PARAMETER_PARAMETER_H

#include "base/octets.h"
#include "base/status.h"
#include "base/value.h"
#include "osal/include/osal/mutex.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// parameter_id = APID 11 bits | layout 5 bits | number 16 bits.
#define PARAMETER_ID(apid, layout, number)                                                                   \
    (((uint32_t)(apid) << 21) | ((uint32_t)(layout) << 16) | (uint32_t)(number))
#define PARAMETER_APID(id) ((uint16_t)((id) >> 21))
#define PARAMETER_LAYOUT(id) ((uint8_t)(((id) >> 16) & 0x1FU))
#define PARAMETER_NUMBER(id) ((uint16_t)((id)&0xFFFFU))

typedef struct { // One field: `count` scalars of one type, at `offset` in the structure.
    const char* name;
    value_type_t type;
    uint16_t count;  ///< >= 1.
    uint32_t offset; ///< [octets] from the start of the published storage.
} parameter_field_t;

typedef struct { // Generated; constant.
    const char* name;
    uint32_t id; ///< See PARAMETER_ID.
    const parameter_field_t* fields;
    uint16_t field_count;
    uint32_t memory_size; ///< sizeof the published storage [octets].
    uint32_t wire_size;   ///< Sum of the fields on the wire [octets].
} parameter_definition_t;

typedef struct { // Bounds of one field; -DBL_MAX and DBL_MAX if the descriptor specifies none.
    double min;
    double max;
} parameter_bounds_t;

typedef struct { // Provided by the caller, who may read the fields, but not write them.
    const parameter_definition_t* definition;
    void* storage;
    parameter_bounds_t* bounds; ///< One per field.
    bool is_settable;
    /// Successful writes from the wire [calls, wraps]; the owner can compare it to detect a change.
    uint32_t writes;
    // Private: entries whose ids have the same hash form a list. In entry i, `first_of_id` is the first entry
    // of the list of hash i, and `next_of_id` the entry after i in its own list; UINT16_MAX: none.
    uint16_t first_of_id;
    uint16_t next_of_id;
} parameter_entry_t;

typedef struct {           // Refusals [calls, wraps], for telemetry.
    uint32_t unknown;      ///< No such id.
    uint32_t read_only;    ///< Write to a parameter that is not settable.
    uint32_t out_of_range; ///< Write outside the bounds, or not a finite number.
    uint32_t malformed;    ///< Write with too few octets, or with a BOOL that is neither 0 nor 1.
    uint32_t no_room;      ///< Read that did not fit the buffer, or publishing beyond the capacity.
} parameter_refusals_t;

typedef struct { // All fields are private, except `count` and `refusals`, which are read-only.
    parameter_entry_t* entries;
    uint16_t capacity;
    uint16_t count;
    parameter_bounds_t* bounds;
    uint16_t bounds_capacity;
    uint16_t bounds_used;
    osal_mutex_t mutex;
    uint32_t sequence_counter; // Odd while values may change.
    parameter_refusals_t refusals;
} parameter_dictionary_t;

/// Make an empty dictionary. capacity >= 1. `bounds` has room for the fields of all parameters together.
/// STATUS_OK, STATUS_UNSUPPORTED (no mutex on this port).
MUST_USE status_t parameter_init(parameter_dictionary_t* dictionary, parameter_entry_t* entries,
                                 uint16_t capacity, parameter_bounds_t* bounds, uint16_t bounds_capacity);

/// Publish a structure. The parameter is not settable and has no bounds; its content does not change.
/// STATUS_OK; STATUS_EXISTS (id or name taken); STATUS_EXHAUSTED (entries or bounds used up).
MUST_USE status_t parameter_publish(parameter_dictionary_t* dictionary,
                                    const parameter_definition_t* definition, void* storage);
/// Withdraw every parameter (SOFTWARE_DEINIT); entries that were found earlier become invalid; `refusals`
/// keeps its counts.
void parameter_withdraw_all(parameter_dictionary_t* dictionary);

/// Find the entry of an id; it is valid until parameter_withdraw_all. STATUS_OK, STATUS_NOT_FOUND.
MUST_USE status_t parameter_find(parameter_dictionary_t* dictionary, uint32_t id,
                                 const parameter_entry_t** out_entry);

/// Set the properties that the descriptor specifies. STATUS_OK, STATUS_NOT_FOUND (id or field name).
MUST_USE status_t parameter_set_settable(parameter_dictionary_t* dictionary, uint32_t id, bool is_settable);
MUST_USE status_t parameter_set_bounds(parameter_dictionary_t* dictionary, uint32_t id, const char* field,
                                       double min, double max);
/// Set the initial values of one field from text with exactly `count` numbers ("0 0"), which must be within
/// the bounds; null: all zero, whatever the bounds. is_settable is not checked. After a failure the field is
/// unchanged. STATUS_OK, STATUS_NOT_FOUND, STATUS_INVALID, STATUS_OUT_OF_RANGE.
MUST_USE status_t parameter_set_initial(parameter_dictionary_t* dictionary, uint32_t id, const char* field,
                                        const char* text);

/// Append the complete parameter to the writer. STATUS_OK; STATUS_NOT_FOUND; STATUS_TOO_LARGE (nothing is
/// written, and `failed` of the writer is not set).
MUST_USE status_t parameter_read(parameter_dictionary_t* dictionary, uint32_t id, octet_writer_t* writer);
/// Like parameter_read, for an entry that was found earlier; housekeeping uses it in each cycle. STATUS_OK,
/// STATUS_TOO_LARGE.
MUST_USE status_t parameter_read_entry(parameter_dictionary_t* dictionary, const parameter_entry_t* entry,
                                       octet_writer_t* writer);

/// Set the complete parameter from the wire. After STATUS_OK all fields are set and the reader is past
/// them; otherwise neither the fields nor the reader change.
/// STATUS_OK, STATUS_NOT_FOUND, STATUS_READ_ONLY, STATUS_TRUNCATED, STATUS_INVALID, STATUS_OUT_OF_RANGE.
MUST_USE status_t parameter_write(parameter_dictionary_t* dictionary, uint32_t id, octet_reader_t* reader);

/// Lock the content, while its owner updates it or another module of the same component reads it in place.
void parameter_lock(parameter_dictionary_t* dictionary);
void parameter_unlock(parameter_dictionary_t* dictionary);

#endif // FSW_FRAMEWORK_PARAMETER_PARAMETER_H
