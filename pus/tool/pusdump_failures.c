// SPDX-License-Identifier: Apache-2.0
#include "pus/tool/pusdump_messages.h"

#include "generated/pus/failure_words.h"

const char* failure_words(const uint16_t code)
{
    for (size_t i = 0U; i < (sizeof pus_failure_words / sizeof pus_failure_words[0]); i++) {
        if (pus_failure_words[i].code == code) {
            return pus_failure_words[i].words;
        }
    }
    return "unknown failure";
}
