// SPDX-License-Identifier: Apache-2.0
/// Semihosting of Arm: the debugger or the emulator serves files and the console, and ends the program. A
/// function that returns bool returns false on an error.
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

/// Open a file. Returns its handle, or -1 (semihosting_error has the reason).
int semihosting_open(const char* path, semihosting_mode_t mode);
void semihosting_close(int handle);
/// Read. Returns the number of octets read, 0 at the end of the file, -1 on an error. On a pipe it waits for
/// the first octet.
int semihosting_read(int handle, void* octets, size_t capacity);
/// Write all octets.
bool semihosting_write(int handle, const void* octets, size_t size);
bool semihosting_seek(int handle, uint32_t offset);
/// Returns the size of a file [octets], or -1 on an error.
int32_t semihosting_size(int handle);
bool semihosting_remove(const char* path);
bool semihosting_rename(const char* path, const char* new_path);
/// errno of the last call that failed, with the numbers of Linux.
int semihosting_error(void);
void semihosting_print(const char* text);
/// Copy the command line to `line`. False if it does not fit.
bool semihosting_command_line(char* line, size_t capacity);
void semihosting_exit(int code) __attribute__((noreturn));

#endif // OSAL_FREERTOS_SEMIHOSTING_H
