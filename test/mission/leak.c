// SPDX-License-Identifier: Apache-2.0
// Preloaded into a subsystem's program: once the file LEAK_TRIGGER exists, it allocates all memory or opens
// all descriptors that it can get, and dies like a program with a leak. If no limit of the process stops it,
// it stops at the bounds PIECES_MAX and DESCRIPTORS_MAX and continues.
#define _GNU_SOURCE
#include <fcntl.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#define PIECE 262144U
#define PIECES_MAX 2000U ///< 500 MiB.
#define DESCRIPTORS_MAX 1000
#define STACK_OCTETS 65536U

static void take_memory(void)
{
    for (unsigned i = 0U; i < PIECES_MAX; i++) {
        void* const piece = malloc(PIECE);
        if (piece == NULL) {
            abort();
        }
        (void)memset(piece, 1, PIECE);
    }
}

static void take_descriptors(void)
{
    int last = 0;
    while (last < DESCRIPTORS_MAX) {
        last = open("/dev/null", O_RDONLY | O_CLOEXEC);
        if (last < 0) {
            abort();
        }
    }
}

static void* leak_when_triggered(void* context)
{
    while (unlink(LEAK_TRIGGER) != 0) {
        (void)usleep(1000U);
    }
    LEAK_KIND();
    return context;
}

__attribute__((constructor)) static void start_thread(void)
{
    // No core file: it would be as large as the limit allows.
    const struct rlimit none = {0, 0};
    pthread_t thread;
    pthread_attr_t small; // The usual stack of 8 MiB may not fit into the limit of the address space.
    (void)setrlimit(RLIMIT_CORE, &none);
    (void)pthread_attr_init(&small);
    (void)pthread_attr_setstacksize(&small, STACK_OCTETS);
    if (pthread_create(&thread, &small, leak_when_triggered, NULL) == 0) {
        (void)pthread_detach(thread);
    }
}
