// SPDX-License-Identifier: Apache-2.0
/// Checks of pools and quotas in test builds (RESOURCE_CHECKS, set with SANITIZE=1); flight builds do not
/// have them. Free blocks contain a pattern: a write after release is detected when the block is taken again.
/// The n-th take of the program can be made to fail, so that a test reaches every refusal.
///
/// Context    One task of a program, because the program has one count.
#ifndef BASE_TAKE_CHECK_H
#define BASE_TAKE_CHECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef RESOURCE_CHECKS
#define TAKES_ARE_CHECKED true

/// Refuse the take with this number. Takes are counted from this call on, beginning with 1; 0: refuse none.
/// Only the first 8 takes of each pool and quota are counted, so that the numbers reach every pool even if
/// one pool is used for each packet.
void take_check_refuse(uint32_t number);
/// Returns the number of takes counted since take_check_refuse, or since the start.
uint32_t take_check_count(void);

/// Pools and quotas call this for each take; `owner` is the pool or quota. True if this take must be refused.
bool take_check_is_refused(const void* owner);
/// Write the pattern into a free block; true if the block still contains it.
void take_check_mark(uint64_t* block, size_t words);
bool take_check_is_marked(const uint64_t* block, size_t words);

#else
#define TAKES_ARE_CHECKED false

static inline bool take_check_is_refused(const void* const owner)
{
    (void)owner;
    return false;
}

static inline void take_check_mark(uint64_t* const block, const size_t words)
{
    (void)block;
    (void)words;
}

static inline bool take_check_is_marked(const uint64_t* const block, const size_t words)
{
    (void)block;
    (void)words;
    return true;
}

#endif

#endif // BASE_TAKE_CHECK_H
