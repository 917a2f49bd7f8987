// SPDX-License-Identifier: Apache-2.0
#define _GNU_SOURCE
#include "osal/include/osal/console.h"

#include "base/assertion.h"

#include <errno.h>
#include <poll.h>
#include <stddef.h>
#include <string.h>
#include <sys/uio.h>
#include <unistd.h>

#define TIMEOUT_MS 100 ///< Text for a reader that takes nothing for this time is lost [ms].

/// Write text and line end in one call. Text that a full pipe does not accept within TIMEOUT_MS is dropped,
/// because a program in flight must not wait for its console.
static void put(const int descriptor, const char* const text, const char* const line_end)
{
    FSW_ASSERT(text != NULL);
    struct iovec parts[2];
    struct pollfd watched = {.fd = descriptor, .events = POLLOUT};
    (void)memcpy(&parts[0].iov_base, &text, sizeof text); // Removes the const: writev only reads the text.
    parts[0].iov_len = strlen(text);
    (void)memcpy(&parts[1].iov_base, &line_end, sizeof line_end);
    parts[1].iov_len = strlen(line_end);
    size_t rest      = parts[0].iov_len + parts[1].iov_len;
    while ((rest > 0U) && (poll(&watched, 1U, TIMEOUT_MS) > 0)) {
        const ssize_t size = writev(descriptor, parts, 2);
        if (size < 0) {
            if ((errno == EINTR) || (errno == EAGAIN)) {
                continue;
            }
            return;
        }
        rest -= (size_t)size;
        const size_t first = ((size_t)size < parts[0].iov_len) ? (size_t)size : parts[0].iov_len;
        parts[0].iov_base  = (char*)parts[0].iov_base + first;
        parts[0].iov_len -= first;
        parts[1].iov_base = (char*)parts[1].iov_base + ((size_t)size - first);
        parts[1].iov_len -= (size_t)size - first;
    }
}

void osal_console_print_line(const char* const line)
{
    put(STDOUT_FILENO, line, "\n");
}

void osal_console_print_error(const char* const line)
{
    put(STDERR_FILENO, line, "\n");
}

void osal_console_print(const char* const text)
{
    put(STDOUT_FILENO, text, "");
}

bool osal_console_is_terminal(void)
{
    return isatty(STDOUT_FILENO) == 1;
}
