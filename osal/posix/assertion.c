// SPDX-License-Identifier: Apache-2.0
#include "base/assertion.h"

#include <stdlib.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

/// Returns one part of the line. memcpy removes the const of the text, to which writev does not write.
static struct iovec part_of(const char* const text)
{
    struct iovec part;
    const char* const source = (text != NULL) ? text : "?";
    (void)memcpy(&part.iov_base, &source, sizeof source);
    part.iov_len = strlen(source);
    return part;
}

void fsw_assertion_failed(const char* const file, const int line)
{
    char digits[12];
    size_t at     = sizeof digits - 1U;
    digits[at]    = '\0';
    unsigned rest = (line > 0) ? (unsigned)line : 0U;
    do {
        at--;
        digits[at] = (char)('0' + (char)(rest % 10U));
        rest /= 10U;
    } while ((rest != 0U) && (at > 0U));

    const struct iovec parts[] = {part_of(file), part_of(":"), part_of(&digits[at]),
                                  part_of(": assertion failed\n")};
    // If the write fails, too, there is no other way to report: the program ends in both cases.
    if (writev(STDERR_FILENO, parts, (int)(sizeof parts / sizeof parts[0])) < 0) {
        abort();
    }
    abort();
}
