// SPDX-License-Identifier: Apache-2.0
/// Two media in memory that record every write, so that a test can cut the power at any of them: any part of
/// what was not synced yet may be missing, and any write may be torn. The test can inject errors.
#ifndef TEST_SUPPORT_RECORDED_MEDIA_H
#define TEST_SUPPORT_RECORDED_MEDIA_H

#include "base/medium.h"

#include <stdbool.h>

#define MEDIUM_MAX 131072U   ///< Largest medium [octets].
#define OPERATIONS_MAX 8192U ///< Recorded since the last recorded_clear.

typedef struct {
    uint8_t octets[MEDIUM_MAX];
    size_t size;
} image_t;

typedef enum {
    OPERATION_WRITE,
    OPERATION_RESIZE,
    OPERATION_SYNC,
    OPERATION_LOST ///< A failed sync.
} operation_kind_t;

typedef struct {
    operation_kind_t kind;
    size_t medium;
    size_t offset; ///< Offset of a write, or new size.
    size_t size;   ///< Octets written.
    size_t data;   ///< Offset of these octets in recorded.data.
    unsigned mark; ///< Value of recorded.mark at the time of the operation.
} operation_t;

typedef struct {
    image_t image[2];
    image_t durable[2]; ///< Content when the recording began.
    size_t count;
    operation_t operations[OPERATIONS_MAX];
    size_t data_size;
    uint8_t data[1U << 21U];
    unsigned mark;      ///< Set by the test and stored with each operation.
    unsigned calls;     ///< Number of calls of any kind, reads included, since the last clear.
    unsigned fail_from; ///< The call of this number and `fail_count` - 1 after it fail; 0: none.
    unsigned fail_count;
    const image_t* failing; ///< Only calls of the medium with this image fail; null: calls of both.
    status_t failure;       ///< Status that failing calls return.
    size_t torn;            ///< Octets that a failing write still writes.
} recorded_t;

extern recorded_t recorded;

medium_t recorded_medium(size_t index);
/// Begin a new recording on media with the content of `images`, as after the power is restored.
void recorded_clear(const image_t images[2]);
/// Apply an operation to its image; of a write, the first `size` octets.
void recorded_apply(const operation_t* operation, size_t size, image_t images[2]);
/// Get the guaranteed content of the media, which is only what was synced. A failed sync loses what was
/// written before it, although it can still be read.
void recorded_durable(image_t images[2]);
/// Copy both media.
void recorded_copy(image_t to[2], const image_t from[2]);

#endif // TEST_SUPPORT_RECORDED_MEDIA_H
