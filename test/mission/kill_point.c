// SPDX-License-Identifier: Apache-2.0
// Preloaded into the supervisor: kills its first life at call n of the functions of the C library at the end
// of this file, which receive, send or write. KILL_POINT is 2 n to kill it before the call, and 2 n + 1 to
// kill it when the call returns. Without KILL_POINT no life is killed, and the number of calls is written
// into the file KILL_MARK.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <unistd.h>

static unsigned long calls;

static unsigned long number(const char* name)
{
    const char* const text = getenv(name);
    return (text != NULL) ? strtoul(text, NULL, 10) : 0UL;
}

/// True in the first life, which makes the file KILL_MARK; the next lives find it.
static int is_first_life(void)
{
    static int answer = -1;
    if (answer < 0) {
        answer = open(getenv("KILL_MARK"), O_CREAT | O_EXCL | O_WRONLY, 0644);
    }
    return answer >= 0;
}

__attribute__((constructor)) static void begin(void)
{
    (void)is_first_life();
}

__attribute__((destructor)) static void end(void)
{
    FILE* const file = (number("KILL_POINT") == 0UL) ? fopen(getenv("KILL_MARK"), "w") : NULL;
    if (file != NULL) {
        (void)fprintf(file, "%lu\n", calls);
        (void)fclose(file);
    }
}

static void before(void)
{
    calls++;
    if ((calls == number("KILL_POINT") / 2UL) && ((number("KILL_POINT") % 2UL) == 0UL) && is_first_life()) {
        (void)kill(getpid(), SIGKILL);
    }
}

static void after(void)
{
    if ((calls == number("KILL_POINT") / 2UL) && ((number("KILL_POINT") % 2UL) != 0UL) && is_first_life()) {
        (void)kill(getpid(), SIGKILL);
    }
}

#define CALL(result, name, parameters, arguments)                                                            \
    result name parameters                                                                                   \
    {                                                                                                        \
        result(*next) parameters;                                                                            \
        *(void**)&next = dlsym(RTLD_NEXT, #name);                                                            \
        before();                                                                                            \
        const result value = next arguments;                                                                 \
        after();                                                                                             \
        return value;                                                                                        \
    }

CALL(ssize_t, write, (int descriptor, const void* octets, size_t size), (descriptor, octets, size))
CALL(ssize_t, pwrite, (int descriptor, const void* octets, size_t size, off_t offset),
     (descriptor, octets, size, offset))
CALL(int, ftruncate, (int descriptor, off_t size), (descriptor, size))
CALL(int, fsync, (int descriptor), (descriptor))
CALL(ssize_t, recv, (int descriptor, void* octets, size_t size, int flags), (descriptor, octets, size, flags))
CALL(ssize_t, recvmsg, (int descriptor, struct msghdr* message, int flags), (descriptor, message, flags))
CALL(ssize_t, sendto,
     (int descriptor, const void* octets, size_t size, int flags, const struct sockaddr* to,
      socklen_t to_size),
     (descriptor, octets, size, flags, to, to_size))
