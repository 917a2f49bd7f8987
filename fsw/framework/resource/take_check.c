// SPDX-License-Identifier: Apache-2.0
#include "fsw/framework/resource/take_check.h"

#ifdef RESOURCE_CHECKS

#define FREE_PATTERN 0xFEEDFA11DEADB10CULL

static uint32_t count;
static uint32_t refused;

void take_check_refuse(const uint32_t number)
{
    count   = 0U;
    refused = number;
}

uint32_t take_check_count(void)
{
    return count;
}

bool take_check_is_refused(void)
{
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
