// SPDX-License-Identifier: Apache-2.0
/// The port by which services store persistent data: records by table and key; a new record replaces the
/// previous one. A commit makes the changes since the last commit persistent, all of them or none. The
/// dispatcher commits after each request, before it reports completion, so that acknowledged changes are
/// persistent; a service that changes records in its step commits itself.
///
/// At start the owner passes each record to the service of its table, in the order in which they were last
/// put. If a service cannot use a record, it returns an error status; the owner counts and reports it. A
/// damaged record must not make an assertion fail.
#ifndef PUS_CORE_PERSISTENCE_H
#define PUS_CORE_PERSISTENCE_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

#define PUS_RECORD_MAX 8192U ///< Largest record [octets].

typedef struct {
    void* context;
    /// Store a record; `octets` is copied. STATUS_OK; STATUS_FULL (no room), STATUS_TOO_LARGE or STATUS_IO:
    /// the previous record stays.
    status_t (*put)(void* context, uint8_t table, uint32_t key, const uint8_t* octets, size_t size);
    /// Erase a record. STATUS_OK, STATUS_NOT_FOUND, STATUS_IO.
    status_t (*erase)(void* context, uint8_t table, uint32_t key);
    /// Make all changes persistent. STATUS_OK; STATUS_IO: a power cut may undo the changes since the last
    /// commit.
    status_t (*commit)(void* context);
} pus_persistence_t;

#endif // PUS_CORE_PERSISTENCE_H
