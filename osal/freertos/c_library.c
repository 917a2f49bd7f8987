// SPDX-License-Identifier: Apache-2.0
// Functions of the C library to which linked code refers. expat refers to malloc and the like for callers
// that pass no memory functions, and to the others for messages that are switched off. This port has no heap,
// no streams and no environment: requests for memory fail, and expat checks for that.
#include "osal/freertos/port.h"
#include "osal/freertos/semihosting.h"
#include "osal/include/osal/clock.h"

#define ABORTED 134 // Exit code that a shell reports for SIGABRT.
#define NS_PER_S 1000000000ULL
#define NS_PER_US 1000ULL

typedef struct {
    int64_t seconds;
    int32_t microseconds;
} time_of_day_t;

void* malloc(size_t octets);
void* calloc(size_t count, size_t octets);
void* realloc(void* block, size_t octets);
void free(void* block);
void abort(void) __attribute__((noreturn));
void __assert_func(const char* file, int line, const char* function, const char* text)
    __attribute__((noreturn));
char* getenv(const char* name);
int fprintf(void* stream, const char* format, ...);
int fputs(const char* text, void* stream);
int gettimeofday(time_of_day_t* now, void* zone);
int getpid(void);

void* malloc(const size_t octets)
{
    (void)octets;
    return NULL;
}

void* calloc(const size_t count, const size_t octets)
{
    (void)count;
    (void)octets;
    return NULL;
}

void* realloc(void* const block, const size_t octets)
{
    (void)block;
    (void)octets;
    return NULL;
}

void free(void* const block)
{
    (void)block;
}

void abort(void)
{
    port_exit(ABORTED);
}

void __assert_func(const char* const file, const int line, const char* const function, const char* const text)
{
    (void)line;
    (void)function;
    semihosting_print(file);
    semihosting_print(": assertion failed: ");
    semihosting_print(text);
    semihosting_print("\n");
    port_exit(ABORTED);
}

char* getenv(const char* const name)
{
    (void)name;
    return NULL;
}

int fprintf(void* const stream, const char* const format, ...)
{
    (void)stream;
    (void)format;
    return 0;
}

int fputs(const char* const text, void* const stream)
{
    (void)text;
    (void)stream;
    return 0;
}

int gettimeofday(time_of_day_t* const now, void* const zone)
{
    (void)zone;
    const uint64_t now_ns = osal_clock_monotonic_ns();
    *now                  = (time_of_day_t){.seconds      = (int64_t)(now_ns / NS_PER_S),
                                            .microseconds = (int32_t)((now_ns % NS_PER_S) / NS_PER_US)};
    return 0;
}

int getpid(void)
{
    return 1;
}
