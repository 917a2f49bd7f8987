// SPDX-License-Identifier: Apache-2.0
#include "base/take_check.h"

#ifdef RESOURCE_CHECKS

#include <string.h>

#define FREE_PATTERN 0xFEEDFA11DEADB10CULL

#define ASKERS 128U
#define NUMBERED 8U

typedef struct {
    const void* asker;
    uint32_t count;
} takes_t;

static takes_t takes[ASKERS];
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

/// Number of takes of this caller, this one included.
static uint32_t takes_of(const void* const asker)
{
    for (size_t i = 0U; i < ASKERS; i++) {
        if ((takes[i].asker == asker) || (takes[i].asker == NULL)) {
            takes[i].asker = asker;
            takes[i].count++;
            return takes[i].count;
        }
    }
    return 1U; // The table is full: each take of a further caller counts as the first.
}

bool take_check_is_refused(const void* const asker)
{
    if (takes_of(asker) > NUMBERED) {
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

typedef int nothing_is_checked_in_flight; // A source file is not empty.

#endif
