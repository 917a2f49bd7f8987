// SPDX-License-Identifier: Apache-2.0
#include "osal/posix/object_name.h"

#include <stddef.h>
#include <string.h>

#define NAME_LENGTH_MAX 60U

bool object_name_is_valid(const char* const name)
{
    static const char allowed[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-";
    const size_t length         = strlen(name);
    return (length >= 2U) && (length <= (NAME_LENGTH_MAX + 1U)) && (name[0] == '/') &&
           (strspn(&name[1], allowed) == (length - 1U)) && (strcmp(name, "/.") != 0) &&
           (strcmp(name, "/..") != 0);
}
