// SPDX-License-Identifier: Apache-2.0
/// Persistent records of one component: a journal on two files in the run's storage directory. A flight with
/// the storage of an earlier flight (hirosco run --storage) finds its records there.
///
/// A commit waits for the disk if the store is opened with `waits`. Otherwise acknowledged records survive a
/// crash of the program immediately, but a power cut only after the operating system has written them to the
/// disk. Subsystems in real time do not wait, because the disk must not delay them (docs/decisions/0026).
///
/// Damaged media (fsw/framework/journal/journal.h) are copied to
/// `<storage>/<component>.journal.<n>.damaged.<m>`, m 0 to RECORD_STORE_COPIES - 1, before the journal
/// continues with their intact records. If all copies exist, the last one is replaced. The program reports it
/// on the console; the component reports it to the ground.
///
/// Ownership  The program provides store and slots (static).
/// Context    The component's loop.
#ifndef FSW_PROGRAMS_RECORD_STORE_H
#define FSW_PROGRAMS_RECORD_STORE_H

#include "fsw/programs/component_runtime.h"
#include "fsw/framework/journal/journal.h"
#include "osal/include/osal/file.h"

// A build for a target with a small medium defines all three.
#ifndef RECORD_STORE_LIMIT
#define RECORD_STORE_LIMIT (64U * 1024U * 1024U) ///< Largest size of each file [octets].
#define RECORD_STORE_SLACK (1024U * 1024U) ///< A commit compacts if dead octets exceed live ones by this.
#define RECORD_STORE_MOVES 0U              ///< A commit compacts at once; see journal_configuration_t.
#endif
#define RECORD_STORE_COPIES 4U ///< Number of copies of each damaged medium.

/// Function that returns the medium through which the journal accesses `medium`, its first or second one.
/// With `open` null, the journal accesses both directly.
typedef struct {
    void* context;
    medium_t (*open)(void* context, unsigned index, medium_t medium);
} record_store_wrapper_t;

typedef struct { // Private, except `journal`, and `wrapper`, which is set before the store is opened.
    const component_runtime_t* runtime;
    record_store_wrapper_t wrapper;
    osal_file_t files[2];
    journal_t journal;
} record_store_t;

/// Open `<storage>/<component>.journal.0` and `.1`, and create them if they are missing. The journal has
/// room for `capacity` records, in JOURNAL_SLOTS(capacity) slots. STATUS_OK; for other statuses the
/// runtime's `error` contains the reason, and the store stays closed: STATUS_NOT_FOUND, STATUS_DENIED,
/// STATUS_BUSY (another flight uses the files), STATUS_FULL, STATUS_IO, STATUS_EXHAUSTED (more records than
/// slots), STATUS_TOO_LARGE (path), STATUS_UNSUPPORTED (the system cannot force the names of files to the
/// disk).
MUST_USE status_t record_store_open(record_store_t* store, component_runtime_t* runtime,
                                    journal_slot_t* slots, size_t capacity, bool waits);
void record_store_close(record_store_t* store);
/// Copy other damaged data to `<storage>/<component>.<kind>.damaged.<m>`, in the same way as media. True if
/// the copy was made.
MUST_USE bool record_store_keep(const component_runtime_t* runtime, const char* kind, const uint8_t* octets,
                                size_t size);

#endif // FSW_PROGRAMS_RECORD_STORE_H
