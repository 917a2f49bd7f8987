// SPDX-License-Identifier: Apache-2.0
// System calls of the C library of a board, for tests only: Unity prints on the console of the operating
// system layer, and formatting numbers allocates memory. Flight software does not call them. The port has no
// heap, so this file has one for what a test allocates (--wrap in mk/tests.mk).
#include "osal/freertos/semihosting.h"
#include "osal/include/osal/clock.h"
#include "osal/include/osal/console.h"

#include <reent.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/time.h>

#define HEAP_OCTETS 262144U
#define TEXT_OCTETS 128U
#define ABORTED 134 // Exit code that a shell reports after SIGABRT.

int _write(int descriptor, const char* text, int size);
int _read(int descriptor, char* text, int size);
int _close(int descriptor);
int _fstat(int descriptor, struct stat* about);
int _isatty(int descriptor);
int _lseek(int descriptor, int offset, int origin);
int _kill(int process, int number);
int _getpid(void);
int _gettimeofday(struct timeval* now, void* zone);
void* _sbrk(ptrdiff_t octets);
void _exit(int code);
void* __wrap_malloc(size_t octets);
void* __wrap_calloc(size_t count, size_t octets);
void* __wrap_realloc(void* block, size_t octets);
void __wrap_free(void* block);

static uint8_t heap[HEAP_OCTETS] __attribute__((aligned(8)));
static size_t heap_taken;

int _write(const int descriptor, const char* const text, const int size)
{
    char piece[TEXT_OCTETS];
    (void)descriptor;
    for (int done = 0; done < size;) {
        size_t count = 0U;
        while ((done < size) && (count < (TEXT_OCTETS - 1U))) {
            piece[count] = text[done];
            count++;
            done++;
        }
        piece[count] = '\0';
        osal_console_print(piece);
    }
    return size;
}

int _read(const int descriptor, char* const text, const int size)
{
    (void)descriptor;
    (void)text;
    (void)size;
    return 0;
}

int _close(const int descriptor)
{
    (void)descriptor;
    return -1;
}

/// Report a character device, so that the C library writes each line at once.
int _fstat(const int descriptor, struct stat* const about)
{
    (void)descriptor;
    about->st_mode = S_IFCHR;
    return 0;
}

int _isatty(const int descriptor)
{
    (void)descriptor;
    return 1;
}

int _lseek(const int descriptor, const int offset, const int origin)
{
    (void)descriptor;
    (void)offset;
    (void)origin;
    return 0;
}

/// Called by abort().
int _kill(const int process, const int number)
{
    (void)process;
    (void)number;
    semihosting_exit(ABORTED);
}

int _getpid(void)
{
    return 1;
}

int _gettimeofday(struct timeval* const now, void* const zone)
{
    const uint64_t now_us = osal_clock_monotonic_ns() / 1000U;
    (void)zone;
    now->tv_sec  = (time_t)(now_us / 1000000U);
    now->tv_usec = (suseconds_t)(now_us % 1000000U);
    return 0;
}

void* _sbrk(const ptrdiff_t octets)
{
    uint8_t* const place = &heap[heap_taken];
    if ((octets < 0) || ((size_t)octets > (HEAP_OCTETS - heap_taken))) {
        return (void*)-1;
    }
    heap_taken += (size_t)octets;
    return place;
}

void _exit(const int code)
{
    semihosting_exit(code);
}

void* __wrap_malloc(const size_t octets)
{
    return _malloc_r(_REENT, octets);
}

void* __wrap_calloc(const size_t count, const size_t octets)
{
    return _calloc_r(_REENT, count, octets);
}

void* __wrap_realloc(void* const block, const size_t octets)
{
    return _realloc_r(_REENT, block, octets);
}

void __wrap_free(void* const block)
{
    _free_r(_REENT, block);
}
