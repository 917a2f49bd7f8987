// SPDX-License-Identifier: Apache-2.0
/// The port by which services keep what must outlive a power cut: records by table and key, where a record
/// replaces the one before it. What was put and erased since the last commit becomes lasting with the next
/// one, all of it or nothing. The dispatcher commits after each request, before it is reported completed, so
/// that what was acknowledged is lasting; a service that changes records in its step commits itself.
///
/// At start the owner reads the records back and hands each to the service its table belongs to, in the order
/// in which they were last put; the service takes it without a request and refuses what it cannot use with a
/// status, which is counted and told, never asserted.
#ifndef PUS_CORE_PERSISTENCE_H
#define PUS_CORE_PERSISTENCE_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

#define PUS_RECORD_MAX 8192U ///< Largest record [octets].

typedef struct {
    void* context;
    /// Keep a record; `octets` is copied. STATUS_OK; STATUS_FULL (no room), STATUS_TOO_LARGE,
    /// STATUS_IO: nothing changed.
    status_t (*put)(void* context, uint8_t table, uint32_t key, const uint8_t* octets, size_t size);
    /// Forget a record. STATUS_OK, STATUS_NOT_FOUND, STATUS_IO.
    status_t (*erase)(void* context, uint8_t table, uint32_t key);
    /// Make it last. STATUS_OK, STATUS_IO: nothing since the last commit is sure to last.
    status_t (*commit)(void* context);
} pus_persistence_t;

#endif // PUS_CORE_PERSISTENCE_H
