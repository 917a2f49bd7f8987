// SPDX-License-Identifier: Apache-2.0
#include "osal/freertos/semihosting.h"

#include <string.h>

typedef enum {
    CALL_OPEN         = 0x01,
    CALL_CLOSE        = 0x02,
    CALL_PRINT        = 0x04,
    CALL_WRITE        = 0x05,
    CALL_READ         = 0x06,
    CALL_SEEK         = 0x0A,
    CALL_SIZE         = 0x0C,
    CALL_REMOVE       = 0x0E,
    CALL_RENAME       = 0x0F,
    CALL_ERROR        = 0x13,
    CALL_COMMAND_LINE = 0x15,
    CALL_EXIT         = 0x20
} call_t;

#define EXIT_OF_APPLICATION 0x20026U // ADP_Stopped_ApplicationExit of the semihosting specification of Arm.

static int call(const call_t operation, const void* const arguments)
{
    register uint32_t r0 __asm__("r0") = (uint32_t)operation;
    register uint32_t r1 __asm__("r1") = (uint32_t)(uintptr_t)arguments;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return (int)r0;
}

static uint32_t word(const void* const address)
{
    return (uint32_t)(uintptr_t)address;
}

int semihosting_open(const char* const path, const semihosting_mode_t mode)
{
    const uint32_t arguments[] = {word(path), (uint32_t)mode, (uint32_t)strlen(path)};
    return call(CALL_OPEN, arguments);
}

void semihosting_close(const int handle)
{
    const uint32_t arguments[] = {(uint32_t)handle};
    (void)call(CALL_CLOSE, arguments);
}

int semihosting_read(const int handle, void* const octets, const size_t capacity)
{
    const uint32_t arguments[] = {(uint32_t)handle, word(octets), (uint32_t)capacity};
    const int missing          = call(CALL_READ, arguments); // Octets that were not read.
    return ((missing >= 0) && ((size_t)missing <= capacity)) ? (int)(capacity - (size_t)missing) : -1;
}

bool semihosting_write(const int handle, const void* const octets, const size_t size)
{
    const uint8_t* next = octets;
    size_t rest         = size;
    while (rest > 0U) {
        const uint32_t arguments[] = {(uint32_t)handle, word(next), (uint32_t)rest};
        const int missing          = call(CALL_WRITE, arguments); // Octets that were not written.
        if ((missing < 0) || ((size_t)missing >= rest)) {
            return false;
        }
        next = &next[rest - (size_t)missing];
        rest = (size_t)missing;
    }
    return true;
}

bool semihosting_seek(const int handle, const uint32_t offset)
{
    const uint32_t arguments[] = {(uint32_t)handle, offset};
    return call(CALL_SEEK, arguments) == 0;
}

int32_t semihosting_size(const int handle)
{
    const uint32_t arguments[] = {(uint32_t)handle};
    return (int32_t)call(CALL_SIZE, arguments);
}

bool semihosting_remove(const char* const path)
{
    const uint32_t arguments[] = {word(path), (uint32_t)strlen(path)};
    return call(CALL_REMOVE, arguments) == 0;
}

bool semihosting_rename(const char* const path, const char* const new_path)
{
    const uint32_t arguments[] = {word(path), (uint32_t)strlen(path), word(new_path),
                                  (uint32_t)strlen(new_path)};
    return call(CALL_RENAME, arguments) == 0;
}

int semihosting_error(void)
{
    return call(CALL_ERROR, NULL);
}

void semihosting_print(const char* const text)
{
    (void)call(CALL_PRINT, text);
}

bool semihosting_command_line(char* const line, const size_t capacity)
{
    uint32_t arguments[] = {word(line), (uint32_t)capacity};
    line[0]              = '\0';
    return call(CALL_COMMAND_LINE, arguments) == 0;
}

void semihosting_exit(const int code)
{
    const uint32_t arguments[] = {EXIT_OF_APPLICATION, (uint32_t)code};
    for (;;) {
        (void)call(CALL_EXIT, arguments);
    }
}
