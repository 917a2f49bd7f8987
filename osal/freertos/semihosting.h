// SPDX-License-Identifier: Apache-2.0
/// Semihosting of Arm: the debugger, or an emulator, serves files, console and end of a program.
#ifndef OSAL_FREERTOS_SEMIHOSTING_H
#define OSAL_FREERTOS_SEMIHOSTING_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum { // Modes of fopen: "rb", "r+b", "wb", "w+b", "ab".
    SEMIHOSTING_READ    = 1,
    SEMIHOSTING_UPDATE  = 3,
    SEMIHOSTING_WRITE   = 5,
    SEMIHOSTING_REWRITE = 7,
    SEMIHOSTING_APPEND  = 9
} semihosting_mode_t;

/// Handle, or -1 (the error: semihosting_error).
int semihosting_open(const char* path, semihosting_mode_t mode);
void semihosting_close(int handle);
/// Number of octets read, 0 at the end, -1 on an error. A pipe: waits for the first octet.
int semihosting_read(int handle, void* octets, size_t capacity);
/// True if all octets are written.
bool semihosting_write(int handle, const void* octets, size_t size);
bool semihosting_seek(int handle, uint32_t offset);
/// Size of a file, or -1.
int32_t semihosting_size(int handle);
bool semihosting_remove(const char* path);
bool semihosting_rename(const char* path, const char* new_path);
/// errno of the last call that failed, in the numbers of Linux.
int semihosting_error(void);
void semihosting_print(const char* text);
/// False if it does not fit.
bool semihosting_command_line(char* line, size_t capacity);
void semihosting_exit(int code) __attribute__((noreturn));

#endif // OSAL_FREERTOS_SEMIHOSTING_H
