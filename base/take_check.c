// SPDX-License-Identifier: Apache-2.0
#include "base/take_check.h"

#ifdef RESOURCE_CHECKS

#include <string.h>

#define FREE_PATTERN 0xFEEDFA11DEADB10CULL

#define OWNERS 128U // Largest number of pools and quotas of one program that are counted separately.
#define NUMBERED 8U // Takes of each owner that are counted.

typedef struct {
    const void* owner;
    uint32_t count;
} takes_t;

static takes_t takes[OWNERS];
static uint32_t count;
static uint32_t refused;

void take_check_refuse(const uint32_t number)
{
    (void)memset(takes, 0, sizeof takes);
    count   = 0U;
    refused = number;
}

uint32_t take_check_count(void)
{
    return count;
}

/// Count a take of this owner. Returns the number of its takes, this one included.
static uint32_t takes_of(const void* const owner)
{
    for (size_t i = 0U; i < OWNERS; i++) {
        if ((takes[i].owner == owner) || (takes[i].owner == NULL)) {
            takes[i].owner = owner;
            takes[i].count++;
            return takes[i].count;
        }
    }
    return 1U; // The table is full: every take of a further owner counts as its first.
}

bool take_check_is_refused(const void* const owner)
{
    if (takes_of(owner) > NUMBERED) {
        return false;
    }
    count++;
    return count == refused;
}

void take_check_mark(uint64_t* const block, const size_t words)
{
    for (size_t i = 0U; i < words; i++) {
        block[i] = FREE_PATTERN;
    }
}

bool take_check_is_marked(const uint64_t* const block, const size_t words)
{
    for (size_t i = 0U; i < words; i++) {
        if (block[i] != FREE_PATTERN) {
            return false;
        }
    }
    return true;
}

#else

typedef int take_check_is_empty_in_flight; // C99 requires a declaration in each source file.

#endif
